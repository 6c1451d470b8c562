//! What every reader must hold, whatever the bytes.

use meniscus::frame::MeshSurface;
use meniscus::mesh::{self, MeshFormat};
use meniscus::particles::io::{Format, Parsed, parse};
use meniscus::particles::trajectory::{Trajectory, TrajectoryFormat};
use std::io::Write;
use std::path::Path;

/// Reads the first two frames as one of `formats`, which the first byte chooses.
pub fn read_as(formats: &[Format], bytes: &[u8]) {
    let Some((&choice, bytes)) = bytes.split_first() else {
        return;
    };
    let format = formats[usize::from(choice) % formats.len()];
    for frame in 0..2 {
        if let Ok(parsed) = format.parse(bytes, frame) {
            check(&parsed);
        }
    }
}

/// Reads as files are read: gzip unfolded, the format told by content.
pub fn read_any(bytes: &[u8]) {
    if let Ok((_, parsed)) = parse(bytes, 0) {
        check(&parsed);
    }
}

fn check(parsed: &Parsed) {
    let particles = &parsed.particles;
    assert_eq!(particles.rows.len(), particles.len());
    for column in &particles.columns {
        assert!(column.components > 0, "{}", column.name);
        assert_eq!(
            column.data.len(),
            column.components * particles.len(),
            "{}",
            column.name
        );
    }
}

/// Gives the bytes to a reader of files, as a file that goes away again.
pub fn as_file(bytes: &[u8], read: impl FnOnce(&Path)) {
    let mut file = tempfile::NamedTempFile::new().expect("a folder for temporary files");
    file.write_all(bytes).expect("room for a small file");
    read(file.path());
}

/// Reads a mesh file and makes a surface of it, if its content is of that format.
pub fn read_mesh(format: MeshFormat, bytes: &[u8]) {
    if MeshFormat::detect(bytes) != Some(format) {
        return;
    }
    as_file(bytes, |path| match mesh::io::read(path) {
        Ok(file) => {
            let (surface, _) = MeshSurface::build(&file.mesh);
            assert!(!surface.triangles.is_empty());
            let in_range = |&corner: &u32| (corner as usize) < surface.vertices.len();
            assert!(surface.triangles.iter().flatten().all(in_range));
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    });
}

/// Indexes a trajectory and reads its first and its last frame, if its head is one's.
pub fn read_trajectory(bytes: &[u8]) {
    if TrajectoryFormat::detect(&bytes[..bytes.len().min(16)]).is_none() {
        return;
    }
    as_file(bytes, |path| match Trajectory::open(path) {
        Ok(trajectory) => {
            assert!(trajectory.len() > 0);
            for frame in [0, trajectory.len() - 1, trajectory.len()] {
                match trajectory.read(frame) {
                    Ok(moment) => {
                        assert_eq!(moment.positions.len(), trajectory.atoms());
                        let velocities = moment.velocities.iter();
                        assert!(velocities.map(Vec::len).all(|n| n == trajectory.atoms()));
                    }
                    Err(error) => assert!(!error.to_string().is_empty()),
                }
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    });
}
