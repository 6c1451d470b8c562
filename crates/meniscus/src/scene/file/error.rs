//! What can be wrong with a scene, and where it is written.

use std::ops::Range;

/// What kind of failure it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SceneErrorKind {
    /// The file cannot be read.
    Io,
    /// The text is not TOML or JSON.
    Syntax,
    /// A key that does not exist, or a value of the wrong type.
    Schema,
    /// A value that makes no sense, or a name that is not defined.
    Invalid,
    /// Something this version cannot do yet.
    Unsupported,
}

/// The place of an error in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt {
    /// Name of the text: the file's path, or the flag.
    pub name: String,
    /// The whole text.
    pub text: String,
    /// Bytes of `text` to point at; on character boundaries and within the text.
    pub span: Range<usize>,
}

impl Excerpt {
    /// An excerpt whose span is forced into the text.
    pub(super) fn new(name: &str, text: &str, span: Range<usize>) -> Self {
        let start = text.floor_char_boundary(span.start.min(text.len()));
        let end = text.ceil_char_boundary(span.end.clamp(start, text.len()));
        Self {
            name: name.to_owned(),
            text: text.to_owned(),
            span: start..end,
        }
    }

    /// Line and column (in characters) of the start, counted from 1.
    pub fn line_column(&self) -> (usize, usize) {
        let before = &self.text[..self.span.start];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.matches('\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }

    /// The text pointed at.
    pub fn pointed(&self) -> &str {
        &self.text[self.span.clone()]
    }
}

/// A scene that cannot be read or makes no sense.
///
/// Displayed on one line: place, message and help. A program that prints carets takes the parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneError {
    /// What kind of failure it is.
    pub kind: SceneErrorKind,
    /// What is wrong, without the place.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// The key, as `--set` takes it (`surface.0.kernel`); empty for the whole scene.
    pub key: String,
    /// Where it is written, when the scene came from a text.
    pub excerpt: Option<Box<Excerpt>>,
}

impl SceneError {
    pub(in crate::scene) fn new(kind: SceneErrorKind, message: impl Into<String>) -> Self {
        Self {
            kind,
            message: message.into(),
            help: None,
            key: String::new(),
            excerpt: None,
        }
    }

    #[must_use]
    pub(in crate::scene) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    #[must_use]
    pub(in crate::scene) fn at(mut self, key: impl Into<String>) -> Self {
        self.key = key.into();
        self
    }

    #[must_use]
    pub(super) fn pointing(mut self, name: &str, text: &str, span: Range<usize>) -> Self {
        self.excerpt = Some(Box::new(Excerpt::new(name, text, span)));
        self
    }
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(excerpt) = &self.excerpt {
            let (line, column) = excerpt.line_column();
            write!(f, "{}, line {line}, column {column}: ", excerpt.name)?;
        }
        f.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for SceneError {}
