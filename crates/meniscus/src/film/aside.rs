//! Writing files so that nobody ever sees half of one.

use super::FilmError;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes a file beside `path` in the same folder, then renames it to `path`: the target is either
/// as it was before or complete.
///
/// # Errors
/// [`FilmError::Write`] with the path when the folder is missing or not writable, or when `content`
/// fails; nothing is left behind then.
pub fn write_aside<F>(path: &Path, content: F) -> Result<(), FilmError>
where
    F: FnOnce(&mut BufWriter<File>) -> Result<(), FilmError>,
{
    let failed = |source: io::Error| FilmError::Write {
        path: path.to_owned(),
        source,
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if path.is_dir() {
        return Err(failed(io::Error::new(
            io::ErrorKind::IsADirectory,
            "it is a folder",
        )));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".meniscus-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The default of a temporary file, 0600, would hide the picture from everybody else.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let aside = builder.tempfile_in(folder).map_err(|error| {
        // tempfile reports the temporary name, which means nothing to the reader.
        failed(io::Error::from(error.kind()))
    })?;
    let (file, aside_path) = aside.into_parts();
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    content(&mut writer)?;
    writer.flush().map_err(failed)?;
    drop(writer);
    aside_path
        .persist(path)
        .map_err(|error| failed(error.error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        std::fs::write(&path, b"old").unwrap();
        let error = write_aside(&path, |writer| {
            writer.write_all(b"half").unwrap();
            Err(FilmError::Encode {
                path: path.clone(),
                message: "no".into(),
            })
        });
        assert!(error.is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        write_aside(&path, |writer| {
            writer.write_all(b"new").map_err(|source| FilmError::Write {
                path: path.clone(),
                source,
            })
        })
        .unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn an_unwritable_target_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for path in [
            folder.path().join("missing").join("picture.png"),
            folder.path().to_owned(),
        ] {
            let message = write_aside(&path, |_| Ok(())).unwrap_err().to_string();
            assert!(message.contains(&path.display().to_string()), "{message}");
        }
    }
}
