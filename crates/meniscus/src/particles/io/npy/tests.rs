use super::*;
use crate::particles::io::npz;
use std::io::Write;

/// An NPY file of some version with this header text and data.
fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut file = b"\x93NUMPY".to_vec();
    file.extend([version, 0]);
    match version {
        1 => file.extend((header.len() as u16).to_le_bytes()),
        _ => file.extend((header.len() as u32).to_le_bytes()),
    }
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn header(descr: &str, fortran: bool, shape: &str) -> String {
    let fortran = if fortran { "True" } else { "False" };
    format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}\n")
}

fn le(values: &[f32]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect()
}

const ROWS: [DVec3; 2] = [DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 5.0, 6.0)];

#[test]
fn every_version_order_and_type_is_read() {
    let rows: [f32; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let by_column: [f32; 6] = [1.0, 4.0, 2.0, 5.0, 3.0, 6.0];
    let big: Vec<u8> = rows
        .iter()
        .flat_map(|&value| f64::from(value).to_be_bytes())
        .collect();
    let shorts: Vec<u8> = rows
        .iter()
        .flat_map(|&value| (value as i16).to_le_bytes())
        .collect();
    for (version, header, data) in [
        (1, header("'<f4'", false, "(2, 3)"), le(&rows)),
        (2, header("'<f4'", true, "(2, 3)"), le(&by_column)),
        (3, header("'>f8'", false, "(2, 3)"), big),
        (1, header("'<i2'", false, "(2, 3)"), shorts),
    ] {
        let file = npy(version, &header, &data);
        assert!(detect(&file));
        let parsed = read(&file, 0).unwrap();
        assert_eq!(parsed.particles.positions, ROWS, "{header}");
        assert!(parsed.particles.columns.is_empty());
        for length in 6..file.len() {
            assert!(
                read(&file[..length], 0).is_err(),
                "{header} cut at {length}"
            );
        }
    }
}

#[test]
fn further_columns_and_named_fields_are_kept() {
    let wide = npy(
        1,
        &header("'<f4'", false, "(2, 4)"),
        &le(&[1.0, 2.0, 3.0, 9.0, 4.0, 5.0, 6.0, 8.0]),
    );
    let parsed = read(&wide, 0).unwrap();
    assert_eq!(parsed.particles.positions, ROWS);
    assert_eq!(
        parsed.particles.columns,
        [Column::new("column_4", 1, vec![9.0_f32, 8.0])]
    );

    let descr = "[('id', '>u2'), ('pos', '<f4', (3,)), ('name', '|S2')]";
    let mut data = Vec::new();
    for (id, row) in [(7_u16, ROWS[0]), (8, ROWS[1])] {
        data.extend(id.to_be_bytes());
        data.extend(le(&row.as_vec3().to_array()));
        data.extend(b"ab");
    }
    let parsed = read(&npy(1, &header(descr, false, "(2,)"), &data), 0).unwrap();
    assert_eq!(parsed.particles.positions, ROWS);
    assert_eq!(
        parsed.particles.columns,
        [Column::new("id", 1, vec![7_u16, 8])]
    );
    assert!(parsed.warnings[0].contains("name"), "{:?}", parsed.warnings);

    let axes = "[('x', '<f4'), ('y', '<f4'), ('m', '<f4'), ('z', '<f4')]";
    let data = le(&[1.0, 2.0, 0.5, 3.0, 4.0, 5.0, 0.25, 6.0]);
    let parsed = read(&npy(1, &header(axes, false, "(2,)"), &data), 0).unwrap();
    assert_eq!(parsed.particles.positions, ROWS);
    assert_eq!(
        parsed.particles.columns,
        [Column::new("m", 1, vec![0.5_f32, 0.25])]
    );
}

#[test]
fn what_makes_no_sense_is_an_error() {
    for (header, problem) in [
        (header("'<f4'", false, "(2,)"), "shape (2,)"),
        (header("'<f4'", false, "(3, 2)"), "shape (3, 2)"),
        (header("'<f4'", false, "(2, 3, 1)"), "shape (2, 3, 1)"),
        (
            header("'<f4'", false, "(99999999999, 3)"),
            "promises an array of shape (99999999999, 3)",
        ),
        (
            header(
                "'<f4'",
                false,
                "(18446744073709551615, 18446744073709551615)",
            ),
            "promises",
        ),
        (header("'<f2'", false, "(2, 3)"), "'<f2'"),
        (header("'|O'", false, "(2, 3)"), "'|O'"),
        (header("'<c8'", false, "(2, 3)"), "'<c8'"),
        (
            header("[('a', '<f4')]", false, "(2,)"),
            "no fields for the position; the array has a",
        ),
        ("{'descr': ".to_owned(), "header"),
        ("(".repeat(1000), "nests"),
        ("[".repeat(8), "header"),
    ] {
        let error = read(&npy(1, &header, &[0; 24]), 0).unwrap_err();
        assert!(error.problem.contains(problem), "{header}: {error}");
    }
    assert!(
        read(&npy(9, "", &[]), 0)
            .unwrap_err()
            .problem
            .contains("version 9")
    );
    let huge = npy(2, &" ".repeat(1 << 17), &[]);
    assert!(read(&huge, 0).unwrap_err().problem.contains("131072 bytes"));
}

fn archive(files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = npyz::npz::NpzWriter::new(&mut bytes);
    for (name, content) in files {
        let zip = writer.zip_writer();
        zip.start_file(*name, Default::default()).unwrap();
        zip.write_all(content).unwrap();
    }
    writer.zip_writer().finish().unwrap();
    drop(writer);
    bytes.into_inner()
}

#[test]
fn archives_give_positions_and_columns_in_their_order() {
    let positions = npy(
        1,
        &header("'<f4'", false, "(2, 3)"),
        &le(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
    );
    let pair = npy(1, &header("'<f4'", false, "(2,)"), &le(&[0.5, 0.25]));
    let time = npy(1, &header("'<f4'", false, "()"), &le(&[0.5]));
    let three = npy(1, &header("'<f4'", false, "(3,)"), &le(&[0.5; 3]));
    let file = archive(&[
        ("mass.npy", pair.clone()),
        ("time.npy", time),
        ("Pos.npy", positions.clone()),
        ("velocity.npy", positions.clone()),
        ("box.npy", three),
        ("readme.txt", b"hello".to_vec()),
    ]);
    assert!(npz::detect(&file));
    let parsed = npz::read(&file, 0).unwrap();
    assert_eq!(parsed.particles.positions, ROWS);
    let names: Vec<&str> = parsed
        .particles
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    assert_eq!(names, ["mass", "velocity"]);
    assert_eq!(parsed.particles.columns[1].components, 3);
    assert!(
        parsed.warnings[0].ends_with("time, box"),
        "{:?}",
        parsed.warnings
    );

    let axes = archive(&[
        ("x.npy", pair.clone()),
        ("y.npy", pair.clone()),
        ("z.npy", pair.clone()),
    ]);
    assert_eq!(
        npz::read(&axes, 0).unwrap().particles.positions[1],
        DVec3::splat(0.25)
    );
    let odd = archive(&[("q.npy", positions), ("m.npy", pair.clone())]);
    let parsed = npz::read(&odd, 0).unwrap();
    assert!(
        parsed.warnings[0].contains("\"q\""),
        "{:?}",
        parsed.warnings
    );
    let none = archive(&[("m.npy", pair)]);
    assert!(
        npz::read(&none, 0)
            .unwrap_err()
            .problem
            .contains("m (2, 1)")
    );
}

#[test]
fn damaged_archives_are_errors() {
    let positions = npy(
        1,
        &header("'<f4'", false, "(2, 3)"),
        &le(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
    );
    let file = archive(&[("positions.npy", positions)]);
    for length in 0..file.len() {
        assert!(npz::read(&file[..length], 0).is_err(), "cut at {length}");
    }
    for at in 0..file.len() {
        let mut damaged = file.clone();
        damaged[at] ^= 0x41;
        // Either an error or, where the byte does not matter, the same positions.
        if let Ok(parsed) = npz::read(&damaged, 0) {
            assert_eq!(parsed.particles.positions, ROWS, "byte {at}");
        }
    }
    let bomb = archive(&[("positions.npy", vec![0; 200 << 20])]);
    let error = npz::read(&bomb, 0).unwrap_err();
    assert!(error.problem.contains("unfolds"), "{error}");
}
