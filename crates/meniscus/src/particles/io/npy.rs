//! NumPy arrays (NPY): (n, 3 or more), or with named fields.

pub(super) mod array;

use super::bytes::{PARALLEL, assemble};
use super::table::position_columns;
use super::{ParseError, Parsed, Place};
use crate::particles::{Column, ColumnData};
use array::Array;
use glam::DVec3;
use rayon::prelude::*;

/// Names of an array or field that holds whole positions, most telling first.
pub(super) const POSITION_NAMES: [&str; 11] = [
    "positions",
    "position",
    "pos",
    "points",
    "point",
    "coordinates",
    "coords",
    "xyz",
    "vertices",
    "x",
    "arr_0",
];

/// Whether the content is an NPY file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(array::MAGIC)
}

/// Reads one array: three or more numbers per row, the first three being the position, or records
/// with fields x, y, z or a field of three such as `position`.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let array = Array::parse(bytes)?;
    let warnings = array.warnings();
    let columns = array.columns()?;
    let named = array.has_fields();
    let (positions, columns) = if named {
        take_positions(columns).ok_or_else(|| {
            ParseError::new(
                Place::Whole,
                format!(
                    "no fields for the position; the array has {}",
                    array.field_names()
                ),
            )
            .with_help("name the fields x, y and z, or one field of three numbers position")
        })?
    } else {
        split_table(columns, &array)?
    };
    Ok(Parsed {
        particles: assemble(positions, columns)?,
        frames: 1,
        warnings,
        left_out: 0,
    })
}

/// Positions and further columns `column_4` … of a plain array (n, 3 or more).
fn split_table(
    columns: Vec<Column>,
    array: &Array,
) -> Result<(Vec<DVec3>, Vec<Column>), ParseError> {
    let table = columns
        .into_iter()
        .next()
        .filter(|table| table.components >= 3);
    let Some(table) = table.filter(|_| array.shape.len() == 2) else {
        return Err(ParseError::new(
            Place::Whole,
            format!("an array of shape {}, expected (n, 3)", array.shape_text()),
        )
        .with_help("store positions with one row of x, y, z per particle"));
    };
    let positions = positions_of(&table);
    let further = (3..table.components).map(|component| {
        let values: Vec<f64> = (0..table.rows())
            .map(|row| table.get(row, component))
            .collect();
        let data: ColumnData = match table.data {
            ColumnData::F32(_) => values
                .iter()
                .map(|&value| value as f32)
                .collect::<Vec<_>>()
                .into(),
            _ => values.into(),
        };
        Column::new(format!("column_{}", component + 1), 1, data)
    });
    let further = further.collect();
    Ok((positions, further))
}

/// Positions from the first three components of a column.
fn positions_of(column: &Column) -> Vec<DVec3> {
    (0..column.rows())
        .into_par_iter()
        .with_min_len(PARALLEL)
        .map(|row| DVec3::new(column.get(row, 0), column.get(row, 1), column.get(row, 2)))
        .collect()
}

/// Splits the position off: a column of three under a usual name, or three columns x, y, z.
pub(super) fn take_positions(mut columns: Vec<Column>) -> Option<(Vec<DVec3>, Vec<Column>)> {
    let whole = POSITION_NAMES.iter().find_map(|name| {
        columns
            .iter()
            .position(|column| column.components == 3 && column.name.eq_ignore_ascii_case(name))
    });
    if let Some(index) = whole {
        let positions = positions_of(&columns.remove(index));
        return Some((positions, columns));
    }
    let names: Vec<String> = columns
        .iter()
        .map(|column| {
            if column.components == 1 {
                column.name.clone()
            } else {
                String::new()
            }
        })
        .collect();
    let axes = position_columns(&names)?;
    let [x, y, z] = axes.map(|axis| &columns[axis]);
    let positions = (0..x.rows())
        .map(|row| DVec3::new(x.get(row, 0), y.get(row, 0), z.get(row, 0)))
        .collect();
    let mut index = 0;
    columns.retain(|_| {
        index += 1;
        !axes.contains(&(index - 1))
    });
    Some((positions, columns))
}

#[cfg(test)]
mod tests;
