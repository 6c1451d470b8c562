//! Writes binary VTK legacy files, version 4.2: an UNSTRUCTURED_GRID of vertices whose columns stand
//! in one FIELD. ParaView, vtk, meshio and splashsurf all read that form; meshio takes no POLYDATA,
//! splashsurf no newer version, and vtk's readers by default only the first of several SCALARS.
//!
//! The type `long` has another size on Windows, and `vtktypeint64` is read by vtk only, so 64-bit
//! integers are stored with 32 bits where that loses nothing.

use super::write::fit_f32;
use crate::particles::{ColumnData, Particles};
use std::io::{Error, ErrorKind, Result, Write};

/// Writes all columns.
pub(super) fn write(particles: &Particles, out: &mut impl Write) -> Result<Vec<String>> {
    let count = particles.len();
    // Both the vertices and the size of their list are 32-bit numbers.
    let vertices = i32::try_from(count.saturating_mul(2)).map_err(|_| {
        let problem = format!("a VTK legacy file holds fewer than 2³⁰ points, not {count}");
        Error::new(ErrorKind::InvalidInput, problem)
    })? / 2;
    let single = fit_f32(particles);
    let kind = if single { "float" } else { "double" };
    write!(
        out,
        "# vtk DataFile Version 4.2\nparticles\nBINARY\nDATASET UNSTRUCTURED_GRID\n\
         POINTS {count} {kind}\n"
    )?;
    let coordinates = particles.positions.iter().flat_map(|p| p.to_array());
    if single {
        put(coordinates.map(|x| (x as f32).to_be_bytes()), out)?;
    } else {
        put(coordinates.map(f64::to_be_bytes), out)?;
    }
    write!(out, "\nCELLS {count} {}\n", 2 * count)?;
    put(
        (0..vertices).flat_map(|i| [1, i].map(i32::to_be_bytes)),
        out,
    )?;
    write!(out, "\nCELL_TYPES {count}\n")?;
    put((0..vertices).map(|_| VTK_VERTEX.to_be_bytes()), out)?;
    write!(out, "\nPOINT_DATA {count}\n")?;
    if !particles.columns.is_empty() {
        writeln!(out, "FIELD FieldData {}", particles.columns.len())?;
    }
    for (index, column) in particles.columns.iter().enumerate() {
        let name = encoded(&column.name, index);
        write!(out, "{name} {} {count} ", column.components)?;
        put_column(&column.data, out)?;
        writeln!(out)?;
    }
    Ok(Vec::new())
}

const VTK_VERTEX: i32 = 1;

/// Writes the type's name, the end of the line and the numbers.
fn put_column(data: &ColumnData, out: &mut impl Write) -> Result<()> {
    macro_rules! store {
        ($name:literal, $numbers:expr) => {{
            writeln!(out, $name)?;
            put($numbers.map(|number| number.to_be_bytes()), out)
        }};
    }
    match data {
        ColumnData::I8(values) => store!("char", values.iter()),
        ColumnData::U8(values) => store!("unsigned_char", values.iter()),
        ColumnData::I16(values) => store!("short", values.iter()),
        ColumnData::U16(values) => store!("unsigned_short", values.iter()),
        ColumnData::I32(values) => store!("int", values.iter()),
        ColumnData::U32(values) => store!("unsigned_int", values.iter()),
        ColumnData::F32(values) => store!("float", values.iter()),
        ColumnData::F64(values) => store!("double", values.iter()),
        ColumnData::I64(values) if values.iter().all(|&value| i32::try_from(value).is_ok()) => {
            store!("int", values.iter().map(|&value| value as i32))
        }
        ColumnData::U64(values) if values.iter().all(|&value| u32::try_from(value).is_ok()) => {
            store!("unsigned_int", values.iter().map(|&value| value as u32))
        }
        ColumnData::I64(values) => store!("vtktypeint64", values.iter()),
        ColumnData::U64(values) => store!("vtktypeuint64", values.iter()),
    }
}

/// Writes numbers in blocks.
fn put<const N: usize>(numbers: impl Iterator<Item = [u8; N]>, out: &mut impl Write) -> Result<()> {
    let mut numbers = numbers.fuse();
    let mut block = Vec::with_capacity(1 << 16);
    loop {
        block.clear();
        for number in numbers.by_ref().take((1 << 16) / N) {
            block.extend_from_slice(&number);
        }
        if block.is_empty() {
            return Ok(());
        }
        out.write_all(&block)?;
    }
}

/// VTK separates names by white space and writes everything unusual as %XX. A name must not be
/// empty.
fn encoded(name: &str, index: usize) -> String {
    if name.is_empty() {
        return format!("column_{index}");
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Column;
    use crate::particles::io::{Format, parse};
    use glam::DVec3;

    fn written(particles: &Particles) -> Vec<u8> {
        let mut bytes = Vec::new();
        assert!(write(particles, &mut bytes).unwrap().is_empty());
        bytes
    }

    fn read_back(particles: &Particles) -> Particles {
        let (format, parsed) = parse(&written(particles), 0).unwrap();
        assert_eq!(format, Format::VtkLegacy);
        assert!(parsed.warnings.is_empty(), "{:?}", parsed.warnings);
        parsed.particles
    }

    #[test]
    fn every_type_comes_back() {
        let mut particles =
            Particles::from_positions(vec![DVec3::new(0.1, -2.0, 1e9), DVec3::splat(0.5)]);
        particles.columns = vec![
            Column::new("i8", 1, vec![-1i8, 2]),
            Column::new("colour", 4, (0..8u8).collect::<Vec<_>>()),
            Column::new("i16", 1, vec![-300i16, 300]),
            Column::new("u16", 1, vec![65535u16, 10]),
            Column::new("i32", 1, vec![i32::MIN, 13]),
            Column::new("id", 1, vec![u32::MAX, 0]),
            Column::new("far", 1, vec![i64::MIN, 1]),
            Column::new("farther", 1, vec![u64::MAX, 1]),
            Column::new("velocity", 3, (0..6).map(|i| i as f32).collect::<Vec<_>>()),
            Column::new("F", 9, (0..18).map(f64::from).collect::<Vec<_>>()),
            Column::new("two words, 5% \"é\"", 1, vec![0.1f64, f64::INFINITY]),
        ];
        assert_eq!(read_back(&particles), particles);
    }

    #[test]
    fn positions_are_single_where_that_is_exact() {
        let exact = Particles::from_positions(vec![DVec3::new(0.5, 1.0, -3.25); 3]);
        assert_eq!(read_back(&exact), exact);
        let inexact = Particles::from_positions(vec![DVec3::splat(0.1); 3]);
        assert_eq!(written(&inexact).len(), written(&exact).len() + 3 * 12 + 1);
    }

    #[test]
    fn wide_integers_are_narrow_where_that_is_exact_and_names_never_empty() {
        let mut particles = Particles::from_positions(vec![DVec3::ZERO; 2]);
        particles.columns = vec![
            Column::new("a", 1, vec![-5i64, 7]),
            Column::new("", 1, vec![5u64, u64::from(u32::MAX)]),
        ];
        let columns = read_back(&particles).columns;
        assert_eq!(columns[0], Column::new("a", 1, vec![-5i32, 7]));
        assert_eq!(columns[1], Column::new("column_1", 1, vec![5, u32::MAX]));
    }

    #[test]
    fn no_particles_are_written_too() {
        let empty = Particles {
            columns: vec![Column::new("density", 1, Vec::<f32>::new())],
            ..Particles::default()
        };
        assert_eq!(read_back(&empty), empty);
    }

    #[test]
    fn blocks_join_without_a_seam() {
        let positions = (0..40_000).map(|i| DVec3::splat(f64::from(i))).collect();
        let particles = Particles::from_positions(positions);
        assert_eq!(read_back(&particles), particles);
    }
}
