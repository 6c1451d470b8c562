//! Words, counts and arrays of a legacy file, in either encoding.

use super::types::Kind;
use crate::particles::ColumnData;
use crate::particles::io::bytes::{Endian, Scalar};
use crate::particles::io::vtk_values::{Element, Fault, Words, excerpt, line_of};
use crate::particles::io::{ParseError, Place};

pub(super) struct Cursor<'a> {
    words: Words<'a>,
    /// Arrays are packed, big endian, and start behind the line feed of their header.
    pub(super) binary: bool,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(words: Words<'a>, binary: bool) -> Self {
        Self { words, binary }
    }

    /// An error at the current place: a line of ascii files, a byte of binary ones.
    pub(super) fn error(&self, problem: impl Into<String>) -> ParseError {
        self.error_at(self.words.position, problem)
    }

    fn error_at(&self, offset: usize, problem: impl Into<String>) -> ParseError {
        let place = if self.binary {
            Place::Byte(offset as u64)
        } else {
            line_of(self.words.bytes, offset)
        };
        ParseError::new(place, problem)
    }

    fn fault(&self, fault: Fault) -> ParseError {
        self.error_at(fault.offset, fault.problem)
    }

    /// The error of having just read `word` where something else should stand.
    pub(super) fn unexpected(&self, word: &[u8], expected: &str) -> ParseError {
        self.error_at(
            self.words.position.saturating_sub(word.len()),
            format!("expected {expected}, found {}", excerpt(word)),
        )
    }

    pub(super) fn peek(&self) -> Option<&'a [u8]> {
        self.words.peek()
    }

    /// Whether the next word is this keyword, in any case.
    pub(super) fn next_is(&self, keyword: &str) -> bool {
        self.peek()
            .is_some_and(|word| word.eq_ignore_ascii_case(keyword.as_bytes()))
    }

    pub(super) fn word(&mut self, expected: &str) -> Result<&'a [u8], ParseError> {
        self.words
            .next()
            .ok_or_else(|| self.error(format!("the file ends where {expected} should stand")))
    }

    pub(super) fn count(&mut self, expected: &str) -> Result<usize, ParseError> {
        let word = self.word(expected)?;
        std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| self.unexpected(word, expected))
    }

    /// A count, if one follows in the same line.
    pub(super) fn optional_count(&mut self, expected: &str) -> Result<Option<usize>, ParseError> {
        let rest = self.words.rest();
        let blanks = rest
            .iter()
            .take_while(|&&byte| byte == b' ' || byte == b'\t');
        let next = rest.get(blanks.count());
        if next.is_none_or(|byte| matches!(byte, b'\r' | b'\n')) {
            return Ok(None);
        }
        self.count(expected).map(Some)
    }

    /// A name, with its percent-encoded characters decoded.
    pub(super) fn name(&mut self) -> Result<String, ParseError> {
        let word = self.word("a name")?;
        Ok(String::from_utf8_lossy(&decode_percent(word)).into_owned())
    }

    pub(super) fn kind(&mut self) -> Result<Kind, ParseError> {
        let word = self.word("a number type")?;
        Kind::from_name(word)
            .ok_or_else(|| self.unexpected(word, "a number type (float, double, int, …)"))
    }

    /// A type that must be one of numbers.
    pub(super) fn number_kind(&mut self) -> Result<Kind, ParseError> {
        match self.kind()? {
            kind @ Kind::Numbers(_) => Ok(kind),
            _ => Err(self.error("expected a number type (float, double, int, …)")),
        }
    }

    fn values(&self, tuples: usize, components: usize) -> Result<usize, ParseError> {
        tuples.checked_mul(components).ok_or_else(|| {
            self.error(format!(
                "{tuples} × {components} numbers cannot be in a file"
            ))
        })
    }

    /// Reads `tuples · components` numbers. Strings are stepped over and leave an empty column.
    pub(super) fn numbers(
        &mut self,
        kind: Kind,
        tuples: usize,
        components: usize,
    ) -> Result<ColumnData, ParseError> {
        let values = self.values(tuples, components)?;
        let Kind::Numbers(element) = kind else {
            self.skip_strings(kind, values)?;
            return Ok(ColumnData::U8(Vec::new()));
        };
        if self.binary {
            let packed = self.packed(element, values)?;
            Ok(element.unpack(packed, values, Endian::Big))
        } else {
            let numbers = element.parse(&mut self.words, values);
            numbers.map_err(|fault| self.fault(fault))
        }
    }

    /// Steps over `values` numbers or strings.
    pub(super) fn skip_numbers(&mut self, kind: Kind, values: usize) -> Result<(), ParseError> {
        let Kind::Numbers(element) = kind else {
            return self.skip_strings(kind, values);
        };
        if self.binary {
            self.packed(element, values).map(drop)
        } else {
            self.skip_words(values)
        }
    }

    /// As [`Self::skip_numbers`], for `tuples · components` of them.
    pub(super) fn skip_tuples(
        &mut self,
        kind: Kind,
        tuples: usize,
        components: usize,
    ) -> Result<(), ParseError> {
        let values = self.values(tuples, components)?;
        self.skip_numbers(kind, values)
    }

    /// Reads unsigned bytes of colour: packed as such, or written as fractions of one.
    pub(super) fn colours(
        &mut self,
        tuples: usize,
        components: usize,
    ) -> Result<ColumnData, ParseError> {
        let scalar = if self.binary { Scalar::U8 } else { Scalar::F32 };
        let kind = Kind::Numbers(Element::Number(scalar));
        Ok(match self.numbers(kind, tuples, components)? {
            // Rounded and clamped by the cast, as vtkDataReader does.
            ColumnData::F32(fractions) => {
                ColumnData::U8(fractions.iter().map(|x| (x * 255.0 + 0.5) as u8).collect())
            }
            bytes => bytes,
        })
    }

    /// The bytes of a packed array, which starts behind the end of the header's line.
    fn packed(&mut self, element: Element, values: usize) -> Result<&'a [u8], ParseError> {
        self.words.line();
        let room = self.words.rest().len();
        element
            .packed_size(values)
            .and_then(|size| self.words.chunk(size))
            .ok_or_else(|| {
                self.error(format!(
                    "{values} numbers of type {element} are announced, but only {room} bytes follow"
                ))
            })
    }

    fn skip_words(&mut self, words: usize) -> Result<(), ParseError> {
        self.words
            .check_room(words)
            .map_err(|fault| self.fault(fault))?;
        for found in 0..words {
            if self.words.next().is_none() {
                return Err(self.fault(self.words.ended(words, found)));
            }
        }
        Ok(())
    }

    fn skip_strings(&mut self, kind: Kind, values: usize) -> Result<(), ParseError> {
        if kind == Kind::Variant {
            let words = self.values(values, 2)?;
            return self.skip_words(words);
        }
        self.words.line();
        for found in 0..values {
            let string = if self.binary {
                self.skip_packed_string()
            } else {
                self.words.line().map(drop)
            };
            if string.is_none() {
                return Err(self.error(format!(
                    "expected {values} strings, the file ends after {found}"
                )));
            }
        }
        Ok(())
    }

    /// A string behind its length, whose first two bits tell how many bytes the length takes.
    fn skip_packed_string(&mut self) -> Option<()> {
        let first = *self.words.rest().first()?;
        let length_bytes = match first >> 6 {
            3 => 1,
            2 => 2,
            1 => 4,
            _ => 8,
        };
        let length = self.words.chunk(length_bytes)?[1..]
            .iter()
            .fold(u64::from(first & 0x3f), |length, &byte| {
                length << 8 | u64::from(byte)
            });
        self.words.chunk(usize::try_from(length).ok()?).map(drop)
    }

    /// Steps over a block of metadata, text in both encodings, up to its blank line.
    pub(super) fn skip_metadata(&mut self) {
        self.words.line();
        while self
            .words
            .line()
            .is_some_and(|line| !line.trim_ascii().is_empty())
        {}
    }
}

/// `%20` and the like as the bytes they mean; a percent sign that starts no code stays.
fn decode_percent(word: &[u8]) -> Vec<u8> {
    let mut decoded = Vec::with_capacity(word.len());
    let mut rest = word;
    while let [first, tail @ ..] = rest {
        let code = match tail {
            [high, low, ..] if *first == b'%' => hex(*high).zip(hex(*low)),
            _ => None,
        };
        match code {
            Some((high, low)) => {
                decoded.push(high << 4 | low);
                rest = &tail[2..];
            }
            None => {
                decoded.push(*first);
                rest = tail;
            }
        }
    }
    decoded
}

fn hex(digit: u8) -> Option<u8> {
    char::from(digit)
        .to_digit(16)
        .and_then(|value| value.try_into().ok())
}
