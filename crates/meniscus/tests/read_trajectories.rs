//! Real trajectories, against the same molecules in other formats.

use meniscus::particles::io;
use meniscus::particles::trajectory::{Trajectory, TrajectoryFormat};
use meniscus_testing::data;

#[test]
fn the_same_run_in_three_formats_and_as_models() {
    let Some(folder) = data::file("molecules/biotite") else {
        return;
    };
    let pdb = folder.join("1l2y.pdb");
    let models: Vec<_> = (0..38)
        .map(|model| io::read(&pdb, model).unwrap())
        .collect();
    assert_eq!(models[0].frames, 38);
    for (ending, format, tolerance) in [
        ("xtc", TrajectoryFormat::Xtc, 0.006),
        ("trr", TrajectoryFormat::Trr, 1e-4),
        ("dcd", TrajectoryFormat::Dcd, 1e-4),
    ] {
        let trajectory = Trajectory::open(&folder.join(format!("1l2y.{ending}"))).unwrap();
        assert_eq!(trajectory.format(), format);
        assert_eq!((trajectory.atoms(), trajectory.len()), (304, 38));
        for (frame, model) in models.iter().enumerate() {
            let (particles, _) = trajectory.over(model, frame).unwrap();
            let pairs = particles.positions.iter().zip(&model.particles.positions);
            let off = pairs
                .map(|(a, b)| (*a - *b).abs().max_element())
                .fold(0.0, f64::max);
            assert!(off <= tolerance, "{ending} frame {frame}: {off}");
            assert_eq!(particles.columns, model.particles.columns);
        }
        // In nanometres over a GRO file.
        let gro = io::read(&folder.join("1l2y.gro"), 0).unwrap();
        let (particles, _) = trajectory.over(&gro, 0).unwrap();
        let off = (particles.positions[7] - gro.particles.positions[7]).length();
        assert!(off < 0.001, "{ending}: {off} nm");
    }
}

#[test]
fn a_long_run_of_water() {
    let (Some(dcd), Some(xyz)) = (
        data::file("molecules/chemfiles/water.dcd"),
        data::file("molecules/chemfiles/water.xyz"),
    ) else {
        return;
    };
    let trajectory = Trajectory::open(&dcd).unwrap();
    assert_eq!((trajectory.atoms(), trajectory.len()), (297, 100));
    for frame in [0, 41, 99] {
        let text = io::read(&xyz, frame).unwrap();
        let read = trajectory.read(frame).unwrap();
        for (a, b) in read.positions.iter().zip(&text.particles.positions) {
            assert!((*a - *b).length() < 1e-3, "frame {frame}: {a} {b}");
        }
    }
}

#[test]
fn unusual_files() {
    let Some(folder) = data::file("tricky/chemfiles") else {
        return;
    };
    // Ranges beyond 24 bits, which are packed axis by axis.
    let large = Trajectory::open(&folder.join("large_diff.xtc")).unwrap();
    let frames: Vec<_> = (0..large.len())
        .map(|frame| large.read(frame).unwrap())
        .collect();
    assert_eq!(large.atoms(), 10);
    assert!(large.warnings().is_empty());
    for frame in &frames {
        assert!(frame.positions.iter().all(|p| p.is_finite()));
    }
    // The other byte order, lengths of 64 bits.
    let wide = Trajectory::open(&folder.join("mrmd_h2so4-64bit-be.dcd")).unwrap();
    assert!(wide.warnings().is_empty(), "{:?}", wide.warnings());
    for frame in 0..wide.len() {
        let read = wide.read(frame).unwrap();
        let largest = read
            .positions
            .iter()
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        assert!((0.1..1e3).contains(&largest), "frame {frame}: {largest}");
    }
}
