//! Which pictures are to be made, of what, and where they go.

use crate::args::render::RenderArgs;
use crate::exit::{Failure, Outcome};
use crate::job::files;
use crate::job::input::{self, FrameInput, Inputs, steps_of};
use crate::job::output::{Target, kept_folder};
use crate::progress::Reporter;
use meniscus::particles::sequence::{self, FrameSelection};
use meniscus::scene::Scene;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most pictures of a turntable.
const MAX_TURNS: u32 = 100_000;

/// One picture to be made.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    /// Where its particles come from.
    pub input: Arc<FrameInput>,
    /// Where it shows a moment on the way to the next frame.
    pub interval: Option<Interval>,
    /// Its file.
    pub output: PathBuf,
    /// When it is, in pictures since the first one of the whole sequence.
    pub since_first: f64,
    /// How far the camera is turned around the object, in radians.
    pub turn: f64,
    /// Whether it shows the same particles as the picture before.
    pub is_same_frame: bool,
    /// Whether the picture is there already and stays.
    pub is_done: bool,
}

/// The way from a frame to the next one.
#[derive(Debug, Clone)]
pub(crate) struct Interval {
    /// The frame before the interval.
    pub before: Option<Arc<FrameInput>>,
    /// The frame at its end.
    pub next: Arc<FrameInput>,
    /// The frame after it.
    pub after: Option<Arc<FrameInput>>,
    /// When the frame before, both ends and the frame after are, in frames of the input.
    pub times: [f64; 4],
    /// The moment: 0 at the start, below 1.
    pub fraction: f64,
}

impl Job {
    /// The picture of a frame of a sequence, or of a single file.
    pub(crate) fn of_frame(input: FrameInput, target: &Target) -> Self {
        let output = target.path(&input.text, &format!("frame_{}", input.text));
        Self {
            input: Arc::new(input),
            interval: None,
            output,
            since_first: 0.0,
            turn: 0.0,
            is_same_frame: false,
            is_done: false,
        }
    }
}

/// The pictures of all frames; a single file of several time steps gives all of them where there is
/// room.
pub(crate) fn frames(inputs: Inputs, target: &Target) -> Outcome<Vec<Job>> {
    let mut first_number = inputs.first().number;
    let Inputs {
        mut frames,
        is_sequence,
        step,
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
        first_number = frames.first().map_or(0, |first| first.number);
    }
    let jobs = frames.into_iter().map(|frame| Job {
        since_first: frames_between(first_number, frame.number) / step.max(1) as f64,
        ..Job::of_frame(frame, target)
    });
    Ok(jobs.collect())
}

/// How much later a frame's number is.
pub(super) fn frames_between(first: u64, number: u64) -> f64 {
    number.saturating_sub(first) as f64
}

/// Most pictures of a slow motion.
const MAX_MOMENTS: f64 = 1e7;
/// Moments that differ by less are the same.
const SAME_MOMENT: f64 = 1e-9;

/// The pictures of a slow motion: `factor` of them for each frame of the input, numbered from 0. Where
/// frames are missing the way over the gap takes as long as it would with them.
pub(crate) fn moments(inputs: Inputs, target: &Target, factor: f64) -> Outcome<Vec<Job>> {
    let (is_sequence, all_step) = (inputs.is_sequence, inputs.step as f64);
    let first_of_all = inputs.first().number;
    let frames = match &inputs.frames[..] {
        [only] if !is_sequence => steps_of(only)?,
        _ => inputs.frames,
    };
    if frames.len() < 2 {
        return Err(Failure::wrong("--slow-motion needs two frames or more")
            .with_help("name a pattern such as 'frame_{}.vtk', or a trajectory"));
    }
    if let Target::Picture(output) = target {
        return Err(Failure::wrong(format!(
            "--slow-motion writes many pictures, which cannot all go to {}",
            output.display()
        ))
        .with_help(
            "put {} where the picture's number goes, as in -o 'slow_{}.png', or write .mp4",
        ));
    }
    let frames: Vec<Arc<FrameInput>> = frames.into_iter().map(Arc::new).collect();
    let numbers: Vec<u64> = frames.iter().map(|frame| frame.number).collect();
    let step = sequence::usual_step(&numbers) as f64;
    let mut times = vec![0.0];
    for pair in numbers.windows(2) {
        let length = pair[1].saturating_sub(pair[0]).max(1) as f64 / step;
        times.push(times.last().unwrap_or(&0.0) + length);
    }
    let end = times.last().unwrap_or(&0.0) * factor;
    if end >= MAX_MOMENTS {
        return Err(Failure::wrong(format!(
            "--slow-motion {factor} makes {end:.0} pictures; {MAX_MOMENTS:.0} are possible"
        )));
    }
    let count = (end + SAME_MOMENT).floor() as usize + 1;
    let width = (count - 1).to_string().len();
    let (first, last) = (&frames[0].text, &frames[frames.len() - 1].text);
    let kept_of = format!("{factor}_from_{first}_to_{last}_by_{step}");
    // Frames of the input, of which a selection may leave some out, in times of the selection.
    let unit = step / all_step.max(1.0);
    let skipped = match is_sequence {
        true => frames_between(first_of_all, numbers[0]) / all_step.max(1.0),
        false => 0.0,
    };
    let mut at = 0;
    let jobs = (0..count).map(|moment| {
        let time = moment as f64 / factor;
        while at + 2 < frames.len() && times[at + 1] <= time + SAME_MOMENT {
            at += 1;
        }
        let length = times[at + 1] - times[at];
        let fraction = (time - times[at]) / length;
        let is_end = fraction > 1.0 - SAME_MOMENT;
        let start = if is_end { at + 1 } else { at };
        let next = (start + 1).min(frames.len() - 1);
        let time_of = |frame: usize| times[frame.min(frames.len() - 1)] * unit;
        let interval = Interval {
            before: start.checked_sub(1).map(|before| frames[before].clone()),
            next: frames[next].clone(),
            after: frames.get(start + 2).cloned(),
            times: [start.saturating_sub(1), start, start + 1, start + 2].map(time_of),
            fraction: if is_end || fraction < SAME_MOMENT {
                0.0
            } else {
                fraction
            },
        };
        let number = format!("{moment:0width$}");
        Job {
            input: frames[start].clone(),
            interval: Some(interval),
            output: target.path(&number, &format!("slow_{number}_x{kept_of}")),
            since_first: (skipped + time * unit) * factor,
            turn: 0.0,
            is_same_frame: false,
            is_done: false,
        }
    });
    Ok(jobs.collect())
}

/// What a turntable turns around, and which of its pictures are wanted: among files and time steps a
/// selection chooses the frame, of a single still it chooses pictures.
pub(crate) fn turned(
    inputs: &[PathBuf],
    selection: Option<&FrameSelection>,
    edit: &dyn Fn(&mut Scene) -> Outcome,
) -> Outcome<(Inputs, Option<FrameSelection>)> {
    let all = input::resolve(inputs, None, edit)?;
    let Some(selection) = selection else {
        return Ok((all, None));
    };
    match &all.frames[..] {
        [still] if !all.is_sequence && steps_of(still)?.len() == 1 => {
            Ok((all, Some(selection.clone())))
        }
        _ => Ok((input::resolve(inputs, Some(selection), edit)?, None)),
    }
}

/// The pictures of a turntable of `count` pictures, numbered from 0: all of one frame, or those that
/// `wanted` chooses.
pub(crate) fn turns(
    inputs: Inputs,
    wanted: Option<&FrameSelection>,
    target: &Target,
    count: u32,
) -> Outcome<Vec<Job>> {
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
    let frame = Arc::new(frame);
    let width = (count - 1).to_string().len();
    let step = std::f64::consts::TAU / f64::from(count);
    let is_wanted = |turn: &u32| wanted.is_none_or(|wanted| wanted.contains(u64::from(*turn)));
    let wanted_turns: Vec<u32> = (0..count).filter(is_wanted).collect();
    let Some(&first) = wanted_turns.first() else {
        return Err(Failure::wrong(format!(
            "--frames chooses none of the {count} pictures of the turntable"
        ))
        .with_help(format!("they are numbered 0 to {}", count - 1)));
    };
    Ok(wanted_turns
        .into_iter()
        .map(|turn| Job {
            input: frame.clone(),
            interval: None,
            output: target.path(
                &format!("{turn:0width$}"),
                &format!("turn_{turn:0width$}_of_{count}_of_frame_{}", frame.text),
            ),
            since_first: 0.0,
            turn: f64::from(turn) * step,
            is_same_frame: turn > first,
            is_done: false,
        })
        .collect())
}

/// Whether a file is there; an empty one is no picture.
pub(crate) fn is_there(path: &Path) -> bool {
    path.metadata().is_ok_and(|m| m.is_file() && m.len() > 0)
}

/// Marks the pictures that are there already, or leaves out all where the film itself is; says so.
pub(crate) fn leave_out_finished(jobs: &mut Vec<Job>, target: &Target, reporter: &Reporter) {
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
    if let (Target::Pattern(_), []) = (target, jobs) {
        // They are not known yet; their folder is.
        files::check_writable(&target.path("0", ""))?;
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
