//! Writes classic BGEO (version 5, big endian), as partio and SPlisHSPlasH do.

use crate::particles::{ColumnData, Particles};
use std::io::{Error, ErrorKind, Result, Write};

const FLOAT: i32 = 0;
const INT: i32 = 1;
const VECTOR: i32 = 5;

/// Writes positions as f32, integer columns that fit in i32, and float columns as f32.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let count = i32::try_from(particles.len())
        .map_err(|_| Error::new(ErrorKind::InvalidInput, "BGEO holds at most 2³¹ − 1 points"))?;
    let storable = |data: &ColumnData| match data {
        ColumnData::I64(values) => values.iter().all(|&value| i32::try_from(value).is_ok()),
        ColumnData::U64(values) => values.iter().all(|&value| i32::try_from(value).is_ok()),
        ColumnData::U32(values) => values.iter().all(|&value| i32::try_from(value).is_ok()),
        _ => true,
    };
    let (columns, lost): (Vec<_>, Vec<_>) = particles.columns.iter().partition(|column| {
        storable(&column.data)
            && column.components <= usize::from(u16::MAX)
            && column.name.len() <= usize::from(u16::MAX)
    });

    out.write_all(b"BgeoV")?;
    let attributes = i32::try_from(columns.len())
        .map_err(|_| Error::new(ErrorKind::InvalidInput, "too many columns"))?;
    for number in [5, count, 0, 0, 0, attributes, 0, 0, 0] {
        out.write_all(&number.to_be_bytes())?;
    }
    for column in &columns {
        let float = is_float(&column.data);
        let kind = match (float, column.components) {
            (true, 3) => VECTOR,
            (true, _) => FLOAT,
            (false, _) => INT,
        };
        out.write_all(&(column.name.len() as u16).to_be_bytes())?;
        out.write_all(column.name.as_bytes())?;
        out.write_all(&(column.components as u16).to_be_bytes())?;
        out.write_all(&kind.to_be_bytes())?;
        for _ in 0..column.components {
            out.write_all(&0_i32.to_be_bytes())?;
        }
    }
    for (i, position) in particles.positions.iter().enumerate() {
        for x in [position.x, position.y, position.z, 1.0] {
            out.write_all(&(x as f32).to_be_bytes())?;
        }
        for column in &columns {
            for component in 0..column.components {
                let value = column.get(i, component);
                let bytes = if is_float(&column.data) {
                    (value as f32).to_be_bytes()
                } else {
                    (value as i32).to_be_bytes()
                };
                out.write_all(&bytes)?;
            }
        }
    }
    // The end of the (empty) detail attributes.
    out.write_all(&[0x00, 0xff])?;
    Ok(lost.iter().map(|column| column.name.clone()).collect())
}

fn is_float(data: &ColumnData) -> bool {
    matches!(data, ColumnData::F32(_) | ColumnData::F64(_))
}
