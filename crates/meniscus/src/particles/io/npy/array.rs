//! One array in NPY format, checked against the bytes that are there.

use crate::particles::Column;
use crate::particles::io::bytes::{Endian, Scalar};
use crate::particles::io::{ParseError, Place};
use npyz::{DType, Endianness, NpyHeader, Order, TypeChar, TypeStr};

/// The first bytes of every NPY file.
pub(in crate::particles::io) const MAGIC: &[u8] = b"\x93NUMPY";
/// NumPy itself refuses headers of more than 10,000 characters.
const MAX_HEADER: usize = 1 << 16;
/// Brackets within brackets in a header.
const MAX_DEPTH: usize = 8;
/// More numbers than any memory holds.
const MAX_NUMBERS: f64 = 1e18;

/// A field of a record, or the whole of a plain array.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    scalar: Scalar,
    endian: Endian,
    components: usize,
    offset: usize,
}

/// An array whose header has been understood and whose data are all there.
pub(in crate::particles::io) struct Array<'a> {
    pub(in crate::particles::io) shape: Vec<u64>,
    order: Order,
    /// Rows: the first dimension.
    pub(in crate::particles::io) rows: usize,
    stride: usize,
    fields: Vec<Field>,
    named: bool,
    skipped: Vec<String>,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    /// Parses the header at the start of `bytes`.
    pub(in crate::particles::io) fn parse(bytes: &'a [u8]) -> Result<Self, ParseError> {
        let data_at = check_header(bytes)?;
        let header = NpyHeader::from_reader(bytes)
            .map_err(|error| ParseError::new(Place::Byte(10), format!("the header: {error}")))?;
        let shape = header.shape().to_vec();
        let dtype = header.dtype();
        let plain_components = shape.iter().skip(1).try_fold(1_usize, |product, &size| {
            product.checked_mul(usize::try_from(size).ok()?)
        });
        let rows = shape
            .first()
            .map_or(Some(1), |&rows| usize::try_from(rows).ok());
        let (Some(rows), Some(components)) = (rows, plain_components) else {
            return Err(too_large(&shape, bytes.len() - data_at));
        };
        let mut array = Self {
            shape,
            order: header.order(),
            rows,
            stride: 0,
            fields: Vec::new(),
            named: matches!(dtype, DType::Record(_)),
            skipped: Vec::new(),
            data: &bytes[data_at..],
        };
        array.add_fields(&dtype, components)?;
        let size = rows.checked_mul(array.stride);
        match size.and_then(|size| array.data.get(..size)) {
            Some(data) => array.data = data,
            None => return Err(too_large(&array.shape, array.data.len())),
        }
        Ok(array)
    }

    fn add_fields(&mut self, dtype: &DType, components: usize) -> Result<(), ParseError> {
        let overflow = || too_large(&[], 0);
        match dtype {
            DType::Plain(kind) => {
                self.stride = size_of_type(kind)
                    .and_then(|size| size.checked_mul(components))
                    .ok_or_else(|| unreadable(dtype))?;
                let (scalar, endian) = scalar(kind).ok_or_else(|| unreadable(dtype))?;
                self.fields.push(Field {
                    name: String::new(),
                    scalar,
                    endian,
                    components,
                    offset: 0,
                });
            }
            DType::Record(fields) if components == 1 => {
                for field in fields {
                    let size = field
                        .dtype
                        .num_bytes()
                        .ok_or_else(|| unreadable(&field.dtype))?;
                    let offset = self.stride;
                    self.stride = offset.checked_add(size).ok_or_else(overflow)?;
                    let mut inner = &field.dtype;
                    while let DType::Array(_, element) = inner {
                        inner = element;
                    }
                    let known = match inner {
                        DType::Plain(kind) => scalar(kind),
                        _ => None,
                    };
                    match known {
                        Some((scalar, endian)) if size > 0 => self.fields.push(Field {
                            name: field.name.clone(),
                            scalar,
                            endian,
                            components: size / scalar.size(),
                            offset,
                        }),
                        _ => self.skipped.push(field.name.clone()),
                    }
                }
            }
            _ => return Err(unreadable(dtype)),
        }
        Ok(())
    }

    /// Whether the array holds records with named fields.
    pub(in crate::particles::io) fn has_fields(&self) -> bool {
        self.named
    }

    /// The fields' names for a message.
    pub(in crate::particles::io) fn field_names(&self) -> String {
        let names: Vec<&str> = self
            .fields
            .iter()
            .map(|field| field.name.as_str())
            .collect();
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    }

    /// The shape as Python writes it.
    pub(in crate::particles::io) fn shape_text(&self) -> String {
        shape_text(&self.shape)
    }

    /// About fields that hold no numbers.
    pub(in crate::particles::io) fn warnings(&self) -> Vec<String> {
        self.skipped
            .iter()
            .map(|name| format!("field \"{name}\" holds no plain numbers and was skipped"))
            .collect()
    }

    /// The data as columns; a plain array is a single one without a name.
    pub(in crate::particles::io) fn columns(&self) -> Result<Vec<Column>, ParseError> {
        if self.stride == 0 {
            return Ok(Vec::new());
        }
        let by_column = self.order == Order::Fortran && self.shape.len() > 1;
        if by_column && self.shape.len() > 2 {
            return Err(ParseError::new(
                Place::Whole,
                format!("an array of shape {} in Fortran order", self.shape_text()),
            )
            .with_help("store it in C order: numpy.ascontiguousarray"));
        }
        let columns = self.fields.iter().map(|field| {
            let Field {
                name,
                scalar,
                endian,
                components,
                offset,
            } = field;
            let data = if by_column {
                scalar.gather(
                    &self.by_rows(scalar.size()),
                    self.stride,
                    0,
                    *components,
                    *endian,
                )
            } else {
                scalar.gather(self.data, self.stride, *offset, *components, *endian)
            };
            Column::new(name, *components, data)
        });
        Ok(columns.collect())
    }

    /// The bytes of a plain array in Fortran order, transposed to rows.
    fn by_rows(&self, size: usize) -> Vec<u8> {
        let components = self.stride / size;
        let mut rows = Vec::with_capacity(self.data.len());
        for row in 0..self.rows {
            for component in 0..components {
                let at = (component * self.rows + row) * size;
                rows.extend_from_slice(&self.data[at..at + size]);
            }
        }
        rows
    }
}

/// Checks magic, version and length of the header, and that a parser may be trusted with its text;
/// gives the offset of the data.
fn check_header(bytes: &[u8]) -> Result<usize, ParseError> {
    let cut = || {
        ParseError::new(
            Place::Byte(bytes.len() as u64),
            "the file ends within its header",
        )
        .with_help("the file is cut short; write it again")
    };
    if !bytes.starts_with(MAGIC) {
        return Err(ParseError::new(
            Place::Byte(0),
            "expected an array in NPY format",
        ));
    }
    let (length, start) = match (bytes.get(6).ok_or_else(cut)?, bytes.get(8..)) {
        (1, Some([a, b, ..])) => (usize::from(u16::from_le_bytes([*a, *b])), 10),
        (2 | 3, Some([a, b, c, d, ..])) => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 12),
        (1..=3, _) => return Err(cut()),
        (version, _) => {
            return Err(ParseError::new(
                Place::Byte(6),
                format!("version {version} of NPY, expected 1, 2 or 3"),
            ));
        }
    };
    let too_long = length > MAX_HEADER;
    let header = bytes[start..].get(..length).filter(|_| !too_long);
    let Some(header) = header else {
        return Err(if too_long {
            ParseError::new(Place::Byte(8), format!("a header of {length} bytes"))
        } else {
            cut()
        });
    };
    check_text(header).map_err(|problem| ParseError::new(Place::Byte(start as u64), problem))?;
    Ok(start + length)
}

/// Refuses what would overflow the stack or the products of the parser behind: deep brackets, and
/// integers whose product nobody can store.
fn check_text(header: &[u8]) -> Result<(), String> {
    let (mut depth, mut product, mut quote) = (0_usize, 1.0_f64, None);
    let mut at = 0;
    while let Some(&byte) = header.get(at) {
        at += 1;
        match (quote, byte) {
            (Some(open), _) if byte == open => quote = None,
            (Some(_), _) => {}
            (None, b'\'' | b'"') => quote = Some(byte),
            (None, b'(' | b'[' | b'{') => depth += 1,
            (None, b')' | b']' | b'}') => depth = depth.saturating_sub(1),
            (None, b'0'..=b'9') => {
                let digits = header[at..]
                    .iter()
                    .take_while(|byte| byte.is_ascii_digit())
                    .count();
                let number = std::str::from_utf8(&header[at - 1..at + digits]).unwrap_or_default();
                product *= number.parse::<f64>().unwrap_or(f64::INFINITY).max(1.0);
                at += digits;
                if header
                    .get(at)
                    .is_some_and(|&next| next.is_ascii_alphabetic() || next == b'_')
                {
                    return Err("an integer in the header that is not plain decimal".to_owned());
                }
            }
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err("the header nests brackets too deeply".to_owned());
        }
    }
    if product > MAX_NUMBERS {
        return Err(format!(
            "the header promises an array of {product:e} numbers"
        ));
    }
    Ok(())
}

fn size_of_type(kind: &TypeStr) -> Option<usize> {
    kind.num_bytes().filter(|&size| size > 0)
}

/// The number type of a NumPy type; `None` for text, objects, complex numbers and half floats.
fn scalar(kind: &TypeStr) -> Option<(Scalar, Endian)> {
    let endian = match kind.endianness() {
        Endianness::Big => Endian::Big,
        Endianness::Little | Endianness::Irrelevant => Endian::Little,
    };
    let scalar = match (kind.type_char(), kind.size_field()) {
        (TypeChar::Bool, 1) | (TypeChar::Uint, 1) => Scalar::U8,
        (TypeChar::Int, 1) => Scalar::I8,
        (TypeChar::Int, 2) => Scalar::I16,
        (TypeChar::Uint, 2) => Scalar::U16,
        (TypeChar::Int, 4) => Scalar::I32,
        (TypeChar::Uint, 4) => Scalar::U32,
        (TypeChar::Int, 8) => Scalar::I64,
        (TypeChar::Uint, 8) => Scalar::U64,
        (TypeChar::Float, 4) => Scalar::F32,
        (TypeChar::Float, 8) => Scalar::F64,
        _ => return None,
    };
    Some((scalar, endian))
}

fn unreadable(dtype: &DType) -> ParseError {
    ParseError::new(
        Place::Byte(10),
        format!("elements of type {} are not read", dtype.descr()),
    )
    .with_help("store integers or floats of 4 or 8 bytes")
}

fn too_large(shape: &[u64], available: usize) -> ParseError {
    ParseError::new(
        Place::Whole,
        format!(
            "the header promises an array of shape {}, the file holds {available} bytes of data",
            shape_text(shape)
        ),
    )
    .with_help("the file is cut short or its header is wrong; write it again")
}

fn shape_text(shape: &[u64]) -> String {
    let sizes: Vec<String> = shape.iter().map(u64::to_string).collect();
    let comma = if sizes.len() == 1 { "," } else { "" };
    format!("({}{comma})", sizes.join(", "))
}
