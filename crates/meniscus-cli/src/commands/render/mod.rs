//! `meniscus render`: pictures and films of particle files and scenes.

mod ahead;
mod encoder;
mod fixed;
mod join;
mod movie;
mod options;
mod picture;
mod plan;

use crate::args::render::RenderArgs;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::engine::EngineChoice;
use crate::job::files;
use crate::job::input;
use crate::job::output::{PictureFormat, Target};
use crate::job::watch::Watch;
use crate::progress::Reporter;
use crate::stats::FrameStats;
use ahead::{Loader, Schedule, Step};
use fixed::Fixed;
use join::Joiner;
use meniscus::render::RenderState;
use meniscus::scene::{MotionSettings, Scene};
use movie::Movie;
use options::PictureOptions;
use std::path::Path;

/// Runs the command.
pub(crate) fn run(args: &RenderArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    let format = PictureFormat::of(&args.output)?;
    let target = Target::new(&args.output, format)?;
    let options = PictureOptions::new(args, format, &reporter)?;
    let selection = options::selection(args)?;
    let engine = EngineChoice::new(&args.engine)?;
    let edit = |scene: &mut Scene| options::edit_scene(args, format, scene);
    let (jobs, fixed, is_sequence) = if args.watch {
        plan::check_outputs(args, &target, &[])?;
        (None, Some(Fixed::default()), true)
    } else {
        let (inputs, wanted_turns) = match args.turntable {
            None => (
                input::resolve(&args.inputs, selection.as_ref(), &edit)?,
                None,
            ),
            Some(_) => plan::turned(&args.inputs, selection.as_ref(), &edit)?,
        };
        inputs
            .warnings
            .iter()
            .for_each(|words| reporter.warn(words));
        let is_sequence = inputs.is_sequence;
        let fixed =
            (is_sequence || options.slow_motion.is_some()).then(|| Fixed::by(inputs.all.clone()));
        let mut jobs = match (args.turntable, options.slow_motion) {
            (None, None) => plan::frames(inputs, &target)?,
            (None, Some(factor)) => plan::moments(inputs, &target, factor)?,
            (Some(count), _) => plan::turns(inputs, wanted_turns.as_ref(), &target, count)?,
        };
        plan::check_outputs(args, &target, &jobs)?;
        if args.resume {
            plan::leave_out_finished(&mut jobs, &target, &reporter);
        }
        (Some(jobs), fixed, is_sequence || args.turntable.is_some())
    };
    let slow_motion = options.slow_motion.unwrap_or(1.0);
    let scene_fps =
        |jobs: &Vec<plan::Job>| Some(jobs.first()?.input.scene.motion.fps / slow_motion);
    let fps = options.fps.or_else(|| jobs.as_ref().and_then(scene_fps));
    let fps = fps.unwrap_or(MotionSettings::default().fps);
    let movie = match &target {
        Target::Film(film) if jobs.as_ref().is_none_or(|jobs| !jobs.is_empty()) => {
            Some(Movie::start(film, fps, args.resume)?)
        }
        Target::Film(_) | Target::Picture(_) | Target::Pattern(_) => None,
    };
    let engine = engine.on_device(None, &reporter)?;
    reporter.start(jobs.as_ref().map_or(0, Vec::len));
    let mut production = Production {
        options: &options,
        engine: &engine,
        state: RenderState::new(),
        reporter: &reporter,
        movie,
        stats: Vec::new(),
        index: 0,
    };
    let schedule = match jobs {
        Some(jobs) => Schedule::List(jobs.into_iter()),
        None => Schedule::Watch {
            watch: Watch::new(
                &args.inputs,
                selection.as_ref(),
                &edit,
                options.watch_timeout,
            )?,
            target: &target,
            resumes: args.resume,
        },
    };
    let loader = Loader {
        schedule,
        fixed,
        joiner: Joiner::new(slow_motion),
        aov: &options.aov,
        engine: &engine,
        last: None,
    };
    let worked = ahead::for_each(loader, &reporter, |step| production.take(step));
    let ended = match worked {
        // Whoever watches ends with Ctrl-C, and has a film of what there was.
        Err(Failure::Interrupted) if args.watch => {
            production.end(true).and(Err(Failure::Interrupted))
        }
        worked => worked.and_then(|()| production.end(false)),
    };
    if ended.is_err() {
        production.tell_what_stays();
    }
    ended?;
    if let Some(path) = &args.stats {
        write_stats(
            path,
            production.stats,
            is_sequence || args.turntable.is_some(),
        )?;
    }
    reporter.finish();
    Ok(())
}

/// What goes on from picture to picture.
struct Production<'a> {
    options: &'a PictureOptions,
    engine: &'a EngineChoice,
    state: RenderState,
    reporter: &'a Reporter,
    movie: Option<Movie>,
    stats: Vec<FrameStats>,
    /// Number of the picture in this run.
    index: usize,
}

impl Production<'_> {
    /// Renders and writes a picture, unless it is there already, and hands it to the film.
    fn take(&mut self, Step { job, ready }: Step<'_>) -> Outcome {
        interrupt::check()?;
        let index = self.index;
        self.index += 1;
        self.reporter.frame(index, job.input.number, &job.output);
        if let Some(ready) = ready {
            let work = picture::FrameWork {
                ready: &ready,
                output: &job.output,
                options: self.options,
                engine: self.engine,
                state: &self.state,
                turn: job.turn,
            };
            self.stats.push(work.render(self.reporter)?);
            self.reporter.frame_done(index, &job.output);
        }
        match &mut self.movie {
            Some(movie) => movie.push(&job.output),
            None => Ok(()),
        }
    }

    /// Ends the film, in spite of Ctrl-C if `is_sure`.
    fn end(&mut self, is_sure: bool) -> Outcome {
        let Some(movie) = &mut self.movie else {
            return Ok(());
        };
        if movie.frames() == 0 {
            self.reporter
                .warn("there was no frame, so there is no film");
            return Ok(());
        }
        if movie.frames() == 1 {
            self.reporter.warn(
                "the film has one frame; name a pattern such as 'frame_{}.vtk', or --turntable",
            );
        }
        movie.finish(is_sure)
    }

    /// After a failure: which pictures of the film are kept.
    fn tell_what_stays(&self) {
        if let Some((folder, count)) = self.movie.as_ref().and_then(Movie::kept) {
            self.reporter.tell(&format!(
                "no film yet; {count} finished pictures are kept in {}: the same command with --resume goes on from there",
                folder.display()
            ));
        }
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
