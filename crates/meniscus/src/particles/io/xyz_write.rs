//! Writes extended XYZ: a count, a line that describes the columns, one row per particle.

use crate::particles::elements::symbol;
use crate::particles::{ColumnData, Particles};
use std::io::{Result, Write};

/// Writes everything; a column `atomic_number` becomes the element symbols.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let species = particles
        .column("atomic_number")
        .filter(|column| column.components == 1);
    let columns: Vec<_> = particles
        .columns
        .iter()
        .filter(|column| species.is_none_or(|species| !std::ptr::eq(*column, species)))
        .collect();
    let mut properties = "species:S:1:pos:R:3".to_owned();
    for column in &columns {
        let kind = match column.data {
            ColumnData::F32(_) | ColumnData::F64(_) => 'R',
            _ => 'I',
        };
        let name: String = column
            .name
            .chars()
            .map(|c| match c {
                ':' | '"' | '=' => '_',
                c if c.is_whitespace() || c.is_control() => '_',
                c => c,
            })
            .collect();
        properties += &format!(":{name}:{kind}:{}", column.components);
    }
    writeln!(out, "{}\nProperties={properties}", particles.len())?;
    for (i, position) in particles.positions.iter().enumerate() {
        let symbol = species.map_or("X", |species| symbol(species.get(i, 0)));
        write!(
            out,
            "{symbol} {:?} {:?} {:?}",
            position.x, position.y, position.z
        )?;
        for column in &columns {
            for k in i * column.components..(i + 1) * column.components {
                write!(out, " ")?;
                column.data.write_text(k, out)?;
            }
        }
        writeln!(out)?;
    }
    Ok(Vec::new())
}
