//! The names of number types in legacy files.

use crate::particles::io::bytes::Scalar;
use crate::particles::io::vtk_values::Element;

/// What an array consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Numbers.
    Numbers(Element),
    /// Strings: percent-encoded lines, or packed with their lengths.
    Text,
    /// A type number and a value for each; text in binary files too.
    Variant,
}

impl Kind {
    /// Cell lists before version 5.0, and cell types.
    pub(super) const I32: Self = Self::Numbers(Element::Number(Scalar::I32));

    /// The type of that name, in any case. `vtkIdType` is 32 bits wide in legacy files whatever it
    /// was in memory, and `long` is what it was on the machine that wrote: 64 bits except on
    /// Windows, which `vtkDataReader` too can only guess.
    pub(super) fn from_name(name: &[u8]) -> Option<Self> {
        let scalar = match name.to_ascii_lowercase().as_slice() {
            b"bit" => return Some(Self::Numbers(Element::Bit)),
            b"string" | b"utf8_string" => return Some(Self::Text),
            b"variant" => return Some(Self::Variant),
            b"char" | b"signed_char" | b"vtktypeint8" => Scalar::I8,
            b"unsigned_char" | b"vtktypeuint8" => Scalar::U8,
            b"short" | b"vtktypeint16" => Scalar::I16,
            b"unsigned_short" | b"vtktypeuint16" => Scalar::U16,
            b"int" | b"vtkidtype" | b"vtktypeint32" => Scalar::I32,
            b"unsigned_int" | b"vtktypeuint32" => Scalar::U32,
            b"long" | b"long_long" | b"vtktypeint64" => Scalar::I64,
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Scalar::U64,
            b"float" | b"vtktypefloat32" => Scalar::F32,
            b"double" | b"vtktypefloat64" => Scalar::F64,
            _ => return None,
        };
        Some(Self::Numbers(Element::Number(scalar)))
    }
}
