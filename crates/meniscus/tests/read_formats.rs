//! Real particle files other than VTK, held against figures from PyPI `plyfile` and `numpy`.

use meniscus::particles::io::{Format, ReadError, WRITTEN_ENDINGS, read, write};
use meniscus::particles::{Column, Particles};
use meniscus_testing::data;
use std::fs;
use std::path::{Path, PathBuf};

/// What a file holds: a line `path format count columns`, then lines `first x y z`, `sum x y z` and
/// `column name type components sum`.
struct Expected {
    path: &'static str,
    format: &'static str,
    count: usize,
    column_count: usize,
    first: Vec<f64>,
    sum: Vec<f64>,
    columns: Vec<(&'static str, &'static str, usize, f64)>,
}

fn expected_files() -> Vec<Expected> {
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mut files: Vec<Expected> = Vec::new();
    for line in include_str!("read_formats/expected.txt").lines() {
        let words: Vec<&'static str> = line.split_whitespace().collect();
        match (words[..].first(), files.last_mut()) {
            (Some(&"first"), Some(file)) if line.starts_with(' ') => {
                file.first = words[1..].iter().map(|word| number(word)).collect();
            }
            (Some(&"sum"), Some(file)) if line.starts_with(' ') => {
                file.sum = words[1..].iter().map(|word| number(word)).collect();
            }
            (Some(&"column"), Some(file)) if line.starts_with(' ') => {
                let components = words[3].parse().unwrap();
                file.columns
                    .push((words[1], words[2], components, number(words[4])));
            }
            _ => files.push(Expected {
                path: words[0],
                format: words[1],
                count: words[2].parse().unwrap(),
                column_count: words[3].parse().unwrap(),
                first: Vec::new(),
                sum: Vec::new(),
                columns: Vec::new(),
            }),
        }
    }
    files
}

/// Whether two sums agree but for the order of addition.
fn close(a: f64, b: f64, magnitude: f64) -> bool {
    (a - b).abs() <= 1e-9 * magnitude.max(1.0)
}

#[test]
fn real_files_read_as_other_programs_read_them() {
    let files = expected_files();
    assert!(files.len() >= 33, "{} files expected", files.len());
    for expected in files {
        let Some(path) = data::file(expected.path) else {
            continue;
        };
        let file = read(&path, 0).unwrap_or_else(|error| panic!("{error}"));
        let (name, particles) = (expected.path, &file.particles);
        assert_eq!(file.format.name(), expected.format, "{name}");
        assert_eq!(particles.len(), expected.count, "{name}");
        assert_eq!(particles.columns.len(), expected.column_count, "{name}");
        for axis in 0..3 {
            let coordinates = particles.positions.iter().map(|position| position[axis]);
            let magnitude: f64 = coordinates.clone().map(f64::abs).sum();
            let sum: f64 = coordinates.sum();
            assert!(
                close(sum, expected.sum[axis], magnitude),
                "{name}: sum {axis} is {sum}"
            );
            if let Some(first) = particles.positions.first() {
                assert_eq!(first[axis], expected.first[axis], "{name}");
            }
        }
        for (column, kind, components, expected_sum) in expected.columns {
            let found = particles
                .column(column)
                .unwrap_or_else(|| panic!("{name} has no column {column}"));
            assert_eq!(
                (found.data.type_name(), found.components),
                (kind, components),
                "{name}: {column}"
            );
            let values = (0..found.data.len()).map(|i| found.data.get(i));
            let magnitude: f64 = values.clone().map(f64::abs).sum();
            let sum: f64 = values.sum();
            assert!(
                close(sum, expected_sum, magnitude),
                "{name}: sum of {column} is {sum}"
            );
        }
    }
}

#[test]
fn files_with_several_frames_give_each_of_them() {
    for (path, frames, last_first) in [
        (
            "molecules/chemfiles/water.xyz",
            100,
            [0.318559, 8.776042, 11.892704],
        ),
        (
            "tricky/chemfiles/helium.xyz.but.not.really",
            397,
            [-1.186037, 11.439334, 0.529939],
        ),
    ] {
        let Some(path) = data::file(path) else {
            continue;
        };
        let last = read(&path, frames - 1).unwrap();
        assert_eq!(last.frames, frames);
        assert_eq!(last.particles.positions[0].to_array(), last_first);
        let error = read(&path, frames).unwrap_err().to_string();
        assert!(
            error.contains(&format!("holds {frames} frame(s)")),
            "{error}"
        );
    }
}

#[test]
fn damaged_and_foreign_files_say_what_is_wrong() {
    for (path, words) in [
        ("tricky/assimp/pond.0.ply", &["promises 70051", "70048"][..]),
        ("tricky/assimp/invalid/empty.ply", &["empty"]),
        (
            "tricky/assimp/invalid/OutOfMemory.off",
            &["OFF", "read are ply"],
        ),
        ("tricky/assimp/invalid/malformed.obj", &["OBJ", "PLY"]),
        (
            "tricky/pdal/sized_dims.ply",
            &["no property z", "x, y, j, i"],
        ),
        ("tricky/ply-rs/header_min_ok_ascii.ply", &["no element"]),
        ("tricky/ply-rs/single_elements_ok_ascii.ply", &["point"]),
        (
            "tricky/splashsurf/density_grid_loop_subdomain_33.json",
            &["JSON"],
        ),
        ("tricky/chemfiles/large_diff.xtc", &["XTC", "topology.pdb"]),
        (
            "tricky/chemfiles/mrmd_h2so4-64bit-be.dcd",
            &["DCD", "topology.pdb"],
        ),
        (
            "tricky/chemfiles/truncated.gro",
            &["gro line 558", "after 555 of the 1405 atoms"],
        ),
        ("molecules/biotite/1l2y.trr", &["TRR", "topology.pdb"]),
        ("skeletons/neurom/Neuron.swc", &["SWC", "not supported yet"]),
        ("fluid/parsec/in_5K.fluid", &["PARSEC", "PLY"]),
        ("motion/bevy/Fox.glb", &["glTF"]),
        ("motion/bevy/SimpleSkin.gltf", &["JSON"]),
        ("surfaces/common-3d-test-models/spot.obj", &["OBJ"]),
    ] {
        let Some(path) = data::file(path) else {
            continue;
        };
        let error = read(&path, 0).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "{error}");
        }
    }
}

fn files_below(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, files);
        } else {
            files.push(path);
        }
    }
}

/// Every file of the data, particles or not, is read or refused in words.
#[test]
fn every_tricky_file_reads_or_is_refused_in_words() {
    let Some(folder) = data::file("tricky") else {
        return;
    };
    let mut files = Vec::new();
    files_below(&folder, &mut files);
    assert!(files.len() > 60, "{} files", files.len());
    let mut read_well = 0;
    for path in files {
        match read(&path, 0) {
            Ok(file) => {
                read_well += 1;
                let particles = &file.particles;
                assert_eq!(particles.rows.len(), particles.len());
                for column in &particles.columns {
                    assert_eq!(
                        column.data.len(),
                        column.components * particles.len(),
                        "{}",
                        column.name
                    );
                }
            }
            Err(error) => {
                let message = error.to_string();
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                assert!(message.contains(&name), "{message}");
                let says_enough = match &error {
                    ReadError::Unknown { problem, .. } => problem.len() > 10,
                    ReadError::Malformed { format, error, .. } => {
                        !format.is_empty() && error.problem.len() > 10
                    }
                    ReadError::Io { .. } => false,
                };
                assert!(says_enough, "{message}");
            }
        }
    }
    assert!(read_well >= 55, "only {read_well} files were read");
    if let Some(peak) = peak_memory() {
        assert!(peak < 1 << 30, "peak memory {peak} bytes");
    }
}

/// Largest resident memory of this process so far, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

#[test]
fn what_is_written_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut particles = Particles::from_positions(vec![
        [0.1, -2.0, 3e7].into(),
        [1.0 / 3.0, 5.0, -1e-30].into(),
    ]);
    particles.columns = vec![
        Column::new("velocity", 3, vec![1.5_f32, -2.0, 3.0, 0.1, 0.2, 0.3]),
        Column::new("id", 1, vec![7_i32, 9]),
        Column::new("atomic_number", 1, vec![8_u8, 1]),
    ];
    for ending in WRITTEN_ENDINGS {
        let path = folder.path().join(format!("out.{ending}"));
        let lost = write(&particles, &path).unwrap();
        let file = read(&path, 0).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(file.warnings, [""; 0], "{ending}");
        let single = *ending == "bgeo";
        for (found, expected) in file.particles.positions.iter().zip(&particles.positions) {
            let expected = if single {
                expected.as_vec3().as_dvec3()
            } else {
                *expected
            };
            assert_eq!(*found, expected, "{ending}");
        }
        assert_eq!(file.particles.len(), 2, "{ending}");
        let missing = |name: &str| lost.iter().any(|lost| lost == name);
        for name in ["id", "atomic_number"] {
            let expected = particles.column(name).unwrap();
            match file.particles.column(name) {
                Some(found) => {
                    assert_eq!(
                        (found.get(0, 0), found.get(1, 0)),
                        (expected.get(0, 0), expected.get(1, 0)),
                        "{ending}"
                    );
                }
                None => assert!(missing(name), "{ending} lost {name}"),
            }
        }
        let whole = file
            .particles
            .column("velocity")
            .map(|velocity| velocity.get(1, 2));
        let split = file.particles.column("vz").map(|vz| vz.get(1, 0));
        match whole.or(split) {
            Some(vz) => assert_eq!(vz as f32, 0.3, "{ending}"),
            None => assert!(missing("velocity"), "{ending} lost velocity"),
        }
    }
}

#[test]
fn gzip_around_any_format_is_transparent() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points");
    let mut file = flate2::write::GzEncoder::new(
        fs::File::create(&path).unwrap(),
        flate2::Compression::fast(),
    );
    file.write_all(b"x,y,z\n1,2,3\n").unwrap();
    file.finish().unwrap();
    let file = read(&path, 0).unwrap();
    assert_eq!(file.format, Format::Csv);
    assert_eq!(file.particles.positions[0].to_array(), [1.0, 2.0, 3.0]);
}
