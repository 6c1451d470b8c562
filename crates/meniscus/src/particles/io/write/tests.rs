use super::*;
use crate::particles::io::read;
use glam::DVec3;

/// Two particles with a column of every kind that the writers treat differently.
fn particles() -> Particles {
    let mut particles = Particles::from_positions(vec![
        DVec3::new(0.5, -1.0, 1e-20),
        DVec3::new(1e6 + 0.125, 0.0, 3.0),
    ]);
    particles.columns = vec![
        Column::new("velocity", 3, vec![1.0_f32, -2.0, 3.0, 0.1, 0.2, 0.3]),
        Column::new("id", 1, vec![7_u32, 9]),
        Column::new("mass", 1, vec![0.1_f64, 1e300]),
    ];
    particles
}

#[test]
fn ply_comes_back_as_it_went() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.PLY");
    let mut written = particles();
    let huge = Column::new("huge", 1, vec![u64::MAX, 1]);
    written.columns.push(huge);
    written
        .columns
        .push(Column::new("big", 1, vec![i64::from(i32::MAX) + 1, 0]));
    assert_eq!(write(&written, &path).unwrap(), ["huge"]);
    let read = read(&path, 0).unwrap();
    assert_eq!(read.particles.positions, written.positions);
    let names: Vec<&str> = read
        .particles
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    assert_eq!(names, ["vx", "vy", "vz", "id", "mass", "big"]);
    assert_eq!(
        read.particles.column("vy").unwrap().data,
        vec![-2.0_f32, 0.2].into()
    );
    assert_eq!(
        read.particles.column("id").unwrap().data,
        vec![7_u32, 9].into()
    );
    assert_eq!(
        read.particles.column("mass").unwrap().data,
        vec![0.1, 1e300].into()
    );
    assert_eq!(
        read.particles.column("big").unwrap().data,
        vec![2_147_483_648.0, 0.0].into()
    );
}

#[test]
fn every_ending_writes_something_and_leaves_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    for ending in WRITTEN_ENDINGS {
        let path = folder.path().join(format!("out.{ending}"));
        assert!(can_write(&path));
        let lost = write(&particles(), &path).unwrap();
        let positions_only = *ending == "npy";
        assert_eq!(
            lost.len(),
            if positions_only { 3 } else { 0 },
            "{ending}: {lost:?}"
        );
        assert!(std::fs::metadata(&path).unwrap().len() > 24, "{ending}");
    }
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, WRITTEN_ENDINGS.len());
}

#[test]
fn failures_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out", "out.obj", "out.ply.tmp"] {
        let error = write(&particles(), &folder.path().join(name)).unwrap_err();
        assert!(matches!(error, WriteError::Ending { .. }), "{error}");
        assert!(error.to_string().contains(".ply"), "{error}");
    }
    let mut ragged = particles();
    ragged.columns.push(Column::new("short", 1, vec![1_u8]));
    let error = write(&ragged, &folder.path().join("out.ply")).unwrap_err();
    assert!(
        error.to_string().contains("short has 1 rows for 2"),
        "{error}"
    );
    let error = write(&particles(), &folder.path().join("none/out.ply")).unwrap_err();
    assert!(matches!(error, WriteError::Io { .. }), "{error}");
    let target = folder.path().join("folder.ply");
    std::fs::create_dir(&target).unwrap();
    assert!(write(&particles(), &target).is_err());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn files_get_the_usual_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ours, usual) = (folder.path().join("ours.ply"), folder.path().join("usual"));
    write(&particles(), &ours).unwrap();
    std::fs::write(&usual, "").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(ours), mode(usual));
}
