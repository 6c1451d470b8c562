//! Content that we know but do not read as particles, and words for content that nobody knows.

use super::{Format, ParseError, Place};

/// A format that is recognised and refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Foreign {
    /// What the file is.
    pub(super) name: &'static str,
    /// Why that is no particle file for us.
    problem: &'static str,
    /// What to do about it.
    help: &'static str,
}

impl Foreign {
    /// The refusal as an error.
    pub(super) fn error(&self) -> ParseError {
        ParseError::new(Place::Whole, self.problem).with_help(self.help)
    }
}

/// The foreign format of `bytes`, if it is one of those we can name.
pub(super) fn recognise(bytes: &[u8]) -> Option<Foreign> {
    SIGNATURES
        .iter()
        .find(|(signature, _)| bytes.starts_with(signature))
        .map(|&(_, foreign)| foreign)
}

const fn packed(name: &'static str) -> Foreign {
    Foreign {
        name,
        problem: "compression is not read",
        help: "decompress the file, or use gzip",
    }
}

const SIGNATURES: &[(&[u8], Foreign)] = &[
    (b"\x28\xb5\x2f\xfd", packed("zstd")),
    (b"\xfd7zXZ\0", packed("xz")),
    (b"BZh", packed("bzip2")),
    (b"\x1f\x8b", packed("gzip within gzip")),
];

/// What unknown content looks like, and what would be read.
pub(super) fn describe(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "the file is empty".to_owned();
    }
    let start = &bytes[..bytes.len().min(24)];
    let printable = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let looks = if start.iter().all(printable) {
        let text = String::from_utf8_lossy(start);
        format!("text that starts with {:?}", text.trim_end())
    } else {
        let hex: Vec<String> = start[..start.len().min(12)]
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect();
        format!("binary data that starts with bytes {}", hex.join(" "))
    };
    let known: Vec<&str> = Format::ALL.iter().map(|format| format.name()).collect();
    format!(
        "not a particle file that we know: {} bytes of {looks}; read are {}, each also gzip-compressed",
        bytes.len(),
        known.join(", ")
    )
}
