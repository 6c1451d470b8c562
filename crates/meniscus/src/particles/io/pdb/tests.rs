use super::*;
use crate::particles::ColumnData;
use crate::particles::io::tests_support::survives_damage;

const PROTEIN: &str = "\
HEADER    MADE BY HAND
CRYST1   22.000   22.000   22.000  90.00  90.00  90.00 P 1           1
ATOM      1  N   ALA A   1      -8.901   4.127  -0.555  1.00  5.50           N
ATOM      2  CA AALA A   1      -8.608   3.135  -1.618  0.40  6.00           C
ANISOU    2  CA AALA A   1      688   1234    806    -19    -49    178       C
ATOM      3  CA BALA A   1      -8.500   3.000  -1.500  0.60  7.00           C
ANISOU    3  CA BALA A   1     2500    900    100     10    -20     30       C
ATOM      4  CA CALA A   1      -8.400   3.000  -1.500  0.60  7.00           C
ANISOU    4  CA CALA A   1     9999   9999   9999    -19    -49    178       C
HETATM    5 ZN    ZN B 101A      1.000   2.000   3.000  1.00  9.00          ZN2+
TER
END
";

fn read_text(text: &str) -> Parsed {
    read(text.as_bytes(), 0).unwrap()
}

fn column<'a>(parsed: &'a Parsed, name: &str) -> &'a ColumnData {
    &parsed.particles.column(name).unwrap().data
}

fn numbers(parsed: &Parsed, name: &str) -> Vec<f64> {
    let data = column(parsed, name);
    (0..data.len()).map(|i| data.get(i)).collect()
}

#[test]
fn columns_alternates_and_charges() {
    assert!(detect(PROTEIN.as_bytes()));
    let parsed = read_text(PROTEIN);
    assert_eq!(parsed.frames, 1);
    let positions: Vec<_> = parsed
        .particles
        .positions
        .iter()
        .map(|p| p.to_array())
        .collect();
    // Of the three alternates the one with the highest occupancy that comes first.
    assert_eq!(
        positions,
        [[-8.901, 4.127, -0.555], [-8.5, 3.0, -1.5], [1.0, 2.0, 3.0]]
    );
    assert_eq!(parsed.particles.rows, [0, 2, 4]);
    assert!(
        parsed.warnings[0].contains("2 alternate locations"),
        "{:?}",
        parsed.warnings
    );
    assert_eq!(numbers(&parsed, "atomic_number"), [7.0, 6.0, 30.0]);
    assert_eq!(*column(&parsed, "radius"), vec![1.55_f32, 1.7, 1.39].into());
    assert_eq!(numbers(&parsed, "serial"), [1.0, 3.0, 5.0]);
    // In Å², of the alternate that stays; those of the others from their isotropic B.
    let [n, zn] = [5.5, 9.0].map(|b| b / (8.0 * std::f64::consts::PI.powi(2)));
    let expected = [
        [n, n, n, 0.0, 0.0, 0.0],
        [0.25, 0.09, 0.01, 0.001, -0.002, 0.003],
        [zn, zn, zn, 0.0, 0.0, 0.0],
    ];
    for (found, expected) in numbers(&parsed, "anisou")
        .iter()
        .zip(expected.as_flattened())
    {
        assert!((found - expected).abs() < 1e-7, "{found} {expected}");
    }
    assert_eq!(numbers(&parsed, "residue"), [1.0, 1.0, 101.0]);
    assert_eq!(numbers(&parsed, "chain"), [0.0, 0.0, 1.0]);
    assert_eq!(numbers(&parsed, "hetero"), [0.0, 0.0, 1.0]);
    assert_eq!(
        *column(&parsed, "occupancy"),
        vec![1.0_f32, 0.6, 1.0].into()
    );
    assert_eq!(*column(&parsed, "b_factor"), vec![5.5_f32, 7.0, 9.0].into());
    assert_eq!(numbers(&parsed, "charge"), [0.0, 0.0, 2.0]);
}

#[test]
fn alternates_without_occupancy_are_names_that_ran_over() {
    let parsed = read_text(
        "ATOM      9  H112BENZ    1       3.101   2.907  -8.570\n\
         ATOM     10  H113BENZ    1       3.795   3.050  -6.926\n",
    );
    assert_eq!(parsed.particles.len(), 2);
    assert!(parsed.particles.column("occupancy").is_none());
    assert_eq!(numbers(&parsed, "atomic_number"), [1.0, 1.0]);
}

#[test]
fn models_and_frames_parted_by_end_are_frames() {
    let atom = |x: f64| format!("ATOM      1  N   ALA A   1    {x:8.3}   0.000   0.000\n");
    let (a, b) = (atom(1.0), atom(2.0));
    for text in [
        format!("MODEL        1\n{a}ENDMDL\nMODEL        2\n{b}ENDMDL\nEND\n"),
        format!("MODEL 0\n{a}MODEL 1\n{b}"),
        format!("{a}END\n{b}END\n"),
        format!("{a}ENDMDL\nEND\n{b}"),
    ] {
        let first = read(text.as_bytes(), 0).unwrap();
        let second = read(text.as_bytes(), 1).unwrap();
        assert_eq!((first.frames, second.frames), (2, 2), "{text}");
        assert_eq!(first.particles.positions, [DVec3::X], "{text}");
        assert_eq!(second.particles.positions, [2.0 * DVec3::X], "{text}");
    }
}

#[test]
fn serials_outgrow_their_columns_in_five_ways() {
    let serials = |words: &[&str]| {
        let text: String = words
            .iter()
            .map(|word| format!("{word}  CA  GLY A   1       1.000   0.000   0.000\n"))
            .collect();
        numbers(&read_text(&text), "serial")
    };
    assert_eq!(
        serials(&["ATOM  99999", "ATOM  A0000", "ATOM  A000Z"]),
        [99_999.0, 100_000.0, 100_035.0]
    );
    assert_eq!(
        serials(&["ATOM  ZZZZZ", "ATOM  a0000"]),
        [43_770_015.0, 43_770_016.0]
    );
    assert_eq!(
        serials(&["ATOM  99999", "ATOM  186a0", "ATOM  186a1"]),
        [99_999.0, 1e5, 100_001.0]
    );
    assert_eq!(
        serials(&["ATOM  99999", "ATOM  *****", "ATOM  *****"]),
        [99_999.0, 1e5, 100_001.0]
    );
    let shifted = |line: &str| numbers(&read_text(line), "serial");
    assert_eq!(
        shifted("ATOM  100000 CA  GLY A   1       1.000   0.000   0.000\n"),
        [1e5]
    );
    assert_eq!(
        shifted("ATOM 1000000 CA  GLY A   1       1.000   0.000   0.000\n"),
        [1e6]
    );
    assert_eq!(
        shifted("HETATM100000 CA  GLY A   1       1.000   0.000   0.000\n"),
        [1e5]
    );
}

#[test]
fn residues_outgrow_theirs_too() {
    for (text, number, insertion) in [
        ("1", 1, ""),
        ("-5", -5, ""),
        ("1A", 1, "A"),
        ("9999", 9999, ""),
        ("10000", 10_000, ""),
        ("A000", 10_000, ""),
        ("a000", 1_223_056, ""),
        ("", 0, ""),
        ("****", 0, ""),
    ] {
        assert_eq!(
            residue_number(text.as_bytes()),
            (number, insertion.as_bytes()),
            "{text}"
        );
    }
}

#[test]
fn segments_stand_in_for_chains_and_names_for_elements() {
    let parsed = read_text(
        "ATOM      1  N   PRO     1      -7.107  15.915   5.611  1.00  1.00      PROA\n\
         ATOM      2  HN1 PRO     1      -7.623  16.764   5.779  1.00  0.00      PROA\n\
         ATOM  29997  OH2 TIP3 8963      37.745 -20.077  13.635  1.00  0.00      SOLV\n\
         ATOM  50292  CLA CLA     7      25.571 -21.402   9.795  1.00  0.00      CLA \n\
         ATOM   1NPC  CA  GLY     7      25.571 -21.402   9.795  1.00  0.00      1NPC 123\n",
    );
    assert_eq!(
        numbers(&parsed, "atomic_number"),
        [7.0, 1.0, 8.0, 17.0, 6.0]
    );
    assert_eq!(numbers(&parsed, "chain"), [0.0, 0.0, 1.0, 2.0, 3.0]);
    assert_eq!(numbers(&parsed, "residue")[2], 8963.0);
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let fails = |text: &str, parts: &[&str]| {
        let message = read(text.as_bytes(), 0).unwrap_err().to_string();
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    };
    fails("HEADER    EMPTY\nEND\n", &["no ATOM or HETATM"]);
    fails(
        &PROTEIN.replace("  -0.555", "  -0.x55"),
        &["line 3", "z in columns 47 to 54", "-0.x55"],
    );
    fails(
        "ATOM      1  N   ALA A   1      -8.901   4.127\n",
        &["line 1", "z in columns 47 to 54", "46 bytes"],
    );
    let starred = read_text(&PROTEIN.replace("  -8.901", "********"));
    assert!(starred.particles.positions[0].x.is_nan());
    assert!(
        starred.warnings.iter().any(|w| w.contains("*****")),
        "{:?}",
        starred.warnings
    );
}

#[test]
fn damaged_files_do_not_panic() {
    survives_damage(PROTEIN.as_bytes(), 5, |bytes| {
        let _ = read(bytes, 0);
    });
}

#[test]
fn displacements_belong_to_the_atom_before_them() {
    let lines: Vec<&str> = PROTEIN.lines().collect();
    let anisou = lines[4];
    // Behind another atom, cut short, and no numbers.
    let moved = [lines[2], anisou, lines[7], "ANISOU", "END"].join("\n");
    let parsed = read_text(&moved);
    assert!(parsed.particles.column("anisou").is_none());
    assert!(
        parsed
            .warnings
            .iter()
            .any(|w| w.contains("2 ANISOU records"))
    );
    let wrong = [lines[3], &anisou.replace("1234", "12x4")].join("\n");
    let found = numbers(&read_text(&wrong), "anisou");
    assert!(found[1].is_nan() && found[2].is_finite(), "{found:?}");
}
