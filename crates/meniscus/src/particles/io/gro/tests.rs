use super::*;
use crate::particles::ColumnData;
use crate::particles::io::tests_support::survives_damage;

const TWO_FRAMES: &str = "\
water t= 0.0
    4
    1SOL     OW    1   0.230   0.628   0.113  0.1000 -0.2000  0.3000
    1SOL    HW1    2   0.137   0.626   0.150  0.0000  0.0000  0.0000
    1SOL     MW    3   0.231   0.589   0.021  0.0000  0.0000  0.0000
   10CLA    CLA99999  -1.000   0.500   2.000  0.0000  0.0000  0.0000
   1.86000   1.86000   1.86000
water t= 1.0
 1
    1ASN     CA    1-10.23012   0.62812   0.11312
   1 1 1 0 0 0 0 0 0
";

fn column<'a>(parsed: &'a Parsed, name: &str) -> &'a ColumnData {
    &parsed.particles.column(name).unwrap().data
}

#[test]
fn frames_velocities_and_precision() {
    assert!(detect(TWO_FRAMES.as_bytes()));
    let first = read(TWO_FRAMES.as_bytes(), 0).unwrap();
    assert_eq!(first.frames, 2);
    assert_eq!(first.particles.len(), 3);
    assert_eq!(first.particles.positions[0], DVec3::new(0.23, 0.628, 0.113));
    assert_eq!(first.particles.rows, [0, 1, 3]);
    assert_eq!(*column(&first, "atomic_number"), vec![8_u8, 1, 17].into());
    assert_eq!(*column(&first, "residue"), vec![1, 1, 10].into());
    assert_eq!(*column(&first, "serial"), vec![1, 2, 99_999].into());
    assert_eq!(
        *column(&first, "radius"),
        vec![0.152_f32, 0.12, 0.175].into()
    );
    let ColumnData::F32(velocities) = column(&first, "velocity") else {
        panic!("velocities are f32");
    };
    assert_eq!(velocities[..3], [0.1, -0.2, 0.3]);
    assert!(
        first.warnings[0].contains("1 sites without an atom"),
        "{:?}",
        first.warnings
    );

    let second = read(TWO_FRAMES.as_bytes(), 1).unwrap();
    assert_eq!(
        second.particles.positions,
        [DVec3::new(-10.23012, 0.62812, 0.11312)]
    );
    assert_eq!(*column(&second, "atomic_number"), vec![6_u8].into());
    assert!(second.particles.column("velocity").is_none());
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let fails = |text: &str, parts: &[&str]| {
        let error = read(text.as_bytes(), 0).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "{error}");
        }
    };
    fails("title\n", &["line 1", "number of atoms"]);
    fails("title\nmany\n", &["line 2", "number of atoms", "many"]);
    let row = "    1SOL     OW    1   0.230   0.628   0.113\n";
    fails(
        &format!("t\n1000000000\n{row}{row}"),
        &["line 4", "2 of the 1000000000"],
    );
    fails(
        &format!("t\n3\n{row}{row} 1.0 1.0 1.0\n"),
        &["line 5", "2 of the 3"],
    );
    fails(
        &format!("t\n2\n{row}    1SOL     HW    2   0.230   0.6x8   0.113\n"),
        &["line 4", "0.6x8"],
    );
    let running = format!("t\n1\n{row} 1 1 1\nt\n2\n{row}");
    let parsed = read(running.as_bytes(), 0).unwrap();
    assert_eq!(parsed.frames, 1);
    assert!(
        parsed.warnings[0].contains("ignored"),
        "{:?}",
        parsed.warnings
    );
    assert!(!detect(b"title\n1\nnot an atom at all, surely not\n"));
}

#[test]
fn damaged_files_do_not_panic() {
    survives_damage(TWO_FRAMES.as_bytes(), 3, |bytes| {
        let _ = read(bytes, 0);
        let _ = read(bytes, 1);
    });
}
