//! Damaged files of every format that we write: cut anywhere, bytes changed. Readers may refuse them
//! or read what is left, but never panic, and what they give is whole.

use meniscus::particles::io::{WRITTEN_ENDINGS, parse, write};
use meniscus::particles::{Column, Particles};

fn sample() -> Particles {
    let positions = (0..5).map(|i| {
        let x = f64::from(i);
        [x, 0.5 * x, -0.25].into()
    });
    let mut particles = Particles::from_positions(positions.collect());
    particles.columns = vec![
        Column::new("velocity", 3, vec![0.5_f32; 15]),
        Column::new("id", 1, vec![1_i32, 2, 3, 4, 5]),
        Column::new("mass", 1, vec![0.1_f64, 0.2, 0.3, 0.4, 0.5]),
    ];
    particles
}

fn sample_files() -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let mut files: Vec<(String, Vec<u8>)> = WRITTEN_ENDINGS
        .iter()
        .map(|ending| {
            let path = folder.path().join(format!("sample.{ending}"));
            write(&sample(), &path).unwrap();
            ((*ending).to_owned(), std::fs::read(path).unwrap())
        })
        .collect();
    for (name, text) in [
        (
            "ascii ply",
            "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int v\nelement vertex 2\n\
            property float x\nproperty float y\nproperty double z\nproperty list uint8 int l\nend_header\n\
            3 0 1 2\n0 1 2 1 7\n3 4 5 0\n",
        ),
        (
            "geo",
            "PGEOMETRY V5\nNPoints 1 NPrims 0\nNPointGroups 0 NPrimGroups 0\nNPointAttrib 1 NVertexAttrib 0 \
            NPrimAttrib 0 NAttrib 0\nPointAttrib\nid 1 int 0\n0 1 2 1 (7)\n",
        ),
        (
            "frames",
            "1\na\nHe 0 1 2\n1\nProperties=species:S:1:pos:R:3:m:I:2 Lattice=\"1 0 0\"\nH 3 4 5 6 7\n",
        ),
        (
            "pdb",
            "MODEL 1\nATOM      1  CA AALA A   1      -8.901   4.127  -0.555  0.40  5.50           C\n\
            ATOM  A0000  CA BALA A   1      -8.608   3.135  -1.618  0.60  6.00      PROA\nENDMDL\n\
            MODEL 2\nHETATM    1 ZN    ZN B 101A      1.000   2.000   3.000  1.00  9.00          ZN2+\n",
        ),
        (
            "mmcif",
            "data_T\nloop_\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n\
            _atom_site.label_atom_id\n1 2 3(1) CA\n4 5 ? \"C'\"\n_a\n;text\n;\n",
        ),
        (
            "gro",
            "t= 0\n 1\n    1SOL     OW    1   0.230   0.628   0.113  0.1000 -0.2000  0.3000\n 1 1 1\n",
        ),
        ("rows", "# rho x y z\n1 2 3 4\n5 6 7 8.5\n"),
    ] {
        files.push((name.to_owned(), text.as_bytes().to_vec()));
    }
    files
}

fn check(bytes: &[u8], frame: usize) {
    if let Ok((_, parsed)) = parse(bytes, frame) {
        let particles = parsed.particles;
        assert_eq!(particles.rows.len(), particles.len());
        for column in &particles.columns {
            assert!(column.components > 0);
            assert_eq!(column.data.len(), column.components * particles.len());
        }
    }
}

#[test]
fn whole_samples_are_read() {
    for (name, bytes) in sample_files() {
        let (_, parsed) = parse(&bytes, 0).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(!parsed.particles.is_empty(), "{name}");
    }
}

#[test]
fn files_cut_anywhere_do_not_panic() {
    for (_, bytes) in sample_files() {
        for length in 0..bytes.len() {
            check(&bytes[..length], length % 2);
        }
    }
}

#[test]
fn changed_bytes_do_not_panic() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 33) as usize % below
    };
    let odd = [
        0_u8, 1, 0x7f, 0x80, 0xff, b'0', b'9', b'-', b' ', b'\n', b'e', b'"', b'(',
    ];
    for (_, bytes) in sample_files() {
        for _ in 0..1500 {
            let mut damaged = bytes.clone();
            for _ in 0..=random(4) {
                let at = random(damaged.len());
                match random(4) {
                    0 => damaged[at] ^= 1 << random(8),
                    1 => damaged.insert(at, odd[random(odd.len())]),
                    2 => damaged.truncate(at.max(1)),
                    _ => damaged[at] = odd[random(odd.len())],
                }
            }
            check(&damaged, random(2));
        }
    }
}
