//! Where pictures go.

use crate::exit::{Failure, Outcome};
use meniscus::particles::sequence;
use std::path::{Path, PathBuf};

/// What the ending of the output asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// PNG: as a screen shows it.
    Png,
    /// OpenEXR: linear, with channels.
    Exr,
    /// A film, made of PNGs.
    Mp4,
}

impl PictureFormat {
    /// The format that the ending of `path` names.
    pub(crate) fn of(path: &Path) -> Outcome<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("mp4") => Ok(Self::Mp4),
            Some("mov" | "mkv" | "webm" | "avi" | "gif") => Err(Failure::wrong(format!(
                "{}: films are written as .mp4",
                path.display()
            ))
            .with_help("write .mp4, or one picture per frame: .png or .exr")),
            _ => Err(Failure::wrong(format!(
                "{}: the ending names no kind of picture",
                path.display()
            ))
            .with_help("write .png or .exr, or .mp4 for a film")),
        }
    }
}

/// Where the pictures of a run go.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// One file.
    Picture(PathBuf),
    /// A pattern whose {} takes a picture's number.
    Pattern(PathBuf),
    /// A film.
    Film(PathBuf),
}

impl Target {
    /// What `output` means.
    pub(crate) fn new(output: &Path, format: PictureFormat) -> Outcome<Self> {
        let output = output.to_owned();
        let is_pattern = sequence::is_pattern(&output);
        match format {
            PictureFormat::Mp4 if is_pattern => Err(Failure::wrong(format!(
                "{}: all frames go into one film, so its name has no {{}}",
                output.display()
            ))),
            PictureFormat::Mp4 => Ok(Self::Film(output)),
            PictureFormat::Png | PictureFormat::Exr if is_pattern => {
                check_pattern(&output)?;
                Ok(Self::Pattern(output))
            }
            PictureFormat::Png | PictureFormat::Exr => Ok(Self::Picture(output)),
        }
    }

    /// Whether there is room for more than one picture.
    pub(crate) fn takes_several(&self) -> bool {
        !matches!(self, Self::Picture(_))
    }

    /// The file of the picture with this number. `kept_name` tells it from all pictures that the same
    /// film could have been made of under other options.
    pub(crate) fn path(&self, number: &str, kept_name: &str) -> PathBuf {
        match self {
            Self::Picture(path) => path.clone(),
            Self::Pattern(pattern) => sequence::output_path(pattern, number),
            Self::Film(film) => kept_folder(film).join(format!("{kept_name}.png")),
        }
    }
}

/// The folder beside a film that keeps its finished pictures until the film is whole.
pub(crate) fn kept_folder(film: &Path) -> PathBuf {
    let mut name = film.file_name().unwrap_or_default().to_owned();
    name.push(".frames");
    film.with_file_name(name)
}

fn check_pattern(output: &Path) -> Outcome {
    let placeholders = output
        .to_string_lossy()
        .matches(sequence::PLACEHOLDER)
        .count();
    if placeholders == 1 {
        return Ok(());
    }
    Err(Failure::wrong(format!(
        "{}: a pattern has one {{}}, this has {placeholders}",
        output.display()
    )))
}

/// A pattern without its placeholder, for what belongs to the whole sequence: `frame.png` for
/// `frame_{}.png`.
pub(crate) fn without_number(pattern: &Path) -> PathBuf {
    let stem = pattern.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.replace(sequence::PLACEHOLDER, "");
    let stem = stem.trim_end_matches(['_', '-', '.', ' ']);
    let stem = if stem.is_empty() { "frames" } else { stem };
    let ending = pattern.extension().unwrap_or_default().to_string_lossy();
    pattern.with_file_name(format!("{stem}.{ending}"))
}
