//! What the inputs are: frames of particles, a scene, or several scenes.

use super::scene::scene_failure;
use super::trajectory::{self, Trajectories};
use crate::exit::{Failure, Outcome};
use meniscus::particles::io::{self, Format};
use meniscus::particles::sequence::{self, FrameFile, FrameSelection, SequenceError};
use meniscus::scene::{Scene, Surface, file};
use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes that tell what a file is.
const HEAD_BYTES: u64 = 4096;

/// One picture to be: a scene whose surfaces name existing files.
#[derive(Debug, Clone)]
pub(crate) struct FrameInput {
    /// The scene; its surfaces may still name patterns.
    pub scene: Arc<Scene>,
    /// The particle file of each surface.
    pub files: Vec<PathBuf>,
    /// What moves the particles of the first file, if it is a topology.
    pub trajectory: Option<Arc<Trajectories>>,
    /// Which time step of a file or a trajectory that holds several.
    pub step: usize,
    /// Frame number.
    pub number: u64,
    /// The number as the input writes it.
    pub text: String,
}

/// All frames that the inputs stand for.
#[derive(Debug, Clone)]
pub(crate) struct Inputs {
    /// The frames, in order.
    pub frames: Vec<FrameInput>,
    /// Whether they are frames of a sequence (even if there is one only).
    pub is_sequence: bool,
    /// All frames of the sequence, selected or not, at least one: the first with particles decides what
    /// stays fixed.
    pub all: Vec<FrameInput>,
    /// By how much the frame numbers usually rise, selected or not.
    pub step: u64,
    /// What a user should know, a sentence each.
    pub warnings: Vec<String>,
}

impl Inputs {
    /// The first frame of the whole sequence.
    pub(crate) fn first(&self) -> &FrameInput {
        &self.all[0]
    }
}

/// Finds out what the inputs are. `edit` changes each scene (options, presets) before its files are
/// looked for.
pub(crate) fn resolve(
    inputs: &[PathBuf],
    selection: Option<&FrameSelection>,
    edit: &dyn Fn(&mut Scene) -> Outcome,
) -> Outcome<Inputs> {
    let (trajectories, inputs) = trajectory::split(inputs);
    if !trajectories.is_empty() {
        if inputs.is_empty() {
            return Err(Failure::wrong(format!(
                "{} is a trajectory, which does not say what its atoms are",
                trajectories[0].display()
            ))
            .with_help("put a molecule file before it: topology.pdb trajectory.xtc"));
        }
        let topology = resolve(&inputs, None, edit)?;
        let (frames, warnings) = trajectory::frames(&trajectories, topology)?;
        let mut resolved = selected(selection, frames, true, false)?;
        resolved.warnings.splice(0..0, warnings);
        return Ok(resolved);
    }
    let is_pattern = inputs.iter().any(|input| sequence::is_pattern(input));
    let listed = sequence::expand(&inputs).map_err(sequence_failure)?;
    let scenes: Vec<bool> = listed
        .iter()
        .map(|input| is_scene(&input.path))
        .collect::<Outcome<_>>()?;
    let several = is_pattern || listed.len() > 1;
    if scenes.iter().all(|scene| !scene) {
        return particle_frames(listed, several, is_pattern, selection, edit);
    }
    if !scenes.iter().all(|scene| *scene) {
        return Err(Failure::wrong("the inputs mix scenes and particle files")
            .with_help("give particle files of one sequence, or one scene"));
    }
    if several {
        let mut frames = Vec::new();
        for input in listed {
            let scene = edited_scene(&input.path, edit)?;
            let found = scene_frames(scene, input.number, &input.text)?;
            if found.len() != 1 || found[0].1 {
                return Err(Failure::wrong(format!(
                    "{}: several scenes are frames of one sequence, so none may name a pattern itself",
                    input.path.display()
                )));
            }
            frames.extend(found.into_iter().map(|(frame, _)| frame));
        }
        return selected(selection, frames, true, is_pattern);
    }
    let Some(input) = listed.into_iter().next() else {
        return Err(Failure::wrong("no input"));
    };
    let found = scene_frames(edited_scene(&input.path, edit)?, input.number, &input.text)?;
    let is_sequence = found.iter().any(|(_, from_pattern)| *from_pattern);
    let frames: Vec<FrameInput> = found.into_iter().map(|(frame, _)| frame).collect();
    selected(selection, frames, is_sequence, is_sequence)
}

fn selected(
    selection: Option<&FrameSelection>,
    frames: Vec<FrameInput>,
    is_sequence: bool,
    is_pattern: bool,
) -> Outcome<Inputs> {
    if frames.is_empty() {
        return Err(Failure::wrong("no input"));
    }
    let numbers: Vec<u64> = frames.iter().map(|frame| frame.number).collect();
    let step = sequence::usual_step(&numbers);
    // Whoever lists files by name means these and no others.
    let warnings = if is_pattern {
        missing(&numbers, step, selection).into_iter().collect()
    } else {
        Vec::new()
    };
    Ok(Inputs {
        all: frames.clone(),
        frames: select_frames(selection, frames)?,
        is_sequence,
        step,
        warnings,
    })
}

/// Most numbers of a gap that are held against a selection.
const MOST_COMPARED: usize = 10_000;

/// Most gaps that are named.
const MOST_GAPS: usize = 5;

/// Says which gaps in `numbers` a selection wants filled.
fn missing(numbers: &[u64], step: u64, selection: Option<&FrameSelection>) -> Option<String> {
    let wanted = |gap: &std::ops::RangeInclusive<u64>| match selection {
        None => true,
        Some(selection) => gap
            .clone()
            .step_by(usize::try_from(step).unwrap_or(usize::MAX))
            .take(MOST_COMPARED)
            .any(|number| selection.contains(number)),
    };
    let gaps = sequence::gaps(numbers, step);
    let gaps: Vec<String> = gaps
        .into_iter()
        .filter(wanted)
        .map(|gap| match gap.start() == gap.end() {
            true => format!("frame {}", gap.start()),
            false => format!("frames {} to {}", gap.start(), gap.end()),
        })
        .collect();
    let shown = &gaps[..gaps.len().min(MOST_GAPS)];
    let more = match gaps.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more gaps"),
    };
    (!gaps.is_empty()).then(|| {
        format!(
            "missing in the middle of the sequence: {}{more}; the others are rendered",
            shown.join(", ")
        )
    })
}

fn particle_frames(
    listed: Vec<FrameFile>,
    several: bool,
    is_pattern: bool,
    selection: Option<&FrameSelection>,
    edit: &dyn Fn(&mut Scene) -> Outcome,
) -> Outcome<Inputs> {
    let frames: Vec<FrameInput> = listed
        .into_iter()
        .map(|file| frame_of(file, edit))
        .collect::<Outcome<_>>()?;
    // A selection from a single file selects among its time steps.
    let frames = match (&frames[..], selection) {
        ([only], Some(_)) if !several => steps_of(only)?,
        _ => frames,
    };
    let is_sequence = several || frames.len() > 1;
    selected(selection, frames, is_sequence, is_pattern)
}

/// The frame of a particle file.
pub(super) fn frame_of(
    file: FrameFile,
    edit: &dyn Fn(&mut Scene) -> Outcome,
) -> Outcome<FrameInput> {
    let mut scene = Scene {
        surfaces: vec![Surface::from_file(&file.path)],
        ..Scene::default()
    };
    edit(&mut scene)?;
    Ok(FrameInput {
        files: scene.surfaces.iter().map(|s| s.file.clone()).collect(),
        scene: Arc::new(scene),
        trajectory: None,
        step: 0,
        number: file.number,
        text: file.text,
    })
}

/// The frames of a scene with patterns whose files are there.
pub(super) fn frames_there_of(scene: Scene) -> Outcome<Vec<FrameInput>> {
    let is_there = |surface: &Surface| {
        !sequence::is_pattern(&surface.file)
            || !matches!(
                sequence::matches(&surface.file),
                Err(SequenceError::NoMatch { .. })
            )
    };
    if !scene.surfaces.iter().all(is_there) {
        return Ok(Vec::new());
    }
    let patterns = common_frames(scene, 0, "")?;
    Ok(patterns.into_iter().map(|(frame, _)| frame).collect())
}

/// The time steps that the single file of `frame` holds, numbered from 0; a file of one step keeps
/// the number in its name.
pub(crate) fn steps_of(frame: &FrameInput) -> Outcome<Vec<FrameInput>> {
    let Some(file) = frame.files.first() else {
        return Ok(vec![frame.clone()]);
    };
    let count = io::read(file, 0)
        .map_err(|error| Failure::work(error.to_string()))?
        .frames;
    if count <= 1 {
        return Ok(vec![frame.clone()]);
    }
    let width = (count - 1).to_string().len();
    Ok((0..count)
        .map(|step| FrameInput {
            step,
            number: step as u64,
            text: format!("{step:0width$}"),
            ..frame.clone()
        })
        .collect())
}

pub(super) fn edited_scene(path: &Path, edit: &dyn Fn(&mut Scene) -> Outcome) -> Outcome<Scene> {
    let mut scene = file::load(path).map_err(scene_failure)?;
    edit(&mut scene)?;
    Ok(scene)
}

/// The frames of one scene: one, or as many as its surfaces' patterns have in common. With each,
/// whether it comes from a pattern.
fn scene_frames(scene: Scene, number: u64, text: &str) -> Outcome<Vec<(FrameInput, bool)>> {
    let frames = common_frames(scene, number, text)?;
    if frames.is_empty() {
        return Err(Failure::wrong(
            "the patterns of the scene's surfaces have no frame number in common",
        ));
    }
    Ok(frames)
}

fn common_frames(scene: Scene, number: u64, text: &str) -> Outcome<Vec<(FrameInput, bool)>> {
    let scene = Arc::new(scene);
    let patterns: Vec<(usize, Vec<FrameFile>)> = scene
        .surfaces
        .iter()
        .enumerate()
        .filter(|(_, surface)| sequence::is_pattern(&surface.file))
        .map(|(index, surface)| {
            let found = sequence::matches(&surface.file).map_err(sequence_failure)?;
            Ok((index, found))
        })
        .collect::<Outcome<_>>()?;
    let fixed: Vec<PathBuf> = scene.surfaces.iter().map(|s| s.file.clone()).collect();
    let Some((_, first)) = patterns.first() else {
        let frame = FrameInput {
            scene,
            files: fixed,
            trajectory: None,
            step: 0,
            number,
            text: text.to_owned(),
        };
        return Ok(vec![(frame, false)]);
    };
    let mut common: BTreeSet<u64> = first.iter().map(|file| file.number).collect();
    for (_, found) in &patterns[1..] {
        let numbers: BTreeSet<u64> = found.iter().map(|file| file.number).collect();
        common.retain(|number| numbers.contains(number));
    }
    let frames = first.iter().filter(|file| common.contains(&file.number));
    Ok(frames
        .map(|file| {
            let mut files = fixed.clone();
            for (index, found) in &patterns {
                if let Some(same) = found.iter().find(|other| other.number == file.number) {
                    files[*index] = same.path.clone();
                }
            }
            let frame = FrameInput {
                scene: scene.clone(),
                files,
                trajectory: None,
                step: 0,
                number: file.number,
                text: file.text.clone(),
            };
            (frame, true)
        })
        .collect())
}

fn select(selection: Option<&FrameSelection>, files: Vec<FrameFile>) -> Outcome<Vec<FrameFile>> {
    match selection {
        Some(selection) => selection.select(files).map_err(sequence_failure),
        None => Ok(files),
    }
}

fn select_frames(
    selection: Option<&FrameSelection>,
    frames: Vec<FrameInput>,
) -> Outcome<Vec<FrameInput>> {
    let files = frames
        .iter()
        .map(|frame| FrameFile {
            path: frame.files.first().cloned().unwrap_or_default(),
            number: frame.number,
            text: frame.text.clone(),
        })
        .collect();
    let kept: BTreeSet<(u64, String)> = select(selection, files)?
        .into_iter()
        .map(|file| (file.number, file.text))
        .collect();
    Ok(frames
        .into_iter()
        .filter(|frame| kept.contains(&(frame.number, frame.text.clone())))
        .collect())
}

/// Missing files and folders are work that failed; the rest is a wrong command line.
pub(crate) fn sequence_failure(error: SequenceError) -> Failure {
    match error {
        SequenceError::NoMatch { .. } | SequenceError::Folder { .. } => {
            Failure::work(error.to_string())
        }
        _ => Failure::wrong(error.to_string()),
    }
}

/// Whether a file is a scene, by its content.
pub(super) fn is_scene(path: &Path) -> Outcome<bool> {
    let cannot =
        |error: std::io::Error| Failure::work(format!("cannot read {}: {error}", path.display()));
    if path.is_dir() {
        return Err(Failure::work(format!("{} is a folder", path.display()))
            .with_help("name a file in it, or a pattern such as 'folder/frame_{}.vtk'"));
    }
    let mut head = Vec::new();
    std::fs::File::open(path)
        .map_err(cannot)?
        .take(HEAD_BYTES)
        .read_to_end(&mut head)
        .map_err(cannot)?;
    // A title of GRO may look like an assignment: `t= 0.0`.
    if looks_like_scene(&head) && Format::detect(&head) != Some(Format::Gro) {
        return Ok(true);
    }
    let ending = path.extension().and_then(|ending| ending.to_str());
    let named_scene = ending.is_some_and(|e| matches!(&*e.to_ascii_lowercase(), "toml" | "json"));
    Ok(named_scene && Format::detect(&head).is_none())
}

/// Whether the start of a file is that of TOML or JSON as scenes use it: an object, a table header or
/// an assignment, after comments.
fn looks_like_scene(head: &[u8]) -> bool {
    let valid = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => {
            std::str::from_utf8(&head[..error.valid_up_to()]).unwrap_or("")
        }
        Err(_) => return false,
    };
    let text = valid.trim_start_matches('\u{feff}');
    if text.starts_with("# vtk") {
        return false;
    }
    let mut lines = text.lines().map(str::trim);
    let Some(line) = lines.find(|line| !line.is_empty() && !line.starts_with('#')) else {
        return false;
    };
    if line.starts_with('{') {
        return true;
    }
    let is_key = |key: &str| {
        !key.is_empty()
            && key.starts_with(|c: char| c.is_ascii_alphabetic())
            && key
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "_-.\"' ".contains(c))
    };
    let table = line
        .strip_prefix('[')
        .map(|rest| rest.trim_start_matches('[').split(']').next().unwrap_or(""));
    match table {
        Some(key) => is_key(key.trim()),
        None => line
            .split_once('=')
            .is_some_and(|(key, _)| is_key(key.trim()) && !key.trim().contains(' ')),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_told_from_particles_by_their_start() {
        for scene in [
            "[camera]\nfov = 30",
            "# a scene\n\n[[surface]]\nfile = 'a'",
            "{ \"surface\": [] }",
            "\u{feff}film.width = 3",
            "  [material.clay]",
        ] {
            assert!(looks_like_scene(scene.as_bytes()), "{scene}");
        }
        for particles in [
            "# vtk DataFile Version 3.0\ntitle = x\nASCII",
            "ply\nformat ascii 1.0",
            "x,y,z\n1,2,3",
            "3\nLattice=\"1 0 0\" Properties=species:S:1",
            "[\"fileversion\",\"18\"]",
            "[1,2,3]",
            "",
            "1 2 3\n4 5 6",
        ] {
            assert!(!looks_like_scene(particles.as_bytes()), "{particles}");
        }
        assert!(!looks_like_scene(&[0xff, 0xfe, 0x00, 0x01]));
    }
}
