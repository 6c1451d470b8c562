//! Writing particle files: the format follows the ending, the file appears complete or not at all.
//!
//! To add a format: one file `NAME_write.rs` with
//! `fn write(particles, out) -> std::io::Result<Vec<String>>` (the columns it could not store), its
//! `mod` line in `io`, and one line in the table below.

use super::{bgeo_write, csv_write, npy_write, ply_write, vtk_write, xyz_write};
use crate::particles::{Column, Particles};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

/// A particle file that could not be written. Nothing is left at its path.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The ending names no format that we write.
    #[error(
        "cannot write {path}: its ending names no particle format; written are {}",
        endings()
    )]
    Ending {
        /// The file.
        path: PathBuf,
    },
    /// A column has not one row per particle.
    #[error("cannot write {path}: column {column} has {rows} rows for {particles} particles")]
    Ragged {
        /// The file.
        path: PathBuf,
        /// The column's name.
        column: String,
        /// Its rows.
        rows: usize,
        /// Number of particles.
        particles: usize,
    },
    /// The system refuses, or the format cannot hold the data.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
}

macro_rules! writers {
    ($($ending:literal $function:path;)*) => {
        /// Endings that [`write()`] knows.
        pub const WRITTEN_ENDINGS: &[&str] = &[$($ending),*];

        fn write_as<W: Write + Seek>(
            ending: &str,
            particles: &Particles,
            out: &mut W,
        ) -> Option<std::io::Result<Vec<String>>> {
            match ending {
                $($ending => Some($function(particles, out)),)*
                _ => None,
            }
        }
    };
}
writers! {
    "vtk" vtk_write::write;
    "ply" ply_write::write;
    "bgeo" bgeo_write::write;
    "xyz" xyz_write::write;
    "csv" csv_write::write;
    "npy" npy_write::write_npy;
    "npz" npy_write::write_npz;
}

fn endings() -> String {
    let dotted: Vec<String> = WRITTEN_ENDINGS
        .iter()
        .map(|ending| format!(".{ending}"))
        .collect();
    dotted.join(", ")
}

/// Whether [`write()`] knows the ending of `path`.
pub fn can_write(path: &Path) -> bool {
    ending(path).is_some_and(|ending| WRITTEN_ENDINGS.contains(&ending.as_str()))
}

fn ending(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Writes particles in the format that the ending of `path` names, aside first and then renamed.
/// Returns the names of the columns that the format could not store (`.npy` has positions only).
///
/// Positions are stored as f32 where that loses nothing or the format has nothing else, else as f64.
///
/// # Errors
/// When the ending is unknown or the file cannot be written; then nothing is left behind.
pub fn write(particles: &Particles, path: &Path) -> Result<Vec<String>, WriteError> {
    let ending = ending(path).filter(|ending| WRITTEN_ENDINGS.contains(&ending.as_str()));
    let Some(ending) = ending else {
        return Err(WriteError::Ending {
            path: path.to_owned(),
        });
    };
    let ragged = |column: &&Column| {
        column.components == 0 || column.data.len() != column.components * particles.len()
    };
    if let Some(column) = particles.columns.iter().find(ragged) {
        return Err(WriteError::Ragged {
            path: path.to_owned(),
            column: column.name.clone(),
            rows: column.data.len() / column.components.max(1),
            particles: particles.len(),
        });
    }
    write_aside(path, |out| {
        write_as(&ending, particles, out).unwrap_or_else(|| Ok(Vec::new()))
    })
    .map_err(|source| WriteError::Io {
        path: path.to_owned(),
        source,
    })
}

/// Fills a temporary file beside `path` and renames it when it is complete.
fn write_aside<T>(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> std::io::Result<T>,
) -> std::io::Result<T> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".meniscus-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The usual permissions of a new file; the process's umask still applies.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder)?;
    let mut out = BufWriter::with_capacity(1 << 20, file.as_file_mut());
    let value = fill(&mut out)?;
    out.flush()?;
    drop(out);
    file.persist(path).map_err(|error| error.error)?;
    Ok(value)
}

/// Whether every coordinate survives a trip through f32.
pub(super) fn fit_f32(particles: &Particles) -> bool {
    particles.positions.iter().all(|position| {
        position
            .to_array()
            .iter()
            .all(|&x| x.is_nan() || f64::from(x as f32) == x)
    })
}

/// Names of the components of a column, for formats that only have scalars.
pub(super) fn scalar_names(column: &Column) -> Vec<String> {
    let stems: [&str; 3] = match (column.components, column.name.as_str()) {
        (1, name) => return vec![name.to_owned()],
        (3, "velocity") => ["vx", "vy", "vz"],
        (3, "acceleration") => ["ax", "ay", "az"],
        (3, "normal" | "normals" | "Normals") => ["nx", "ny", "nz"],
        (3, name) => {
            return ["x", "y", "z"]
                .map(|axis| format!("{name}_{axis}"))
                .to_vec();
        }
        (components, name) => return (0..components).map(|i| format!("{name}_{i}")).collect(),
    };
    stems.map(str::to_owned).to_vec()
}

#[cfg(test)]
mod tests;
