//! A film, and the finished pictures that are kept beside it until it is whole.

use super::encoder::Encoder;
use crate::exit::{Failure, Outcome};
use crate::job::output::kept_folder;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// How the unfinished film is called in the folder of kept pictures, around the number of our process:
/// the ffmpeg of a run that was killed may still be writing its own.
const UNFINISHED: [&str; 2] = ["film.", ".part"];
/// How names of kept pictures start, see `plan`.
const KEPT_PREFIXES: [&str; 3] = ["frame_", "turn_", "slow_"];
/// A PNG's signature, then length and name of the first chunk, width and height.
const PNG_HEAD_BYTES: usize = 24;

/// A film in the making.
///
/// Every finished picture is a PNG in the folder `FILM.frames` and goes to ffmpeg, which writes into the
/// same folder. When the last one is encoded the film takes its place in one step and the folder goes
/// away. Whatever happens before leaves the pictures, which `--resume` starts from, and no film.
pub(super) struct Movie {
    film: PathBuf,
    folder: PathBuf,
    unfinished: PathBuf,
    encoder: Encoder,
    pushed: BTreeSet<PathBuf>,
    size: Option<[u32; 2]>,
}

impl Movie {
    /// Starts the film; `resumes` says whether pictures that are there are of use.
    pub(super) fn start(film: &Path, fps: f64, resumes: bool) -> Outcome<Self> {
        let folder = kept_folder(film);
        let failed = |error: std::io::Error| {
            Failure::work(format!("cannot write {}: {error}", folder.display()))
        };
        if !resumes {
            remove(pictures_in(&folder));
        }
        remove(unfinished_in(&folder));
        std::fs::create_dir_all(&folder).map_err(failed)?;
        let unfinished = folder.join(UNFINISHED.join(&std::process::id().to_string()));
        let encoder = Encoder::start(&unfinished, fps).inspect_err(|_| {
            let _ = std::fs::remove_dir(&folder);
        })?;
        Ok(Self {
            film: film.to_owned(),
            folder,
            unfinished,
            encoder,
            pushed: BTreeSet::new(),
            size: None,
        })
    }

    /// Takes the next picture.
    pub(super) fn push(&mut self, picture: &Path) -> Outcome {
        let cannot = |reason: &str| {
            Failure::work(format!("cannot use {}: {reason}", picture.display()))
                .with_help("remove it and run again")
        };
        let png = std::fs::read(picture).map_err(|error| cannot(&error.to_string()))?;
        let size = size_of(&png).ok_or_else(|| cannot("it is no PNG"))?;
        let [width, height] = size;
        if width < 2 || height < 2 {
            return Err(Failure::wrong(format!(
                "a film of {width}x{height} pixels is too small: both sides need 2 or more"
            )));
        }
        let [first_width, first_height] = *self.size.get_or_insert(size);
        if size != [first_width, first_height] {
            return Err(Failure::wrong(format!(
                "{} has {width}x{height} pixels, the pictures of the film before it have \
                 {first_width}x{first_height}",
                picture.display()
            ))
            .with_help("all frames of a film have one size; without --resume all are made anew"));
        }
        self.encoder.push(&png)?;
        self.pushed.insert(picture.to_owned());
        Ok(())
    }

    /// How many pictures it has.
    pub(super) fn frames(&self) -> usize {
        self.pushed.len()
    }

    /// Ends the film and puts it in its place, in spite of Ctrl-C if `is_sure`.
    pub(super) fn finish(&mut self, is_sure: bool) -> Outcome {
        self.encoder.finish(is_sure)?;
        std::fs::rename(&self.unfinished, &self.film).map_err(|error| {
            Failure::work(format!("cannot write {}: {error}", self.film.display()))
        })?;
        remove(std::mem::take(&mut self.pushed));
        Ok(())
    }

    /// The folder of kept pictures and how many it holds, if any.
    pub(super) fn kept(&self) -> Option<(&Path, usize)> {
        let count = pictures_in(&self.folder).len();
        (count > 0).then_some((&*self.folder, count))
    }
}

impl Drop for Movie {
    fn drop(&mut self) {
        self.encoder.stop();
        remove(unfinished_in(&self.folder));
        // Stays where it holds pictures.
        let _ = std::fs::remove_dir(&self.folder);
    }
}

/// The pictures that we keep in a folder, of this film or an earlier one under the same name.
fn pictures_in(folder: &Path) -> Vec<PathBuf> {
    files_in(folder, |name| {
        name.ends_with(".png") && KEPT_PREFIXES.iter().any(|prefix| name.starts_with(prefix))
    })
}

fn unfinished_in(folder: &Path) -> Vec<PathBuf> {
    let [prefix, ending] = UNFINISHED;
    files_in(folder, |name| {
        name.starts_with(prefix) && name.ends_with(ending)
    })
}

fn files_in(folder: &Path, is_wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let entries = entries.filter_map(Result::ok);
    let wanted = entries.filter(|entry| is_wanted(&entry.file_name().to_string_lossy()));
    wanted.map(|entry| entry.path()).collect()
}

/// What cannot be removed is in nobody's way.
fn remove(files: impl IntoIterator<Item = PathBuf>) {
    for file in files {
        let _ = std::fs::remove_file(file);
    }
}

/// Width and height of a PNG.
fn size_of(png: &[u8]) -> Option<[u32; 2]> {
    let head: &[u8; PNG_HEAD_BYTES] = png.first_chunk()?;
    let number =
        |at: usize| u32::from_be_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    (head.starts_with(b"\x89PNG\r\n\x1a\n") && &head[12..16] == b"IHDR")
        .then(|| [number(16), number(20)])
}
