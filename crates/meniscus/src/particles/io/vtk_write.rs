//! Writes binary VTK legacy files (version 3.0): POLYDATA with one vertex cell that holds all
//! particles, scalars and vectors as such, other columns as FIELD arrays.

use super::write::fit_f32;
use crate::particles::{Column, ColumnData, Particles};
use std::io::{Error, ErrorKind, Result, Write};

/// Writes all columns.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let count = particles.len();
    let count_i32 = i32::try_from(count)
        .ok()
        .filter(|&count| count < i32::MAX)
        .ok_or_else(|| {
            Error::new(
                ErrorKind::InvalidInput,
                "VTK legacy files hold fewer than 2³¹ points",
            )
        })?;
    let single = fit_f32(particles);
    let kind = if single { "float" } else { "double" };
    write!(
        out,
        "# vtk DataFile Version 3.0\nparticles\nBINARY\nDATASET POLYDATA\nPOINTS {count} {kind}\n"
    )?;
    for position in &particles.positions {
        for x in position.to_array() {
            if single {
                out.write_all(&(x as f32).to_be_bytes())?;
            } else {
                out.write_all(&x.to_be_bytes())?;
            }
        }
    }
    // One polyvertex cell: viewers show the points.
    write!(out, "\nVERTICES 1 {}\n", count + 1)?;
    for number in std::iter::once(count_i32).chain(0..count_i32) {
        out.write_all(&number.to_be_bytes())?;
    }
    write!(out, "\nPOINT_DATA {count}\n")?;
    let (attributes, fields): (Vec<&Column>, Vec<&Column>) = particles
        .columns
        .iter()
        .partition(|column| matches!(column.components, 1 | 3));
    for column in attributes {
        let (name, kind) = (encoded(&column.name), vtk_type(&column.data));
        if column.components == 1 {
            write!(out, "SCALARS {name} {kind} 1\nLOOKUP_TABLE default\n")?;
        } else {
            writeln!(out, "VECTORS {name} {kind}")?;
        }
        write_big_endian(&column.data, out)?;
    }
    if !fields.is_empty() {
        writeln!(out, "FIELD FieldData {}", fields.len())?;
        for column in fields {
            let (name, kind) = (encoded(&column.name), vtk_type(&column.data));
            writeln!(out, "{name} {} {count} {kind}", column.components)?;
            write_big_endian(&column.data, out)?;
        }
    }
    Ok(Vec::new())
}

fn write_big_endian(data: &ColumnData, out: &mut impl Write) -> Result<()> {
    let mut number = Vec::with_capacity(8);
    for i in 0..data.len() {
        number.clear();
        data.put_le_bytes(i..i + 1, &mut number);
        number.reverse();
        out.write_all(&number)?;
    }
    writeln!(out)
}

fn vtk_type(data: &ColumnData) -> &'static str {
    match data {
        ColumnData::I8(_) => "char",
        ColumnData::U8(_) => "unsigned_char",
        ColumnData::I16(_) => "short",
        ColumnData::U16(_) => "unsigned_short",
        ColumnData::I32(_) => "int",
        ColumnData::U32(_) => "unsigned_int",
        ColumnData::I64(_) => "vtktypeint64",
        ColumnData::U64(_) => "vtktypeuint64",
        ColumnData::F32(_) => "float",
        ColumnData::F64(_) => "double",
    }
}

/// VTK separates names by white space and writes everything unusual as %XX.
fn encoded(name: &str) -> String {
    let mut text = String::new();
    for byte in name.bytes() {
        if byte.is_ascii_graphic() && byte != b'%' && byte != b'"' {
            text.push(char::from(byte));
        } else {
            text += &format!("%{byte:02X}");
        }
    }
    text
}
