//! Which pictures are to be made, of what, and where they go.

use crate::args::render::RenderArgs;
use crate::exit::{Failure, Outcome};
use crate::job::files;
use crate::job::input::{FrameInput, Inputs, steps_of};
use crate::job::output::{Target, kept_folder};
use crate::progress::Reporter;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Most pictures of a turntable.
const MAX_TURNS: u32 = 100_000;

/// One picture to be made.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    /// Where its particles come from.
    pub input: FrameInput,
    /// Its file.
    pub output: PathBuf,
    /// How far the camera is turned around the object, in radians.
    pub turn: f64,
    /// Whether it shows the same particles as the picture before.
    pub is_same_frame: bool,
    /// Whether the picture is there already and stays.
    pub is_done: bool,
}

impl Job {
    /// The picture of a frame of a sequence, or of a single file.
    pub(crate) fn of_frame(input: FrameInput, target: &Target) -> Self {
        let output = target.path(&input.text, &format!("frame_{}", input.text));
        Self {
            input,
            output,
            turn: 0.0,
            is_same_frame: false,
            is_done: false,
        }
    }
}

/// The pictures of all frames; a single file of several time steps gives all of them where there is
/// room.
pub(crate) fn frames(inputs: Inputs, target: &Target) -> Outcome<Vec<Job>> {
    let Inputs {
        mut frames,
        is_sequence,
        ..
    } = inputs;
    if let Target::Picture(output) = target
        && frames.len() > 1
    {
        return Err(Failure::wrong(format!(
            "{} frames cannot all be written to {}",
            frames.len(),
            output.display()
        ))
        .with_help("put {} where the frame number goes, as in -o 'frame_{}.png', or write .mp4"));
    }
    if target.takes_several()
        && !is_sequence
        && let [only] = &frames[..]
    {
        frames = steps_of(only)?;
    }
    let frames = frames.into_iter();
    Ok(frames.map(|frame| Job::of_frame(frame, target)).collect())
}

/// The pictures of a turntable of `count` pictures, numbered from 0: all of one frame.
pub(crate) fn turns(inputs: Inputs, target: &Target, count: u32) -> Outcome<Vec<Job>> {
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
    if let Target::Picture(output) = target {
        return Err(Failure::wrong(format!(
            "--turntable writes {count} pictures, which cannot all go to {}",
            output.display()
        ))
        .with_help(
            "put {} where the picture's number goes, as in -o 'turn_{}.png', or write .mp4",
        ));
    }
    let width = (count - 1).to_string().len();
    let step = std::f64::consts::TAU / f64::from(count);
    Ok((0..count)
        .map(|turn| Job {
            input: frame.clone(),
            output: target.path(
                &format!("{turn:0width$}"),
                &format!("turn_{turn:0width$}_of_{count}_of_frame_{}", frame.text),
            ),
            turn: f64::from(turn) * step,
            is_same_frame: turn > 0,
            is_done: false,
        })
        .collect())
}

/// Marks the pictures that are there already, or leaves out all where the film itself is; says so. An
/// empty file is no picture.
pub(crate) fn leave_out_finished(jobs: &mut Vec<Job>, target: &Target, reporter: &Reporter) {
    let is_there = |path: &Path| path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0);
    // With kept pictures beside it a film is an older one that is being made again.
    if let Target::Film(film) = target
        && is_there(film)
        && !kept_folder(film).exists()
    {
        reporter.tell(&format!("{} is there already", film.display()));
        jobs.clear();
        return;
    }
    for job in &mut *jobs {
        job.is_done = is_there(&job.output);
    }
    let done = jobs.iter().filter(|job| job.is_done).count();
    if done > 0 {
        reporter.tell(&format!(
            "{done} of {} pictures are there already and are skipped",
            jobs.len()
        ));
    }
}

/// Finds out before the long work whether everything can be written, and that nothing is overwritten
/// that is still needed.
pub(crate) fn check_outputs(args: &RenderArgs, target: &Target, jobs: &[Job]) -> Outcome {
    let mut seen = BTreeSet::new();
    let mut folders = BTreeSet::new();
    if let Target::Film(film) = target {
        check_not_input(args, jobs, film)?;
        files::check_writable(film)?;
    }
    for Job { output: path, .. } in jobs {
        if !seen.insert(path) {
            return Err(Failure::wrong(format!(
                "two frames would be written to {}",
                path.display()
            )));
        }
        if let Target::Film(_) = target {
            continue;
        }
        if folders.insert(path.parent()) || path.exists() {
            files::check_writable(path)?;
        }
    }
    for job in jobs {
        check_not_input(args, std::slice::from_ref(job), &job.output)?;
    }
    match &args.stats {
        Some(path) => files::check_writable(path),
        None => Ok(()),
    }
}

fn check_not_input(args: &RenderArgs, jobs: &[Job], path: &PathBuf) -> Outcome {
    if args.inputs.contains(path) || jobs.iter().any(|job| job.input.files.contains(path)) {
        return Err(Failure::wrong(format!(
            "{} is an input and would be overwritten",
            path.display()
        )));
    }
    Ok(())
}
