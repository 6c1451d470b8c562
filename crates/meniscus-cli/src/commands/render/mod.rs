//! `meniscus render`: pictures and films of particle files and scenes.

mod ahead;
mod encoder;
mod fixed;
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
use crate::progress::Reporter;
use crate::stats::FrameStats;
use ahead::{Loader, Step};
use fixed::Fixed;
use meniscus::render::RenderState;
use meniscus::scene::Scene;
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
    let inputs = input::resolve(&args.inputs, selection.as_ref(), &edit)?;
    let is_sequence = inputs.is_sequence;
    warn_of_missing(&inputs.missing, &reporter);
    let fixed = is_sequence.then(|| Fixed::of(&inputs.first));
    let mut jobs = match args.turntable {
        None => plan::frames(inputs, &target)?,
        Some(count) => plan::turns(inputs, &target, count)?,
    };
    plan::check_outputs(args, &target, &jobs)?;
    if args.resume {
        plan::leave_out_finished(&mut jobs, &target, &reporter);
    }
    let movie = match &target {
        Target::Film(film) if !jobs.is_empty() => {
            Some(Movie::start(film, options.fps, args.resume)?)
        }
        Target::Film(_) | Target::Picture(_) | Target::Pattern(_) => None,
    };
    reporter.start(jobs.len());
    let mut production = Production {
        options: &options,
        engine: &engine,
        state: RenderState::new(),
        reporter: &reporter,
        movie,
        stats: Vec::new(),
        index: 0,
    };
    let loader = Loader {
        jobs: jobs.into_iter(),
        fixed,
        aov: &options.aov,
        engine: &engine,
        last: None,
    };
    let worked = ahead::for_each(loader, &reporter, |step| production.take(step));
    let ended = worked.and_then(|()| production.end());
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

/// Most gaps that are named.
const MOST_GAPS: usize = 5;

fn warn_of_missing(missing: &[String], reporter: &Reporter) {
    if missing.is_empty() {
        return;
    }
    let shown = &missing[..missing.len().min(MOST_GAPS)];
    let more = match missing.len() - shown.len() {
        0 => String::new(),
        more => format!(" and {more} more gaps"),
    };
    reporter.warn(&format!(
        "missing in the middle of the sequence: {}{more}; the others are rendered",
        shown.join(", ")
    ));
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
    fn take(&mut self, Step { job, ready }: Step) -> Outcome {
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

    /// Ends the film.
    fn end(&mut self) -> Outcome {
        let Some(movie) = &mut self.movie else {
            return Ok(());
        };
        if movie.frames() == 1 {
            self.reporter.warn(
                "the film has one frame; name a pattern such as 'frame_{}.vtk', or --turntable",
            );
        }
        movie.finish()
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
