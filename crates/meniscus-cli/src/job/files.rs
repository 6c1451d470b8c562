//! Files that a command is about to write.

use crate::exit::{Failure, Outcome};
use std::io::Write;
use std::path::Path;

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Whether a file can be made at `path`, found out before the long work: its folder must exist and
/// take a file.
pub(crate) fn check_writable(path: &Path) -> Outcome {
    let folder = folder_of(path);
    let failed =
        |reason: String| Failure::work(format!("cannot write {}: {reason}", path.display()));
    if path.is_dir() {
        return Err(failed("it is a folder".to_owned()).with_help("add a file name"));
    }
    if !folder.is_dir() {
        return Err(failed(format!("there is no folder {}", folder.display()))
            .with_help(format!("make it first: mkdir -p {}", folder.display())));
    }
    tempfile::Builder::new()
        .prefix(".meniscus-")
        .suffix(".part")
        .tempfile_in(folder)
        .map(drop)
        .map_err(|error| failed(std::io::Error::from(error.kind()).to_string()))
}

/// Writes a file aside and renames it.
pub(crate) fn write_whole(path: &Path, content: &[u8]) -> Outcome {
    meniscus::film::write_aside(path, |out| {
        out.write_all(content)
            .map_err(|source| meniscus::film::FilmError::Write {
                path: path.to_owned(),
                source,
            })
    })
    .map_err(|error| Failure::work(error.to_string()))
}
