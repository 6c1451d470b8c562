use super::*;
use crate::particles::io::Place;
use crate::particles::io::tests_support::survives_damage;
use crate::particles::{Column, Particles};

fn parsed(content: &[u8]) -> Particles {
    assert!(detect(content));
    read(content, 0).unwrap().particles
}

/// Puts numbers behind one another as big-endian bytes.
macro_rules! packed {
    ($type:ty: $($number:expr),*) => {
        [$(($number as $type).to_be_bytes()),*].concat()
    };
}

const ASCII: &str = "# vtk DataFile Version 2.0\r\n\r\nascii\r\n\
    FIELD before 1\r\nTIME 1 1 double\r\n0.5\r\n\
    dataset POLYDATA\r\npoints 2\tFLOAT 0.1 2\r\n3 -4\r\n5e1 nan\r\n\
    Vertices 2 4\r\n1 0 1 1\r\nMETADATA\r\nINFORMATION 0\r\n\r\n\
    POINT_DATA 2\r\n\
    SCALARS plain int\r\nLOOKUP_TABLE own\r\n7 -8\r\n\
    LOOKUP_TABLE own 2\r\n0 0 0 1 1 1 1 1\r\n\
    scalars no%20table%25 unsigned_char 2\r\n1 2 3 4\r\n\
    NORMALS n double\r\n0 0 1 0 1 0\r\n\
    COLOR_SCALARS colour 3\r\n0 0.5 1 0.1 0.3 7\r\n\
    TEXTURE_COORDINATES uv 2 float\r\n0 1 2 3\r\n\
    TENSORS6 metric float\r\n1 2 3 4 5 6 7 8 9 10 11 12\r\n\
    FIELD f 5\r\nflag 1 2 bit\r\n1 0\r\nMETADATA\r\nCOMPONENT_NAMES\r\nx\r\n\r\n\
    word 1 2 string\r\nan%20apple\r\n\r\nNULL_ARRAY\r\n\
    any 1 2 variant\r\n11 3.5 6 -1\r\nshort 1 1 int\r\n3\r\n\
    CELL_DATA 1\r\nVECTORS v float\r\n1 2 3\r\nCOLOR_SCALARS c 1\r\n0.5\r\n";

#[test]
fn ascii_with_every_attribute() {
    let read = read(ASCII.as_bytes(), 0).unwrap();
    let particles = read.particles;
    let first = DVec3::new(f64::from(0.1f32), 2.0, 3.0);
    assert_eq!(particles.positions[0], first);
    assert_eq!(
        particles.positions[1].truncate(),
        glam::DVec2::new(-4.0, 50.0)
    );
    assert!(particles.positions[1].z.is_nan());
    let tensor: Vec<f32> = (1..13u8).map(f32::from).collect();
    assert_eq!(
        particles.columns,
        [
            Column::new("plain", 1, vec![7i32, -8]),
            Column::new("no table%", 2, vec![1u8, 2, 3, 4]),
            Column::new("n", 3, vec![0.0f64, 0.0, 1.0, 0.0, 1.0, 0.0]),
            Column::new("colour", 3, vec![0u8, 128, 255, 26, 77, 255]),
            Column::new("uv", 2, vec![0.0f32, 1.0, 2.0, 3.0]),
            Column::new("metric", 6, tensor),
            Column::new("flag", 1, vec![1u8, 0]),
        ]
    );
    let warned = |name| read.warnings.iter().any(|warning| warning.contains(name));
    assert!(warned("\"word\"") && warned("\"any\"") && warned("\"short\""));
    assert_eq!(read.warnings.len(), 3);
}

/// Binary, version 5.1: cells as offsets and connectivity, metadata, packed strings and bits.
fn binary_51() -> Vec<u8> {
    [
        b"# vtk DataFile Version 5.1\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 2 double\n"
            .as_slice(),
        &packed!(f64: 0.1, 2, 3, -4, 5, 6),
        b"\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 1 2 \n\n",
        b"CELLS 3 2\nOFFSETS vtktypeint64\n",
        &packed!(i64: 0, 1, 2),
        b"\nCONNECTIVITY vtktypeint64\n",
        &packed!(i64: 0, 1),
        b"\nCELL_TYPES 2\n",
        &packed!(i32: 1, 1),
        b"\nCELL_DATA 2\nSCALARS c float\nLOOKUP_TABLE default\n",
        &packed!(f32: 1, 2),
        b"\nPOINT_DATA 2\nFIELD FieldData 4\nids 1 2 vtkIdType\n",
        &packed!(i32: 7, -1),
        b"\nbits 1 2 bit\n\x40\nwords 1 2 string\n\xc1A\x80\x02BC\nfar 1 2 vtktypeuint64\n",
        &packed!(u64: u64::MAX, 1),
        b"\nSCALARS s short 1\nLOOKUP_TABLE default\n",
        &packed!(i16: -2, 2570),
        b"\nCOLOR_SCALARS rgb 3\n\x01\x02\x03\x0a\x0d\xff\n",
    ]
    .concat()
}

/// Binary, version 3.0: cells in one list; bytes that look like line ends start the arrays.
fn binary_30() -> Vec<u8> {
    [
        b"# vtk DataFile Version 3.0\r\nt\r\nBINARY\r\nDATASET POLYDATA\r\nPOINTS 1 int\r\n"
            .as_slice(),
        &packed!(i32: 0x0a0d_0a0d, -2, 3),
        b"VERTICES 1 2\r\n",
        &packed!(i32: 1, 0),
        b"POINT_DATA 1\r\nVECTORS v unsigned_short\r\n",
        &packed!(u16: 0x0a20, 2, 3),
    ]
    .concat()
}

#[test]
fn binary_in_both_cell_styles() {
    let particles = parsed(&binary_51());
    let positions = [DVec3::new(0.1, 2.0, 3.0), DVec3::new(-4.0, 5.0, 6.0)];
    assert_eq!(particles.positions, positions);
    assert_eq!(
        particles.columns,
        [
            Column::new("ids", 1, vec![7i32, -1]),
            Column::new("bits", 1, vec![0u8, 1]),
            Column::new("far", 1, vec![u64::MAX, 1]),
            Column::new("s", 1, vec![-2i16, 2570]),
            Column::new("rgb", 3, vec![1u8, 2, 3, 10, 13, 255]),
        ]
    );
    let particles = parsed(&binary_30());
    let first = DVec3::new(f64::from(0x0a0d_0a0d), -2.0, 3.0);
    assert_eq!(particles.positions, [first]);
    assert_eq!(
        particles.columns,
        [Column::new("v", 3, vec![0x0a20u16, 2, 3])]
    );
}

#[test]
fn grids_with_points_and_files_without_any() {
    let grid = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 1 1 2\n\
        POINTS 2 float\n0 0 0 1 1 1";
    assert_eq!(parsed(grid.as_bytes()).len(), 2);
    let empty =
        "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n\n";
    assert_eq!(parsed(empty.as_bytes()), Particles::default());
    let cells = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n\
        0 0 0\nCELLS 0 0\nCELL_TYPES 0\nCELL_DATA 0\nSCALARS a int\nPOINT_DATA 1\n";
    let read = read(cells.as_bytes(), 0).unwrap();
    assert_eq!(read.particles.len(), 1);
    assert!(read.warnings[0].contains("cells"), "{:?}", read.warnings);
}

#[test]
fn errors_say_where_and_what() {
    let head = "# vtk DataFile Version 3.0\nt\n";
    for (body, place, problem) in [
        ("XML\n", Place::Line(3), "ASCII or BINARY"),
        ("ASCII\nDATASET STRUCTURED_POINTS\n", Place::Line(4), "grid"),
        ("ASCII\nDATASET GRAPH\n", Place::Line(4), "POLYDATA"),
        ("ASCII\nDATASET POLYDATA\n", Place::Line(4), "POINTS"),
        (
            "ASCII\nPOINTS x float\n",
            Place::Line(4),
            "number of points",
        ),
        ("ASCII\nPOINTS -1 float\n", Place::Line(4), "\"-1\""),
        ("ASCII\nPOINTS 1 foot\n", Place::Line(4), "\"foot\""),
        ("ASCII\nPOINTS 1 string\n", Place::Line(4), "number type"),
        ("ASCII\nPOINTS 1 float\n0 0\n?\n", Place::Line(6), "\"?\""),
        ("ASCII\nPOINTS 1 float\n0     0", Place::Line(5), "after 2"),
        (
            "ASCII\nPOINTS 9999999999 float\n0 0 0\n",
            Place::Line(4),
            "announced",
        ),
        (
            "ASCII\nPOINTS 9223372036854775807 float\n0",
            Place::Line(4),
            "×",
        ),
        (
            "ASCII\nPOINTS 1 float\n0 0 0\nPOINT_DATA 2",
            Place::Line(6),
            "2 points",
        ),
        (
            "ASCII\nPOINTS 1 float\n0 0 0\nSCALARS a int\n1",
            Place::Line(6),
            "POINT_DATA",
        ),
        (
            "ASCII\nPOINTS 1 float\n0 0 0\nHELLO\n",
            Place::Line(6),
            "\"HELLO\"",
        ),
        (
            "ASCII\nPOINTS 0 int\nPOINTS 0 int\n",
            Place::Line(5),
            "second",
        ),
        (
            "BINARY\nPOINTS 1 float\n01234567890",
            Place::Byte(51),
            "only 11 bytes",
        ),
        (
            "BINARY\nPOINTS 99999999999 double\n0123",
            Place::Byte(62),
            "only 4 bytes",
        ),
    ] {
        let content = format!("{head}{body}");
        let error = read(content.as_bytes(), 0).unwrap_err();
        assert!(error.problem.contains(problem), "{body:?}: {error}");
        assert_eq!(error.place, place, "{body:?}: {error}");
    }
}

#[test]
fn damage_never_panics() {
    for content in [ASCII.as_bytes().to_vec(), binary_51(), binary_30()] {
        survives_damage(&content, 1, |bytes| drop(read(bytes, 0)));
    }
}

#[test]
fn other_content_is_not_ours() {
    assert!(detect(b"\xef\xbb\xbf# VTK datafile version 2.0"));
    for other in [b"# vtk DataFil".as_slice(), b"", b"ply\n# vtk DataFile"] {
        assert!(!detect(other));
    }
}
