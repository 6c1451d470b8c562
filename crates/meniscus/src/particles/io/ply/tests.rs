use super::*;
use crate::particles::ColumnData;
use glam::DVec3;

const HEADER: &str = "element camera 2\nproperty list uchar short ids\nproperty double f\n\
    element vertex 2\nproperty uchar kind\nproperty float x\nproperty double y\n\
    property list uchar int ring\nproperty short z\nproperty uint id\n\
    element face 1\nproperty list uchar int vertex_indices\n";

/// Two vertices between other elements, with a list inside, in either byte order.
fn binary_file(big: bool) -> Vec<u8> {
    let name = if big { "big" } else { "little" };
    let mut file =
        format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}end_header\n").into_bytes();
    macro_rules! put {
        ($($number:expr),*) => {
            $(file.extend(if big { $number.to_be_bytes().to_vec() } else { $number.to_le_bytes().to_vec() });)*
        };
    }
    put!(2_u8, 5_i16, 6_i16, 1.0_f64, 0_u8, 2.0_f64);
    put!(
        7_u8,
        1.5_f32,
        -2.5_f64,
        1_u8,
        99_i32,
        -3_i16,
        4_000_000_000_u32
    );
    put!(8_u8, 0.25_f32, 1e9_f64, 0_u8, 12_i16, 1_u32);
    put!(3_u8, 0_i32, 1_i32, 0_i32);
    file
}

fn check(parsed: &Parsed) {
    assert_eq!(
        parsed.particles.positions,
        [DVec3::new(1.5, -2.5, -3.0), DVec3::new(0.25, 1e9, 12.0)]
    );
    let columns = &parsed.particles.columns;
    assert_eq!(columns.len(), 2);
    assert_eq!(columns[0].name, "kind");
    assert_eq!(columns[0].data, ColumnData::U8(vec![7, 8]));
    assert_eq!(columns[1].name, "id");
    assert_eq!(columns[1].data, ColumnData::U32(vec![4_000_000_000, 1]));
    assert_eq!(parsed.particles.rows, [0, 1]);
    assert_eq!(parsed.warnings, [""; 0]);
}

#[test]
fn lists_and_other_elements_are_skipped_by_their_real_size() {
    check(&read(&binary_file(false), 0).unwrap());
    check(&read(&binary_file(true), 0).unwrap());
}

#[test]
fn ascii_may_have_comments_any_line_end_and_spaces() {
    let text = format!(
        "ply\nformat ascii 1.0\ncomment element vertex 9\nobj_info x\n{HEADER}end_header\n\
         2 5 6 1.0\n0 2\n\n  7 1.5 -2.5   1 99 -3 4000000000 \n\t8 .25 1e9 0 12 1\n3 0 1 0\n"
    );
    check(&read(text.as_bytes(), 0).unwrap());
    check(&read(text.replace('\n', "\r\n").as_bytes(), 0).unwrap());
    check(&read(text.replace('\n', "\r").as_bytes(), 0).unwrap());
}

#[test]
fn binary_cut_anywhere_before_the_last_vertex_is_an_error() {
    let file = binary_file(false);
    let faces = 13;
    for length in 4..file.len() - faces {
        assert!(read(&file[..length], 0).is_err(), "cut at {length}");
    }
    for length in file.len() - faces..file.len() {
        let parsed = read(&file[..length], 0).unwrap();
        assert_eq!(parsed.particles.len(), 2);
        assert!(parsed.warnings[0].contains("face"), "{:?}", parsed.warnings);
    }
}

#[test]
fn a_header_that_promises_too_much_is_an_error_without_memory() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for properties in ["", "property list uchar int l\n"] {
            let text = format!(
                "ply\nformat {format} 1.0\nelement vertex 18446744073709551615\nproperty float x\n\
                 property float y\nproperty float z\n{properties}end_header\n1 2 3\n"
            );
            let error = read(text.as_bytes(), 0).unwrap_err();
            assert!(error.problem.contains("18446744073709551615"), "{error}");
            assert!(error.help.is_some());
        }
    }
    let lists = b"ply\nformat binary_little_endian 1.0\nelement e 1\nproperty list uint double l\n\
        element vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n\xff\xff\xff\xff";
    assert!(read(lists, 0).unwrap_err().problem.contains("\"e\""));
}

#[test]
fn wrong_numbers_are_named_with_their_line() {
    let file = |rows: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
             property float z\nproperty uchar c\nend_header\n{rows}"
        )
    };
    for (rows, line, problem) in [
        ("0 0 0 1\n0 zero 0 1\n", 10, "\"zero\""),
        ("0 0 0 256\n0 0 0 1\n", 9, "c as u8"),
        ("0 0 0\n0 0 0 1\n", 9, "before property \"c\""),
        ("0 0 0 1 9\n0 0 0 1\n", 9, "end of the row"),
        ("0 0 0 1\n", 9, "promises 2 rows"),
    ] {
        let error = read(file(rows).as_bytes(), 0).unwrap_err();
        assert_eq!(error.place, Place::Line(line), "{rows:?}: {error}");
        assert!(error.problem.contains(problem), "{rows:?}: {error}");
    }
}

#[test]
fn headers_that_make_no_sense_are_errors() {
    for (header, problem) in [
        ("ply\n", "end_header"),
        ("ply\nformat ascii 1.0\nend_header\n", "no element"),
        ("ply\nelement vertex 1\nend_header\n", "format"),
        ("ply\nformat binary 1.0\nend_header\n", "\"binary\""),
        (
            "ply\nformat ascii 1.0\nproperty float x\nend_header\n",
            "before the first element",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n",
            "\"-1\"",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n",
            "\"quad\"",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n",
            "integer",
        ),
        ("ply\nformat ascii 1.0\nelement vertex\n", "number of rows"),
        (
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2\n",
            "no property z; it has x, y",
        ),
        (
            "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n",
            "no property x",
        ),
        ("ply\nhello\nend_header\n", "no \"format\" line"),
    ] {
        let error = read(header.as_bytes(), 0).unwrap_err();
        assert!(error.problem.contains(problem), "{header:?}: {error}");
    }
}

#[test]
fn a_few_odd_header_lines_are_ignored_with_a_warning() {
    let file = |odd: usize| {
        let odd = "made by hand\n".repeat(odd);
        format!(
            "ply\nformat ascii 1.0\n{odd}element vertex 1\nproperty float x\nproperty float y\n\
             property float z\nend_header\n1 2 3\n"
        )
    };
    let parsed = read(file(1).as_bytes(), 0).unwrap();
    assert_eq!(
        parsed.warnings,
        ["line 3 of the header was ignored: \"made by hand\""]
    );
    let error = read(file(9).as_bytes(), 0).unwrap_err();
    assert!(error.problem.contains("\"made\""), "{error}");
}

#[test]
fn the_first_element_with_a_position_stands_in_for_vertex() {
    let text = "ply\nformat ascii 1.0\nelement vertex 1\nproperty int id\nelement point 1\n\
        property float X\nproperty float Y\nproperty float Z\nend_header\n5\n1 2 3\n";
    let parsed = read(text.as_bytes(), 0).unwrap();
    assert_eq!(parsed.particles.positions, [DVec3::new(1.0, 2.0, 3.0)]);
}
