//! What can be wrong with a particle file, and where.

use std::path::PathBuf;

/// A place within a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Offset in bytes from the start (of the decompressed file).
    Byte(u64),
    /// Line, counted from 1.
    Line(u64),
    /// The file as a whole.
    Whole,
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Byte(offset) => write!(f, "at byte {offset}: "),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Whole => Ok(()),
        }
    }
}

/// What a reader of bytes reports: it does not know the path.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}{problem}")]
pub struct ParseError {
    /// Where.
    pub place: Place,
    /// What was expected and what was found.
    pub problem: String,
    /// What the user can do, when there is more to say than "the file is damaged".
    pub help: Option<String>,
}

impl ParseError {
    /// An error at `place`.
    pub fn new(place: Place, problem: impl Into<String>) -> Self {
        Self {
            place,
            problem: problem.into(),
            help: None,
        }
    }

    /// The same error with advice.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A particle file that could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The content matches no format that we know.
    #[error("{path}: {problem}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// What it looks like.
        problem: String,
    },
    /// The content is damaged or not what the format allows.
    #[error("{path}: {format} {error}{}", help_suffix(error))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The format's name.
        format: &'static str,
        /// Where and what.
        error: ParseError,
    },
}

fn help_suffix(error: &ParseError) -> String {
    error
        .help
        .as_ref()
        .map_or_else(String::new, |help| format!(" ({help})"))
}
