//! Writes binary little-endian PLY: element `vertex` with scalar properties.

use super::write::{fit_f32, scalar_names};
use crate::particles::{Column, ColumnData, Particles};
use std::io::{Result, Write};

/// How the numbers of one column are stored: PLY has no 64-bit integers.
enum Stored {
    AsIs(&'static str),
    Int,
    Double,
}

/// Writes all columns but those of 64-bit integers that neither i32 nor f64 can hold.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let mut lost = Vec::new();
    let mut columns: Vec<(&Column, Stored)> = Vec::new();
    for column in &particles.columns {
        match stored(&column.data) {
            Some(stored) => columns.push((column, stored)),
            None => lost.push(column.name.clone()),
        }
    }
    let single = fit_f32(particles);
    let position = if single { "float" } else { "double" };
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        particles.len()
    );
    for axis in ["x", "y", "z"] {
        header += &format!("property {position} {axis}\n");
    }
    for (column, stored) in &columns {
        let kind = match stored {
            Stored::AsIs(kind) => kind,
            Stored::Int => "int",
            Stored::Double => "double",
        };
        for name in scalar_names(column) {
            let word: String = name
                .chars()
                .map(|c| {
                    if c.is_whitespace() || c.is_control() {
                        '_'
                    } else {
                        c
                    }
                })
                .collect();
            header += &format!("property {kind} {word}\n");
        }
    }
    header += "end_header\n";
    out.write_all(header.as_bytes())?;

    let mut row = Vec::new();
    for (i, position) in particles.positions.iter().enumerate() {
        row.clear();
        for x in position.to_array() {
            if single {
                row.extend((x as f32).to_le_bytes());
            } else {
                row.extend(x.to_le_bytes());
            }
        }
        for (column, stored) in &columns {
            let numbers = i * column.components..(i + 1) * column.components;
            match stored {
                Stored::AsIs(_) => column.data.put_le_bytes(numbers, &mut row),
                Stored::Int => {
                    for k in numbers {
                        row.extend((column.data.get(k) as i32).to_le_bytes());
                    }
                }
                Stored::Double => {
                    for k in numbers {
                        row.extend(column.data.get(k).to_le_bytes());
                    }
                }
            }
        }
        out.write_all(&row)?;
    }
    Ok(lost)
}

fn stored(data: &ColumnData) -> Option<Stored> {
    const EXACT: u64 = 1 << 53;
    let wide = |fit_int: bool, exact: bool| match (fit_int, exact) {
        (true, _) => Some(Stored::Int),
        (false, true) => Some(Stored::Double),
        (false, false) => None,
    };
    Some(Stored::AsIs(match data {
        ColumnData::I8(_) => "char",
        ColumnData::U8(_) => "uchar",
        ColumnData::I16(_) => "short",
        ColumnData::U16(_) => "ushort",
        ColumnData::I32(_) => "int",
        ColumnData::U32(_) => "uint",
        ColumnData::F32(_) => "float",
        ColumnData::F64(_) => "double",
        ColumnData::I64(values) => {
            return wide(
                values.iter().all(|&value| i32::try_from(value).is_ok()),
                values.iter().all(|value| value.unsigned_abs() <= EXACT),
            );
        }
        ColumnData::U64(values) => {
            return wide(
                values.iter().all(|&value| i32::try_from(value).is_ok()),
                values.iter().all(|&value| value <= EXACT),
            );
        }
    }))
}
