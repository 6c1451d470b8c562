//! Numbers as both VTK families store them: packed binary, or words between white space.

use super::bytes::{Endian, Scalar, with_scalar};
use super::{ParseError, Place};
use crate::particles::ColumnData;
use glam::DVec3;

/// What an array of a VTK file consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Element {
    /// One bit each, most significant first; the array is padded to a whole byte.
    Bit,
    /// An ordinary number.
    Number(Scalar),
}

impl Element {
    /// Bytes that `values` numbers occupy in a binary array; `None` on overflow.
    pub(super) fn packed_size(self, values: usize) -> Option<usize> {
        match self {
            Self::Bit => Some(values.div_ceil(8)),
            Self::Number(scalar) => values.checked_mul(scalar.size()),
        }
    }

    /// Bytes that `values` numbers occupy once read; `None` on overflow.
    pub(super) fn read_size(self, values: usize) -> Option<usize> {
        match self {
            Self::Bit => Some(values),
            Self::Number(scalar) => values.checked_mul(scalar.size()),
        }
    }

    /// The first `values` numbers of `packed`, which must hold that many.
    pub(super) fn unpack(self, packed: &[u8], values: usize, endian: Endian) -> ColumnData {
        match self {
            Self::Bit => {
                let bit = |i: usize| packed[i / 8] >> (7 - i % 8) & 1;
                ColumnData::U8((0..values).map(bit).collect())
            }
            Self::Number(scalar) => {
                let size = values * scalar.size();
                scalar.gather(&packed[..size], size.max(1), 0, values, endian)
            }
        }
    }

    /// The next `values` words as numbers.
    pub(super) fn parse(self, words: &mut Words, values: usize) -> Result<ColumnData, Fault> {
        words.check_room(values)?;
        let scalar = match self {
            Self::Bit => Scalar::U8,
            Self::Number(scalar) => scalar,
        };
        with_scalar!(scalar, T => {
            let mut numbers: Vec<T> = Vec::with_capacity(values);
            for _ in 0..values {
                let Some(word) = words.next() else {
                    return Err(words.ended(values, numbers.len()));
                };
                let text = std::str::from_utf8(word).unwrap_or_default();
                match text.parse().ok().or_else(|| from_unusual::<T>(text, |x| x as T)) {
                    Some(number) => numbers.push(number),
                    None => {
                        return Err(Fault::new(
                            words.position - word.len(),
                            format!("expected a number of type {self}, found {}", excerpt(word)),
                        ));
                    }
                }
            }
            Ok(numbers.into())
        })
    }
}

impl std::fmt::Display for Element {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bit => f.write_str("bit"),
            Self::Number(scalar) => {
                f.write_str(with_scalar!(*scalar, T => std::any::type_name::<T>()))
            }
        }
    }
}

/// Numbers that Rust's own parser refuses for this type: a whole number written as `3.0` or `3e2`,
/// and the names that Windows' C library gave to NaN and infinity until 2015.
fn from_unusual<T: Copy + Into<Wide>>(text: &str, cast: impl Fn(f64) -> T) -> Option<T> {
    let magnitude = text.trim_start_matches(['-', '+']);
    let value: f64 = match magnitude {
        "1.#INF" | "1.#INF00" | "1.#INF000000" => f64::INFINITY,
        _ if magnitude.starts_with("1.#IND")
            || magnitude.starts_with("1.#QNAN")
            || magnitude.starts_with("1.#SNAN") =>
        {
            f64::NAN
        }
        _ => magnitude.parse().ok()?,
    };
    let value = if text.starts_with('-') { -value } else { value };
    let number = cast(value);
    let Wide(back) = number.into();
    let exact = back == value && (value.is_infinite() || value.abs() <= MAX_EXACT);
    (exact || (back.is_nan() && value.is_nan())).then_some(number)
}

/// 2⁵³: up to here f64 holds every whole number.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// A number of any type as f64, to see whether a cast was exact.
struct Wide(f64);

macro_rules! wide {
    ($($type:ty)*) => {
        $(impl From<$type> for Wide {
            #[allow(clippy::unnecessary_cast, reason = "one of the types is f64 itself")]
            fn from(value: $type) -> Self {
                Self(value as f64)
            }
        })*
    };
}
wide!(i8 u8 i16 u16 i32 u32 i64 u64 f32 f64);

/// Positions from interleaved triples.
pub(super) fn positions_of(triples: &ColumnData) -> Vec<DVec3> {
    macro_rules! convert {
        ($($variant:ident)*) => {
            match triples {
                $(ColumnData::$variant(values) => {
                    let (triples, _) = values.as_chunks::<3>();
                    triples
                        .iter()
                        .map(|&[x, y, z]| DVec3::new(x as f64, y as f64, z as f64))
                        .collect()
                })*
            }
        };
    }
    convert!(I8 U8 I16 U16 I32 U32 I64 U64 F32 F64)
}

/// A problem at a byte of the text at hand; the reader turns it into a [`ParseError`].
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) offset: usize,
    pub(super) problem: String,
}

impl Fault {
    pub(super) fn new(offset: usize, problem: impl Into<String>) -> Self {
        Self {
            offset,
            problem: problem.into(),
        }
    }

    /// As an error with a line number, counted in `file`.
    pub(super) fn at_line(self, file: &[u8]) -> ParseError {
        ParseError::new(line_of(file, self.offset), self.problem)
    }
}

/// The line of `file` in which the byte at `offset` stands.
pub(super) fn line_of(file: &[u8], offset: usize) -> Place {
    let before = &file[..offset.min(file.len())];
    let ends = before.iter().filter(|&&byte| byte == b'\n').count();
    Place::Line(ends as u64 + 1)
}

/// A quotation for error messages: printable, at most 32 characters.
pub(super) fn excerpt(word: &[u8]) -> String {
    let start = &word[..word.len().min(32)];
    let dots = if word.len() > start.len() { "…" } else { "" };
    format!("{:?}{dots}", String::from_utf8_lossy(start))
}

/// Walks over the words (and lines, and packed arrays) of a byte string.
#[derive(Debug, Clone)]
pub(super) struct Words<'a> {
    pub(super) bytes: &'a [u8],
    /// Offset of the next byte.
    pub(super) position: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(bytes: &'a [u8], position: usize) -> Self {
        Self { bytes, position }
    }

    /// What has not been consumed.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.position..).unwrap_or_default()
    }

    pub(super) fn skip_space(&mut self) {
        let space = self.rest().iter().take_while(|byte| is_space(**byte));
        self.position += space.count();
    }

    /// The next word without consuming it.
    pub(super) fn peek(&self) -> Option<&'a [u8]> {
        self.clone().next()
    }

    /// Everything up to the end of the line, which is consumed with its line feed.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|&byte| byte == b'\n');
        self.position += end.map_or(rest.len(), |end| end + 1);
        Some(&rest[..end.unwrap_or(rest.len())])
    }

    /// The next `size` bytes, if there are as many.
    pub(super) fn chunk(&mut self, size: usize) -> Option<&'a [u8]> {
        let taken = self.rest().get(..size)?;
        self.position += size;
        Some(taken)
    }

    /// Whether `values` words can stand in the rest at all.
    pub(super) fn check_room(&self, values: usize) -> Result<(), Fault> {
        let room = self.rest().len();
        if values > room.div_ceil(2) {
            return Err(Fault::new(
                self.position,
                format!("{values} numbers are announced, but only {room} bytes follow"),
            ));
        }
        Ok(())
    }

    /// The fault of an array that stops after `found` of `values` numbers.
    pub(super) fn ended(&self, values: usize, found: usize) -> Fault {
        Fault::new(
            self.bytes.len(),
            format!("expected {values} numbers, the text ends after {found}"),
        )
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = self.rest();
        let length = rest.iter().take_while(|byte| !is_space(**byte)).count();
        self.position += length;
        (length > 0).then(|| &rest[..length])
    }
}

/// White space as C's `isspace` knows it, which decides in VTK.
fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_become_numbers_of_the_type_asked_for() {
        let parse = |scalar, text: &str, values| {
            Element::Number(scalar).parse(&mut Words::new(text.as_bytes(), 0), values)
        };
        assert_eq!(
            parse(Scalar::F32, " 0.1\r\n-2e3\tnan\x0b1.#INF", 4)
                .unwrap()
                .get(1),
            -2000.0
        );
        let odd = parse(Scalar::F32, "0.1 -nan 1.#QNAN -1.#IND -1.#INF inf", 6).unwrap();
        assert_eq!(odd.get(0), f64::from(0.1f32));
        assert!((1..4).all(|i| odd.get(i).is_nan()));
        assert_eq!([odd.get(4), odd.get(5)], [f64::NEG_INFINITY, f64::INFINITY]);
        assert_eq!(
            parse(Scalar::U64, "18446744073709551615 3.0 1e3", 3).unwrap(),
            ColumnData::U64(vec![u64::MAX, 3, 1000])
        );
        for wrong in ["300", "-1", "1.5", "nan", "x", "\u{e9}"] {
            let fault = parse(Scalar::U8, wrong, 1).unwrap_err();
            assert!(fault.problem.contains("u8"), "{wrong}: {}", fault.problem);
        }
        assert!(parse(Scalar::U8, "1 2 ", 3).is_err());
        assert!(parse(Scalar::U8, "1 2", usize::MAX).is_err());
    }

    #[test]
    fn packed_numbers_in_both_orders_and_bits() {
        let bytes = [1, 2, 3, 4, 0xa0];
        let short = Element::Number(Scalar::I16);
        assert_eq!(
            short.unpack(&bytes, 2, Endian::Big),
            ColumnData::I16(vec![0x102, 0x304])
        );
        assert_eq!(
            short.unpack(&bytes, 2, Endian::Little),
            ColumnData::I16(vec![0x201, 0x403])
        );
        assert_eq!(
            Element::Bit.unpack(&bytes[4..], 3, Endian::Big),
            ColumnData::U8(vec![1, 0, 1])
        );
        assert_eq!(short.unpack(&[], 0, Endian::Big), ColumnData::I16(vec![]));
        assert_eq!(short.packed_size(usize::MAX), None);
        assert_eq!(Element::Bit.packed_size(9), Some(2));
    }
}
