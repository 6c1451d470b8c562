//! From where an array is stored to its numbers, within bounds of memory.

use super::compression::unfold;
use super::document::{Array, Storage, Stored};
use super::source::Source;
use crate::particles::ColumnData;
use crate::particles::io::vtk_values::{Words, line_of};
use crate::particles::io::{ParseError, Place};
use std::borrow::Cow;
use std::ops::Range;

/// All binary arrays of a compressed file together may unfold to this size, plus …
const ALWAYS_ALLOWED: usize = 128 << 20;
/// … this many bytes for each byte of the file.
const COMPRESSED_RATIO: usize = 100;
/// The same without compression: bits become bytes, and an array may be used by several pieces.
const PLAIN_RATIO: usize = 8;

/// Decodes arrays and sees that together they stay within a multiple of the file's size.
pub(super) struct Payloads<'a> {
    file: &'a [u8],
    storage: &'a Storage,
    budget: usize,
    pub(super) warnings: Vec<String>,
}

impl<'a> Payloads<'a> {
    pub(super) fn new(file: &'a [u8], storage: &'a Storage) -> Self {
        let budget = match storage.compressor {
            Some(_) => ALWAYS_ALLOWED.saturating_add(file.len().saturating_mul(COMPRESSED_RATIO)),
            None => file.len().saturating_mul(PLAIN_RATIO),
        };
        Self {
            file,
            storage,
            budget,
            warnings: Vec::new(),
        }
    }

    /// The numbers of `array`: `components` for each of `points`.
    pub(super) fn read(
        &mut self,
        array: &Array,
        points: usize,
        components: usize,
    ) -> Result<ColumnData, ParseError> {
        let values = points.checked_mul(components);
        let sizes = values.and_then(|values| {
            let element = array.element;
            Some((
                values,
                element.packed_size(values)?,
                element.read_size(values)?,
            ))
        });
        let Some((values, packed_size, read_size)) = sizes else {
            return Err(self.error(
                array,
                format!("{points} × {components} numbers cannot be in a file"),
            ));
        };
        let (source, base64) = match &array.stored {
            Stored::Text(ranges) => return self.parse_text(array, ranges, values),
            Stored::Base64(ranges) => (self.join(ranges), true),
            Stored::Appended(offset) => {
                let appended = self.file.get(self.storage.appended.clone());
                let Some(source) = appended.and_then(|bytes| bytes.get(*offset..)) else {
                    let problem = "its offset lies behind the end of the appended data";
                    return Err(self.error(array, problem.to_owned()));
                };
                (Cow::Borrowed(source), self.storage.appended_base64)
            }
        };
        self.budget = match self.budget.checked_sub(read_size) {
            Some(budget) => budget,
            None => {
                let size = self.file.len();
                return Err(self.error(
                    array,
                    format!("{values} numbers unfold to too much for a file of {size} bytes"),
                ));
            }
        };
        let source = if base64 {
            Source::base64(&source)
        } else {
            Source::Raw(&source)
        };
        self.decode(array, source, values, packed_size)
    }

    fn decode(
        &mut self,
        array: &Array,
        mut source: Source,
        values: usize,
        packed_size: usize,
    ) -> Result<ColumnData, ParseError> {
        let endian = self.storage.endian;
        let bytes = match self.storage.compressor {
            Some(compressor) => {
                unfold(&mut source, self.storage, compressor, packed_size).map(Cow::Owned)
            }
            None => source
                .take_number(self.storage.header_width, endian)
                .and_then(|announced| self.check_size(array, announced, packed_size))
                .and_then(|()| source.take(packed_size)),
        };
        match bytes {
            Ok(bytes) => Ok(array.element.unpack(&bytes, values, endian)),
            Err(problem) => Err(self.error(array, problem)),
        }
    }

    /// Holds an array's own size in bytes against what its points need.
    fn check_size(&mut self, array: &Array, announced: usize, needed: usize) -> Result<(), String> {
        if announced < needed {
            return Err(format!("has {announced} bytes, its points need {needed}"));
        }
        if announced > needed {
            self.warnings.push(format!(
                "array {:?} has {announced} bytes where its points need {needed}; the rest was \
                 ignored",
                array.name
            ));
        }
        Ok(())
    }

    fn parse_text(
        &self,
        array: &Array,
        ranges: &[Range<usize>],
        values: usize,
    ) -> Result<ColumnData, ParseError> {
        let parse = |mut words: Words| array.element.parse(&mut words, values);
        let parsed = if let [range] = ranges {
            parse(Words::new(&self.file[..range.end], range.start))
        } else {
            parse(Words::new(&self.join(ranges), 0)).map_err(|mut fault| {
                fault.offset = array.offset;
                fault
            })
        };
        parsed.map_err(|mut fault| {
            fault.problem = format!("array {:?}: {}", array.name, fault.problem);
            fault.at_line(self.file)
        })
    }

    /// The text of these ranges, with a space between them.
    fn join(&self, ranges: &[Range<usize>]) -> Cow<'a, [u8]> {
        match ranges {
            [range] => Cow::Borrowed(&self.file[range.clone()]),
            _ => {
                let parts: Vec<&[u8]> = ranges.iter().map(|r| &self.file[r.clone()]).collect();
                Cow::Owned(parts.join(&b' '))
            }
        }
    }

    /// An error about an array: at its line, or at its place in the appended data.
    fn error(&self, array: &Array, problem: String) -> ParseError {
        let appended = &self.storage.appended;
        let place = match array.stored {
            Stored::Appended(offset) if offset < appended.len() => {
                Place::Byte((appended.start + offset) as u64)
            }
            _ => line_of(self.file, array.offset),
        };
        ParseError::new(place, format!("array {:?}: {problem}", array.name))
    }
}
