//! The text before `end_header`.

use crate::particles::io::bytes::{Endian, Scalar};
use crate::particles::io::text::{quote, unexpected, words};
use crate::particles::io::{ParseError, Place};

/// How the body is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary(Endian),
}

/// One number, or a list of them, per row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) scalar: Scalar,
    /// Type of the count before a list; `None` for a scalar.
    pub(super) list_count: Option<Scalar>,
}

/// A table of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    /// Rows that the header promises: not to be trusted.
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Line of the header that declares it.
    pub(super) line: u64,
}

impl Element {
    /// Bytes of a row in a binary file; `None` if lists make it vary.
    pub(super) fn stride(&self) -> Option<usize> {
        self.properties
            .iter()
            .map(|property| {
                property
                    .list_count
                    .is_none()
                    .then(|| property.scalar.size())
            })
            .sum()
    }

    /// Byte offset of a property in a row without lists.
    pub(super) fn offset(&self, property: usize) -> usize {
        self.properties[..property]
            .iter()
            .map(|property| property.scalar.size())
            .sum()
    }
}

/// The header and where the body starts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Offset of the first byte of the body.
    pub(super) body: usize,
    /// Number of the body's first line.
    pub(super) body_line: u64,
    /// About lines that are no PLY.
    pub(super) warnings: Vec<String>,
}

/// More odd lines than this are taken for a file that is no PLY.
const ODD_LINES: usize = 8;

impl Header {
    /// Parses the header at the start of `bytes`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, ParseError> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut warnings = Vec::new();
        let mut at = 0;
        // A header whose first line ends in \r alone has old Macintosh line ends.
        let end = match bytes
            .iter()
            .position(|&byte| byte == b'\r' || byte == b'\n')
        {
            Some(first) if bytes[first] == b'\r' && bytes.get(first + 1) != Some(&b'\n') => b'\r',
            _ => b'\n',
        };
        for number in 1.. {
            let rest = &bytes[at..];
            if rest.is_empty() {
                return Err(ParseError::new(
                    Place::Line(number),
                    "the file ends before \"end_header\"",
                )
                .with_help("the file is cut short; write it again"));
            }
            let length = rest.iter().position(|&byte| byte == end);
            let line = &rest[..length.unwrap_or(rest.len())];
            at += length.map_or(rest.len(), |length| length + 1);
            let mut words = words(line);
            let Some(keyword) = words.next() else {
                continue;
            };
            let mut word = |expected| {
                words.next().ok_or_else(|| {
                    ParseError::new(
                        Place::Line(number),
                        format!("expected {expected} after {}", quote(line)),
                    )
                })
            };
            match keyword {
                b"ply" if number == 1 => {}
                b"comment" | b"obj_info" => {}
                b"format" => {
                    encoding = Some(match word("an encoding")? {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::Binary(Endian::Little),
                        b"binary_big_endian" => Encoding::Binary(Endian::Big),
                        other => {
                            return Err(unexpected(
                                number,
                                "ascii, binary_little_endian or binary_big_endian",
                                other,
                            ));
                        }
                    });
                }
                b"element" => {
                    let name = text(word("the element's name")?);
                    let count = word("the number of rows")?;
                    let count = std::str::from_utf8(count)
                        .ok()
                        .and_then(|count| count.parse().ok())
                        .ok_or_else(|| unexpected(number, "a number of rows", count))?;
                    elements.push(Element {
                        name,
                        count,
                        properties: Vec::new(),
                        line: number,
                    });
                }
                b"property" => {
                    let kind = word("a type")?;
                    let list_count = match kind {
                        b"list" => Some(integer(word("the count's type")?, number)?),
                        _ => None,
                    };
                    let scalar = match list_count {
                        Some(_) => scalar(word("the items' type")?, number)?,
                        None => scalar(kind, number)?,
                    };
                    let name = text(word("the property's name")?);
                    let Some(element) = elements.last_mut() else {
                        return Err(ParseError::new(
                            Place::Line(number),
                            "a property before the first element",
                        ));
                    };
                    element.properties.push(Property {
                        name,
                        scalar,
                        list_count,
                    });
                }
                b"end_header" => {
                    let encoding = encoding.ok_or_else(|| {
                        ParseError::new(Place::Line(number), "the header has no \"format\" line")
                    })?;
                    return Ok(Self {
                        encoding,
                        elements,
                        body: at,
                        body_line: number + 1,
                        warnings,
                    });
                }
                // Some exporters forget the word "comment".
                _ if warnings.len() < ODD_LINES => {
                    let line = quote(line.trim_ascii());
                    warnings.push(format!("line {number} of the header was ignored: {line}"));
                }
                other => {
                    let known = "format, comment, obj_info, element, property or end_header";
                    return Err(unexpected(number, known, other));
                }
            }
        }
        unreachable!("the loop ends with the file")
    }
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

fn scalar(word: &[u8], line: u64) -> Result<Scalar, ParseError> {
    Ok(match word {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"long" | b"int64" => Scalar::I64,
        b"ulong" | b"uint64" => Scalar::U64,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return Err(unexpected(line, "a type such as float, int or uchar", word)),
    })
}

fn integer(word: &[u8], line: u64) -> Result<Scalar, ParseError> {
    match scalar(word, line)? {
        Scalar::F32 | Scalar::F64 => Err(unexpected(line, "an integer type", word)),
        integer => Ok(integer),
    }
}
