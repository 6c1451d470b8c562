use super::*;
use crate::particles::ColumnData;
use crate::particles::io::tests_support::survives_damage;

const TWO_MODELS: &str = "# by hand\ndata_T\nloop_\n_entity.id\n_entity.details\n1 'a b'\n2\n;long\ntext\n;\n\
    loop_\n_atom_site.pdbx_PDB_model_num\n_atom_site.Cartn_z\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n\
    _atom_site.type_symbol\n_atom_site.label_atom_id\n_atom_site.label_alt_id\n_atom_site.label_comp_id\n\
    _atom_site.label_asym_id\n_atom_site.auth_seq_id\n_atom_site.occupancy\n_atom_site.group_PDB\n_atom_site.id\n\
    7 3 1 2 N N . ALA A 5 1.0 ATOM 1\n\
    7 6 4.5(3) 5 C \"C1'\" A ALA B -2 0.4 ATOM 2\n\
    7 6 4 5 C \"C1'\" B ALA B -2 0.6 HETATM 3\n\
    3 0 0 ? FE FE . HEM B 9 ? HETATM 1\n\
    _cell.length_a 1\n";

fn column<'a>(parsed: &'a Parsed, name: &str) -> &'a ColumnData {
    &parsed.particles.column(name).unwrap().data
}

#[test]
fn any_order_of_columns_quotes_models_and_alternates() {
    assert!(detect(TWO_MODELS.as_bytes()));
    let parsed = read(TWO_MODELS.as_bytes(), 0).unwrap();
    assert_eq!(parsed.frames, 2);
    let positions: Vec<_> = parsed
        .particles
        .positions
        .iter()
        .map(|p| p.to_array())
        .collect();
    assert_eq!(positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    assert_eq!(parsed.particles.rows, [0, 2]);
    assert_eq!(*column(&parsed, "atomic_number"), vec![7_u8, 6].into());
    assert_eq!(*column(&parsed, "residue"), vec![5, -2].into());
    assert_eq!(*column(&parsed, "chain"), vec![0_u32, 1].into());
    assert_eq!(*column(&parsed, "hetero"), vec![0_u8, 1].into());
    assert_eq!(*column(&parsed, "serial"), vec![1, 3].into());
    assert_eq!(*column(&parsed, "occupancy"), vec![1.0_f32, 0.6].into());
    assert!(
        parsed.warnings[0].contains("1 alternate location"),
        "{:?}",
        parsed.warnings
    );
    let second = read(TWO_MODELS.as_bytes(), 1).unwrap();
    assert_eq!(second.particles.len(), 1);
    assert!(second.particles.positions[0].y.is_nan());
    assert_eq!(*column(&second, "radius"), vec![2.44_f32].into());
}

#[test]
fn one_atom_may_be_written_as_pairs() {
    let text = "data_1\n_atom_site.id 4\n_atom_site.Cartn_x 1\n_atom_site.Cartn_y 2\n\
        _atom_site.Cartn_z 3\n_atom_site.type_symbol ZN\n";
    let parsed = read(text.as_bytes(), 0).unwrap();
    assert_eq!(parsed.particles.positions, [DVec3::new(1.0, 2.0, 3.0)]);
    assert_eq!(*column(&parsed, "atomic_number"), vec![30_u8].into());
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let fails = |text: &str, parts: &[&str]| {
        let error = read(text.as_bytes(), 0).unwrap_err();
        let message = format!("{error} {}", error.help.clone().unwrap_or_default());
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    };
    fails("data_x\n_a 1\n", &["no table _atom_site"]);
    fails(
        "data_x\nloop_\n_atom_site_label\n_atom_site_fract_x\nC 0.1\n",
        &["no table _atom_site", "fractions of a crystal's cell"],
    );
    fails(
        "data_x\nloop_\n_atom_site.id\n_atom_site.Cartn_x\n1 2\n",
        &["line 5", "no column Cartn_y"],
    );
    let cut = &TWO_MODELS[..TWO_MODELS.find("HETATM 3").unwrap()];
    fails(cut, &["line 27", "11 of 13"]);
    fails(
        &TWO_MODELS.replace("7 3 1 2", "7 3 x 2"),
        &["line 25", "Cartn_x", "\"x\""],
    );
}

#[test]
fn damaged_files_do_not_panic() {
    survives_damage(TWO_MODELS.as_bytes(), 3, |bytes| {
        let _ = read(bytes, 0);
        let _ = read(bytes, 1);
    });
}

#[test]
fn displacements_go_by_the_atoms_ids() {
    let table = |letter: &str, factor: f64| {
        let tags: String = ["[2][2]", "[1][1]", "[3][3]", "[1][2]", "[2][3]", "[1][3]"]
            .map(|ij| format!("_atom_site_anisotrop.{letter}{ij}\n"))
            .concat();
        let row = [0.2, 0.1, 0.3, 0.01, 0.03, 0.02].map(|u| format!("{} ", u * factor));
        format!(
            "loop_\n_atom_site_anisotrop.id\n{tags}3 {}\n9 {}\n",
            row.concat(),
            row.concat()
        )
    };
    for (letter, factor) in [("U", 1.0), ("B", 8.0 * std::f64::consts::PI.powi(2))] {
        let (before, after) = TWO_MODELS.split_at(TWO_MODELS.find("loop_\n_atom_site").unwrap());
        for text in [
            format!("{before}{}{after}", table(letter, factor)),
            format!("{TWO_MODELS}{}", table(letter, factor)),
        ] {
            let parsed = read(text.as_bytes(), 0).unwrap();
            let ColumnData::F32(found) = column(&parsed, "anisou") else {
                panic!("floats expected");
            };
            // The first atom has no B either.
            let expected = [
                0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03,
            ];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-7, "{found} {expected}");
            }
        }
    }
    assert!(
        read(TWO_MODELS.as_bytes(), 0)
            .unwrap()
            .particles
            .column("anisou")
            .is_none()
    );
}
