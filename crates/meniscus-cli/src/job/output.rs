//! Where pictures go.

use crate::exit::{Failure, Outcome};
use crate::job::input::{FrameInput, Inputs, steps_of};
use meniscus::particles::sequence;
use std::path::{Path, PathBuf};

/// A kind of picture file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// PNG: as a screen shows it.
    Png,
    /// OpenEXR: linear, with channels.
    Exr,
}

impl PictureFormat {
    /// The format that the ending of `path` names.
    pub(crate) fn of(path: &Path) -> Outcome<Self> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            Some("mp4" | "mov" | "mkv" | "webm") => Err(Failure::not_yet(
                "video",
                ".png, .exr, one picture per frame",
            )),
            _ => Err(Failure::wrong(format!(
                "{}: the ending names no kind of picture",
                path.display()
            ))
            .with_help("write .png or .exr")),
        }
    }
}

/// The output of every frame; expands a single file of several time steps if the output is a pattern.
pub(crate) fn assign(inputs: Inputs, output: &Path) -> Outcome<Vec<(FrameInput, PathBuf)>> {
    let Inputs {
        mut frames,
        is_sequence,
        ..
    } = inputs;
    if !sequence::is_pattern(output) {
        return match <[FrameInput; 1]>::try_from(frames) {
            Ok([frame]) => Ok(vec![(frame, output.to_owned())]),
            Err(frames) => Err(Failure::wrong(format!(
                "{} frames cannot all be written to {}",
                frames.len(),
                output.display()
            ))
            .with_help("put {} where the frame number goes, as in -o 'frame_{}.png'")),
        };
    }
    check_pattern(output)?;
    if !is_sequence && let [only] = &frames[..] {
        frames = steps_of(only)?;
    }
    Ok(frames
        .into_iter()
        .map(|frame| {
            let path = sequence::output_path(output, &frame.text);
            (frame, path)
        })
        .collect())
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

/// Most pictures of a turntable.
const MAX_TURNS: u32 = 100_000;

/// The outputs of a turntable of `count` pictures, numbered from 0: all of one frame.
pub(crate) fn assign_turns(
    inputs: Inputs,
    output: &Path,
    count: u32,
) -> Outcome<Vec<(FrameInput, PathBuf)>> {
    if count == 0 || count > MAX_TURNS {
        return Err(Failure::wrong(format!(
            "--turntable {count}: between 1 and {MAX_TURNS} pictures are possible"
        )));
    }
    let [frame] = <[FrameInput; 1]>::try_from(inputs.frames).map_err(|frames| {
        Failure::wrong(format!(
            "--turntable turns around one frame, not {}",
            frames.len()
        ))
        .with_help("choose one with --frames")
    })?;
    if !sequence::is_pattern(output) {
        return Err(Failure::wrong(format!(
            "--turntable writes {count} pictures, which cannot all go to {}",
            output.display()
        ))
        .with_help("put {} where the picture's number goes, as in -o 'turn_{}.png'"));
    }
    check_pattern(output)?;
    let width = (count - 1).to_string().len();
    Ok((0..count)
        .map(|turn| {
            let path = sequence::output_path(output, &format!("{turn:0width$}"));
            (frame.clone(), path)
        })
        .collect())
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
