//! Writes CSV with a header: x, y, z, then every column's components.

use super::write::scalar_names;
use crate::particles::Particles;
use std::io::{Result, Write};

/// Writes everything, numbers so that they read back exactly.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let mut table = ::csv::Writer::from_writer(out);
    let axes = ["x", "y", "z"].map(str::to_owned);
    let header = axes
        .into_iter()
        .chain(particles.columns.iter().flat_map(scalar_names));
    table.write_record(header)?;
    let mut field = Vec::new();
    for (i, position) in particles.positions.iter().enumerate() {
        for x in position.to_array() {
            field.clear();
            write!(field, "{x:?}")?;
            table.write_field(&field)?;
        }
        for column in &particles.columns {
            for k in i * column.components..(i + 1) * column.components {
                field.clear();
                column.data.write_text(k, &mut field)?;
                table.write_field(&field)?;
            }
        }
        table.write_record(None::<&[u8]>)?;
    }
    table.flush()?;
    Ok(Vec::new())
}
