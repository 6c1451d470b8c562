//! Writes NPY (positions only) and NPZ (array `positions` and one array per column).

use super::write::fit_f32;
use crate::particles::{ColumnData, Particles};
use npyz::npz::NpzWriter;
use npyz::{AutoSerialize, WriteOptions, WriterBuilder};
use std::io::{Error, ErrorKind, Result, Seek, Write};

/// Writes positions as an array (n, 3) of f32, or f64 where f32 would lose digits; returns the names
/// of all columns.
pub(super) fn write_npy<W: Write + Seek>(
    particles: &Particles,
    out: &mut W,
) -> Result<Vec<String>> {
    write_positions(particles, out)?;
    Ok(particles
        .columns
        .iter()
        .map(|column| column.name.clone())
        .collect())
}

/// Writes positions and every column in its own type, (n,) or (n, components).
pub(super) fn write_npz<W: Write + Seek>(
    particles: &Particles,
    out: &mut W,
) -> Result<Vec<String>> {
    let mut archive = NpzWriter::new(out);
    let mut names = vec!["positions".to_owned()];
    start(&mut archive, "positions")?;
    write_positions(particles, archive.zip_writer())?;
    let mut lost = Vec::new();
    for column in &particles.columns {
        if names.contains(&column.name) {
            lost.push(column.name.clone());
            continue;
        }
        names.push(column.name.clone());
        start(&mut archive, &column.name)?;
        let rows = particles.len() as u64;
        let shape = [rows, column.components as u64];
        let shape = &shape[..if column.components == 1 { 1 } else { 2 }];
        let zip = archive.zip_writer();
        macro_rules! by_type {
            ($($variant:ident)*) => {
                match &column.data { $(ColumnData::$variant(values) => {
                    write_array(zip, shape, values.iter().copied())?;
                })* }
            };
        }
        by_type!(I8 U8 I16 U16 I32 U32 I64 U64 F32 F64);
    }
    archive.zip_writer().finish().map_err(zip_error)?;
    Ok(lost)
}

fn start<W: Write + Seek>(archive: &mut NpzWriter<W>, name: &str) -> Result<()> {
    archive
        .zip_writer()
        .start_file(
            npyz::npz::file_name_from_array_name(name),
            Default::default(),
        )
        .map_err(zip_error)
}

fn zip_error(error: impl std::fmt::Display) -> Error {
    Error::other(error.to_string())
}

fn write_positions(particles: &Particles, out: impl Write) -> Result<()> {
    let shape = [particles.len() as u64, 3];
    let numbers = particles.positions.iter().flat_map(|p| p.to_array());
    if fit_f32(particles) {
        write_array(out, &shape, numbers.map(|x| x as f32))
    } else {
        write_array(out, &shape, numbers)
    }
}

fn write_array<T: AutoSerialize>(
    out: impl Write,
    shape: &[u64],
    values: impl Iterator<Item = T>,
) -> Result<()> {
    let mut array = WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .writer(out)
        .begin_nd()?;
    array.extend(values)?;
    array
        .finish()
        .map_err(|error| Error::new(ErrorKind::InvalidData, error))
}
