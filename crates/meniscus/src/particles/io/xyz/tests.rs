use super::*;
use crate::particles::ColumnData;

const PLAIN: &str = "3\n a comment\n O  0.5 -1 2e1\n  He 1 2 3\n Q2 4 5 6\n";
const EXTENDED: &str = "2\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:CS:R:2:tag:S:1:n:I:1:fix:L:1 E=-1\n\
    C\t1\t2\t3\t0.5\t-0.5\tab\t7\tT\nX 4 5 6 1 2 cd 8 F\n";

fn positions(text: &str, frame: usize) -> Vec<[f64; 3]> {
    let parsed = read(text.as_bytes(), frame).unwrap();
    parsed
        .particles
        .positions
        .iter()
        .map(|p| p.to_array())
        .collect()
}

#[test]
fn plain_rows_have_a_symbol_and_a_position() {
    assert!(detect(PLAIN.as_bytes()));
    assert_eq!(
        positions(PLAIN, 0),
        [[0.5, -1.0, 20.0], [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    );
    let parsed = read(PLAIN.as_bytes(), 0).unwrap();
    assert_eq!(parsed.frames, 1);
    assert_eq!(
        parsed.particles.columns,
        [Column::new("atomic_number", 1, vec![8_u8, 2, 0])]
    );
    assert_eq!(positions("1\n\n6 1 2 3\n", 0), [[1.0, 2.0, 3.0]]);
    let bare = read(b"1\n\n6 1 2\n", 0).unwrap();
    assert!(
        bare.particles.columns.is_empty(),
        "three numbers are a position"
    );
    let more = read(b"1\n\nH 1 2 3 0.25 ab\n", 0).unwrap();
    assert_eq!(
        more.particles.columns[1],
        Column::new("column_5", 1, vec![0.25])
    );
    assert!(more.warnings[0].contains("column_6"));
    assert_eq!(positions("0\nnothing\n", 0), [[0.0; 3]; 0]);
}

#[test]
fn extended_rows_are_as_their_comment_describes() {
    assert!(detect(EXTENDED.as_bytes()));
    let parsed = read(EXTENDED.as_bytes(), 0).unwrap();
    assert_eq!(parsed.particles.positions[1], DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(
        parsed.particles.columns,
        [
            Column::new("atomic_number", 1, vec![6_u8, 0]),
            Column::new("CS", 2, vec![0.5, -0.5, 1.0, 2.0]),
            Column::new("n", 1, vec![7, 8]),
            Column::new("fix", 1, ColumnData::U8(vec![1, 0])),
        ]
    );
    assert!(parsed.warnings[0].contains("tag"), "{:?}", parsed.warnings);
    let dummies = "1\nProperties=\"species:S:1:pos:R:3\"\nX 1 2 3\n";
    assert!(
        read(dummies.as_bytes(), 0)
            .unwrap()
            .particles
            .columns
            .is_empty()
    );
    for wrong in [
        "pos:R",
        "pos:R:3:a:Q:1",
        "a:R:3",
        "pos:R:x",
        "pos:R:3:species:S:1:type:S:1",
    ] {
        let text = format!("1\nProperties={wrong}\nX 1 2 3\n");
        let error = read(text.as_bytes(), 0).unwrap_err();
        assert_eq!(error.place, Place::Line(2), "{wrong}: {error}");
        assert!(error.help.is_some());
    }
}

#[test]
fn frames_are_counted_and_chosen() {
    let file = "1\na\nH 1 0 0\n\n2\nb\nH 2 0 0\nH 3 0 0\n1\nc\nH 4 0 0\n\n\n";
    assert_eq!(positions(file, 1), [[2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    assert_eq!(read(file.as_bytes(), 0).unwrap().frames, 3);
    assert_eq!(positions(file, 2), [[4.0, 0.0, 0.0]]);
    let beyond = read(file.as_bytes(), 3).unwrap();
    assert_eq!((beyond.frames, beyond.particles.len()), (3, 0));
    let cut = &file[..file.len() - 12];
    let parsed = read(cut.as_bytes(), 0).unwrap();
    assert_eq!(parsed.frames, 2);
    assert!(
        parsed.warnings[0].contains("ignored"),
        "{:?}",
        parsed.warnings
    );
    assert!(read(cut.as_bytes(), 2).is_err());
}

#[test]
fn damaged_frames_are_errors_with_their_line() {
    for (text, line, problem) in [
        ("3\n\nH 1 2 3\nH 1 2 3\n", 4, "of 3 atoms"),
        ("2\n\nH 1 2 3\nH 1 two 3\n", 4, "\"two\""),
        ("2\n\nH 1 2 3\nH 1 2\n", 4, "ends before"),
        (
            "18446744073709551615\n\nH 1 2 3\n",
            3,
            "18446744073709551615",
        ),
        (
            "1\n\nH 1 2 3\n99999999999999999999\n",
            4,
            "\"99999999999999999999\"",
        ),
    ] {
        let frame = usize::from(line == 4 && text.starts_with('1'));
        let error = read(text.as_bytes(), frame).unwrap_err();
        assert_eq!(error.place, Place::Line(line), "{text:?}: {error}");
        assert!(error.problem.contains(problem), "{text:?}: {error}");
    }
    for length in 0..PLAIN.len() - 2 {
        let cut = &PLAIN.as_bytes()[..length];
        assert!(!detect(cut) || read(cut, 0).is_err(), "cut at {length}");
    }
}

#[test]
fn bare_rows_may_have_names() {
    let text = "# made by hand\n0 1 2 5\n\n3 4.5 6 7\n";
    assert!(detect(text.as_bytes()));
    assert_eq!(positions(text, 0), [[0.0, 1.0, 2.0], [3.0, 4.5, 6.0]]);
    let parsed = read(text.as_bytes(), 0).unwrap();
    assert_eq!(
        parsed.particles.columns,
        [Column::new("column_4", 1, vec![5, 7])]
    );
    for heading in ["# rho x y z", "rho x y z"] {
        let text = format!("{heading}\n9 0 1 2\n8 3 4 5\n");
        assert!(detect(text.as_bytes()), "{heading}");
        let parsed = read(text.as_bytes(), 0).unwrap();
        assert_eq!(parsed.particles.positions[1], DVec3::new(3.0, 4.0, 5.0));
        assert_eq!(
            parsed.particles.columns,
            [Column::new("rho", 1, vec![9, 8])]
        );
    }
    let error = read(b"0 1 2\n3 4\n", 0).unwrap_err();
    assert_eq!(
        (error.place, error.problem.as_str()),
        (Place::Line(2), "2 numbers, the first row has 3")
    );
    assert!(read(b"0 1 2\n3 4 5 6\n", 0).is_err());
    assert!(
        read(b"0 1 2\n3 x 5\n", 0)
            .unwrap_err()
            .problem
            .contains("\"x\"")
    );
    for other in [
        "hello world again\n",
        "1 2\n",
        "v 1 2 3\n",
        "",
        "\n\n",
        "1 2 3\nabc\n",
    ] {
        assert!(!detect(other.as_bytes()), "{other:?}");
    }
}
