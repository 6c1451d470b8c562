//! VTK XML files with points: UnstructuredGrid (`.vtu`), PolyData (`.vtp`), StructuredGrid (`.vts`).
//!
//! Format: *VTK File Formats*, "XML File Formats" (Kitware), and what `vtkXMLDataParser` does where
//! that text is silent. Arrays stand as text, as base64 in place, or appended behind the markup (raw
//! or base64), compressed or not. The pieces of a file are joined in their order.

mod compression;
mod document;
mod markup;
mod payload;
mod source;

#[cfg(test)]
mod tests;

use super::bytes::assemble;
use super::vtk_values::{line_of, positions_of};
use super::{ParseError, Parsed};
use crate::particles::{Column, ColumnData};
use document::{Document, Piece};
use payload::Payloads;
use std::collections::{BTreeMap, HashMap};

/// Whether the content is XML with a `VTKFile` element near its start.
pub(super) fn detect(prefix: &[u8]) -> bool {
    let start = prefix.strip_prefix(b"\xef\xbb\xbf").unwrap_or(prefix);
    let start = start.trim_ascii_start();
    let near = &start[..start.len().min(4096)];
    near.starts_with(b"<") && near.windows(8).any(|window| window == b"<VTKFile")
}

/// Reads the points and their data at time step `frame`; none of them beyond the last step.
pub(super) fn read(bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
    let Document {
        mut pieces,
        frames,
        mut warnings,
        storage,
    } = markup::parse(bytes, frame)?;
    if frame >= frames {
        return Ok(Parsed {
            frames,
            ..Parsed::default()
        });
    }
    pieces.retain(|piece| piece.points > 0);
    keep_common_arrays(&mut pieces, &mut warnings);

    let mut payloads = Payloads::new(bytes, &storage);
    let mut positions = Vec::new();
    let mut columns: Vec<Column> = Vec::new();
    let mut column_of_name: HashMap<&str, usize> = HashMap::new();
    for piece in &pieces {
        let Some(points) = &piece.positions else {
            let problem = "this piece has points, but no <Points> array of numbers";
            return Err(ParseError::new(line_of(bytes, piece.offset), problem));
        };
        if points.components.is_some_and(|components| components != 3) {
            let problem = "the <Points> array must have 3 components";
            return Err(ParseError::new(line_of(bytes, points.offset), problem));
        }
        let triples = payloads.read(points, piece.points, 3)?;
        positions.append(&mut positions_of(&triples));
        for array in &piece.arrays {
            let components = array.components.unwrap_or(1);
            let data = payloads.read(array, piece.points, components)?;
            match column_of_name.get(array.name.as_str()) {
                None => {
                    column_of_name.insert(&array.name, columns.len());
                    columns.push(Column::new(array.name.clone(), components, data));
                }
                Some(&column) => append(&mut columns[column].data, data),
            }
        }
    }
    warnings.append(&mut payloads.warnings);
    Ok(Parsed {
        particles: assemble(positions, columns)?,
        frames,
        warnings,
        left_out: 0,
    })
}

/// Drops the arrays that some piece lacks or has with another type or number of components.
fn keep_common_arrays(pieces: &mut [Piece], warnings: &mut Vec<String>) {
    let mut alike = BTreeMap::new();
    for array in pieces.iter().flat_map(|piece| &piece.arrays) {
        let (shape, count) = alike
            .entry(array.name.clone())
            .or_insert((array.shape(), 0));
        *count += usize::from(*shape == array.shape());
    }
    alike.retain(|_, (_, count)| *count < pieces.len());
    for piece in pieces {
        piece
            .arrays
            .retain(|array| !alike.contains_key(&array.name));
    }
    let dropped = alike.into_keys();
    warnings.extend(
        dropped
            .map(|name| format!("array {name:?} is not the same in all pieces and was left out")),
    );
}

/// Adds `more`, which is of the same type.
fn append(data: &mut ColumnData, more: ColumnData) {
    macro_rules! join {
        ($($variant:ident)*) => {
            match (data, more) {
                $((ColumnData::$variant(data), ColumnData::$variant(mut more)) => {
                    data.append(&mut more);
                })*
                _ => debug_assert!(false, "arrays of different types are left out before"),
            }
        };
    }
    join!(I8 U8 I16 U16 I32 U32 I64 U64 F32 F64);
}
