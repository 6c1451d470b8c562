//! What the markup of a VTK XML file says, before any array is decoded.

use super::compression::Compressor;
use crate::particles::io::bytes::{Endian, Scalar};
use crate::particles::io::vtk_values::Element;
use std::ops::Range;

/// The markup.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) pieces: Vec<Piece>,
    /// Number of time steps.
    pub(super) frames: usize,
    pub(super) warnings: Vec<String>,
    pub(super) storage: Storage,
}

/// How the file stores binary arrays.
#[derive(Debug)]
pub(super) struct Storage {
    pub(super) endian: Endian,
    /// Bytes of each number in an array's header: 4 or 8.
    pub(super) header_width: usize,
    pub(super) compressor: Option<Compressor>,
    /// What stands behind the `_` of `<AppendedData>`.
    pub(super) appended: Range<usize>,
    /// Whether that is base64.
    pub(super) appended_base64: bool,
}

impl Default for Storage {
    fn default() -> Self {
        Self {
            endian: Endian::Little,
            header_width: 4,
            compressor: None,
            appended: 0..0,
            appended_base64: false,
        }
    }
}

/// A part of the data set.
#[derive(Debug, Default)]
pub(super) struct Piece {
    pub(super) points: usize,
    /// The array under `<Points>`.
    pub(super) positions: Option<Array>,
    /// The arrays under `<PointData>`, of numbers, with unique names.
    pub(super) arrays: Vec<Array>,
    /// Where its tag starts in the file.
    pub(super) offset: usize,
}

/// One array.
#[derive(Debug)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) element: Element,
    /// Numbers per point, where the file says it; never 0.
    pub(super) components: Option<usize>,
    pub(super) stored: Stored,
    /// Where its tag starts in the file.
    pub(super) offset: usize,
}

impl Array {
    /// What must agree for arrays of two pieces to be joined.
    pub(super) fn shape(&self) -> (Element, usize) {
        (self.element, self.components.unwrap_or(1))
    }
}

/// Where an array's numbers are.
#[derive(Debug)]
pub(super) enum Stored {
    /// Words in these ranges of the file (several where comments or tags come between).
    Text(Vec<Range<usize>>),
    /// Base64 in these ranges of the file.
    Base64(Vec<Range<usize>>),
    /// At this offset behind the `_` of `<AppendedData>`.
    Appended(usize),
}

/// The number type of that name.
pub(super) fn element(name: &str) -> Option<Element> {
    let scalar = match name {
        "Bit" => return Some(Element::Bit),
        "Int8" => Scalar::I8,
        "UInt8" => Scalar::U8,
        "Int16" => Scalar::I16,
        "UInt16" => Scalar::U16,
        "Int32" => Scalar::I32,
        "UInt32" => Scalar::U32,
        "Int64" => Scalar::I64,
        "UInt64" => Scalar::U64,
        "Float32" => Scalar::F32,
        "Float64" => Scalar::F64,
        _ => return None,
    };
    Some(Element::Number(scalar))
}
