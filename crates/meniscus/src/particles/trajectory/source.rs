//! A file that is read here and there, and never beyond its end.

use super::Span;
use crate::particles::io::ParseError;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Why a trajectory cannot be read.
#[derive(Debug)]
pub(super) enum Trouble {
    Io(io::Error),
    Parse(ParseError),
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<ParseError> for Trouble {
    fn from(error: ParseError) -> Self {
        Self::Parse(error)
    }
}

/// An open file.
pub(super) struct Source {
    file: File,
    length: u64,
}

impl Source {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length })
    }

    /// Bytes in the file.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Up to `bytes` bytes from the start.
    pub(super) fn head(&mut self, bytes: usize) -> io::Result<Vec<u8>> {
        let mut head = Vec::new();
        let file = &mut self.file;
        file.seek(SeekFrom::Start(0))?;
        file.take(bytes as u64).read_to_end(&mut head)?;
        Ok(head)
    }

    /// The `N` bytes at `start`; `None` where the file ends before.
    pub(super) fn array<const N: usize>(&mut self, start: u64) -> io::Result<Option<[u8; N]>> {
        if start
            .checked_add(N as u64)
            .is_none_or(|end| end > self.length)
        {
            return Ok(None);
        }
        let mut bytes = [0; N];
        self.file.seek(SeekFrom::Start(start))?;
        self.file.read_exact(&mut bytes)?;
        Ok(Some(bytes))
    }

    /// The bytes of a span that lies within the file.
    pub(super) fn bytes(&mut self, span: Span) -> io::Result<Vec<u8>> {
        let fits = span
            .start
            .checked_add(span.bytes)
            .is_some_and(|end| end <= self.length);
        if !fits {
            return Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "the file has become shorter since it was opened",
            ));
        }
        let mut bytes = vec![0; span.bytes as usize];
        self.file.seek(SeekFrom::Start(span.start))?;
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

/// Big-endian numbers, as XDR has them, one after the other.
pub(super) struct Xdr<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Xdr<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// Offset of the next number.
    pub(super) fn at(&self) -> u64 {
        self.at as u64
    }

    pub(super) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let array = *self.bytes.get(self.at..)?.first_chunk()?;
        self.at += N;
        Some(array)
    }

    pub(super) fn i32(&mut self) -> Option<i32> {
        self.array().map(i32::from_be_bytes)
    }

    pub(super) fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_be_bytes)
    }

    /// A float or a double.
    pub(super) fn real(&mut self, is_double: bool) -> Option<f64> {
        if is_double {
            self.array().map(f64::from_be_bytes)
        } else {
            self.f32().map(f64::from)
        }
    }

    pub(super) fn skip(&mut self, bytes: usize) {
        self.at = self.at.saturating_add(bytes);
    }

    /// What is left.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }
}
