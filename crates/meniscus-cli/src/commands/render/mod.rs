//! `meniscus render`: pictures of particle files and scenes.

mod options;
mod picture;

use crate::args::render::RenderArgs;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::engine::EngineChoice;
use crate::job::input::{self, FrameInput};
use crate::job::output::{self, PictureFormat};
use crate::job::{files, load};
use crate::progress::Reporter;
use crate::stats::FrameStats;
use meniscus::render::RenderState;
use meniscus::scene::Scene;
use meniscus::scene::camera::Camera;
use options::PictureOptions;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Runs the command.
pub(crate) fn run(args: &RenderArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    let format = PictureFormat::of(&args.output)?;
    let options = PictureOptions::new(args, format, &reporter)?;
    let selection = options::selection(args)?;
    let engine = EngineChoice::new(&args.engine)?;
    let edit = |scene: &mut Scene| options::edit_scene(args, format, scene);
    let inputs = input::resolve(&args.inputs, selection.as_ref(), &edit)?;
    let is_sequence = inputs.is_sequence;
    let first = inputs.first.clone();
    let jobs = match args.turntable {
        None => output::assign(inputs, &args.output)?,
        Some(count) => output::assign_turns(inputs, &args.output, count)?,
    };
    check_outputs(args, &jobs)?;
    let mut jobs: Vec<Job> = turns(jobs, args.turntable);
    if args.resume {
        let before = jobs.len();
        jobs.retain(|job| !job.output.is_file());
        if jobs.len() < before {
            reporter.note(&format!(
                "{} of {before} pictures are there already",
                before - jobs.len()
            ));
        }
    }
    let mut fixed = is_sequence.then(|| Fixed::of(&first));
    let mut all_stats = Vec::new();
    let state = RenderState::new();
    reporter.start(jobs.len());
    let mut kept = None;
    for (index, job) in jobs.iter().enumerate() {
        let Job {
            input,
            output: path,
            turn,
        } = job;
        interrupt::check()?;
        reporter.frame(index, input.number, path);
        let scene = match &mut fixed {
            Some(fixed) => fixed.scene(input, &engine, &reporter)?,
            None => (*input.scene).clone(),
        };
        let work = picture::FrameWork {
            input,
            scene: &scene,
            output: path,
            options: &options,
            engine: &engine,
            state: &state,
            turn: *turn,
        };
        // Every picture of a turntable shows the same frame.
        let loaded = match kept.take() {
            Some(loaded) => loaded,
            None => work.load(&reporter)?,
        };
        all_stats.push(work.render(&loaded, &reporter)?);
        kept = args.turntable.map(|_| loaded.used_again());
        reporter.frame_done(index, path);
    }
    if let Some(path) = &args.stats {
        write_stats(path, all_stats, is_sequence || args.turntable.is_some())?;
    }
    reporter.finish();
    Ok(())
}

/// One picture to be made.
struct Job {
    input: FrameInput,
    output: PathBuf,
    /// How far the camera is turned around the object, in radians.
    turn: f64,
}

fn turns(jobs: Vec<(FrameInput, PathBuf)>, turntable: Option<u32>) -> Vec<Job> {
    let step = turntable.map_or(0.0, |count| std::f64::consts::TAU / f64::from(count));
    let jobs = jobs.into_iter().enumerate();
    jobs.map(|(index, (input, output))| Job {
        input,
        output,
        turn: index as f64 * step,
    })
    .collect()
}

/// Finds out before the long work whether everything can be written, and that nothing is overwritten
/// that is still needed.
fn check_outputs(args: &RenderArgs, jobs: &[(FrameInput, PathBuf)]) -> Outcome {
    let mut seen = BTreeSet::new();
    let mut folders = BTreeSet::new();
    for (input, path) in jobs {
        if !seen.insert(path) {
            return Err(Failure::wrong(format!(
                "two frames would be written to {}",
                path.display()
            )));
        }
        if args.inputs.contains(path) || input.files.contains(path) {
            return Err(Failure::wrong(format!(
                "{} is an input and would be overwritten",
                path.display()
            )));
        }
        if folders.insert(path.parent()) || path.exists() {
            files::check_writable(path)?;
        }
    }
    match &args.stats {
        Some(path) => files::check_writable(path),
        None => Ok(()),
    }
}

/// One object for one picture, `frames: [...]` for a sequence.
fn write_stats(path: &Path, mut stats: Vec<FrameStats>, is_sequence: bool) -> Outcome {
    let value = match stats.pop() {
        Some(only) if !is_sequence && stats.is_empty() => serde_json::to_value(only),
        last => {
            stats.extend(last);
            serde_json::to_value(serde_json::json!({ "frames": stats }))
        }
    };
    let text = value
        .and_then(|value| serde_json::to_string_pretty(&value))
        .map_err(|error| Failure::work(format!("cannot write {}: {error}", path.display())))?;
    files::write_whole(path, format!("{text}\n").as_bytes())
}

/// What must not move from frame to frame: a default camera and the ground, which the first frame of
/// the sequence decides.
struct Fixed {
    first: FrameInput,
    /// Eye, target and ground height, once they are known.
    view: Option<View>,
}

#[derive(Clone, Copy)]
struct View {
    eye: meniscus::math::DVec3,
    target: meniscus::math::DVec3,
    ground_height: f64,
}

impl Fixed {
    fn of(first: &FrameInput) -> Self {
        Self {
            first: first.clone(),
            view: None,
        }
    }

    /// The scene of a frame with the view of the first one.
    fn scene(
        &mut self,
        input: &FrameInput,
        engine: &EngineChoice,
        reporter: &Reporter,
    ) -> Outcome<Scene> {
        let mut scene = (*input.scene).clone();
        let camera = &scene.camera;
        let camera_is_open = camera.eye.is_none() || camera.target.is_none();
        let ground_is_open = scene.ground.as_ref().is_some_and(|g| g.height.is_none());
        if !camera_is_open && !ground_is_open {
            return Ok(scene);
        }
        let view = match self.view {
            Some(view) => view,
            None => *self.view.insert(self.first_view(engine, reporter)?),
        };
        scene.camera.eye.get_or_insert(view.eye);
        scene.camera.target.get_or_insert(view.target);
        if let Some(ground) = &mut scene.ground {
            ground.height.get_or_insert(view.ground_height);
        }
        Ok(scene)
    }

    fn first_view(&self, engine: &EngineChoice, reporter: &Reporter) -> Outcome<View> {
        let scene = &self.first.scene;
        let loaded = load::load(&self.first, scene, &[], engine, reporter)?;
        let bounds = loaded.frame.framing_bounds();
        let camera = picture::camera(scene, &loaded.frame)?;
        let Camera { eye, forward, .. } = camera;
        let up = scene.camera.up.vector();
        let half = bounds.size() * 0.5;
        let lowest = bounds.center().dot(up) - half.dot(up.abs());
        let target = scene
            .camera
            .target
            .unwrap_or(eye + forward * (bounds.center() - eye).length());
        Ok(View {
            eye,
            target,
            ground_height: if lowest.is_finite() { lowest } else { 0.0 },
        })
    }
}
