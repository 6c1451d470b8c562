//! Trajectories over a topology, as the frames of a sequence.

use super::input::{FrameInput, Inputs};
use crate::exit::{Failure, Outcome};
use meniscus::particles::io::{self, Format, ParticleFile, ReadError};
use meniscus::particles::sequence::is_pattern;
use meniscus::particles::trajectory::Trajectory;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A molecule and where its atoms are in each frame.
#[derive(Debug)]
pub(crate) struct Trajectories {
    topology: ParticleFile,
    /// Files that follow each other.
    parts: Vec<Trajectory>,
}

fn failed(error: ReadError) -> Failure {
    Failure::work(error.to_string())
}

/// Parts the trajectories among the inputs from the others.
pub(super) fn split(inputs: &[PathBuf]) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let is_trajectory = |path: &Path| {
        // What cannot be read is reported as an input of another kind.
        !is_pattern(path) && path.is_file() && matches!(Trajectory::detect(path), Ok(Some(_)))
    };
    inputs.iter().cloned().partition(|path| is_trajectory(path))
}

/// The frames of trajectories over `topology`, the one frame that the other inputs stand for; with
/// them what a user should know.
pub(super) fn frames(
    trajectories: &[PathBuf],
    topology: Inputs,
) -> Outcome<(Vec<FrameInput>, Vec<String>)> {
    let frame = topology.first();
    let Some(file) = frame.files.first().filter(|_| !topology.is_sequence) else {
        return Err(Failure::wrong(
            "a trajectory lies over one molecule file, or over a scene that has one",
        )
        .with_help("as in: meniscus render topology.pdb trajectory.xtc -o film.mp4"));
    };
    let (over, warnings) = Trajectories::open(file, trajectories)?;
    let count = over.len();
    let over = Arc::new(over);
    let width = (count - 1).to_string().len();
    let frames = (0..count)
        .map(|step| FrameInput {
            trajectory: Some(over.clone()),
            step,
            number: step as u64,
            text: format!("{step:0width$}"),
            ..frame.clone()
        })
        .collect();
    Ok((frames, warnings))
}

impl Trajectories {
    fn open(topology: &Path, parts: &[PathBuf]) -> Outcome<(Self, Vec<String>)> {
        let mut file = io::read(topology, 0).map_err(failed)?;
        if !file.format.is_molecule() && file.format != Format::Xyz {
            return Err(Failure::wrong(format!(
                "{}: a trajectory lies over a molecule file, this is {}",
                topology.display(),
                file.format
            ))
            .with_help("give a PDB, mmCIF, GRO or XYZ file of the same atoms"));
        }
        let named = |path: &Path, words: &str| format!("{}: {words}", path.display());
        let mut warnings: Vec<String> = file
            .warnings
            .drain(..)
            .map(|words| named(topology, &words))
            .collect();
        let parts: Vec<Trajectory> = parts
            .iter()
            .map(|path| {
                let part = Trajectory::open(path).map_err(failed)?;
                part.check(&file).map_err(failed)?;
                warnings.extend(part.warnings().iter().map(|words| named(path, words)));
                Ok(part)
            })
            .collect::<Outcome<_>>()?;
        let topology = file;
        Ok((Self { topology, parts }, warnings))
    }

    /// Frames of all files together; never 0.
    fn len(&self) -> usize {
        self.parts.iter().map(Trajectory::len).sum()
    }

    /// The molecule in frame `frame`, and its time in picoseconds.
    pub(super) fn read(&self, frame: usize) -> Outcome<(ParticleFile, Option<f64>)> {
        let mut step = frame;
        for part in &self.parts {
            if step < part.len() {
                let (particles, time_ps) = part.over(&self.topology, step).map_err(failed)?;
                let file = ParticleFile {
                    particles,
                    format: self.topology.format,
                    frames: self.len(),
                    left_out: self.topology.left_out,
                    warnings: Vec::new(),
                };
                return Ok((file, time_ps));
            }
            step -= part.len();
        }
        Err(Failure::work(format!(
            "there is no frame {frame} in the trajectory"
        )))
    }
}
