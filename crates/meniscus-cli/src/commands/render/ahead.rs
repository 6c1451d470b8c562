//! The next frame is read and built while this one renders.

use super::fixed::Fixed;
use super::join::Joiner;
use super::plan::{self, Job};
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::Tracing;
use crate::job::engine::EngineChoice;
use crate::job::load::{self, LoadedFrame, ReadFrame, WithoutParticles};
use crate::job::output::Target;
use crate::job::watch::Watch;
use crate::progress::Reporter;
use meniscus::scene::Scene;
use std::sync::{Arc, mpsc};
use std::time::Instant;

/// A picture's turn.
pub(super) struct Step<'a> {
    /// The picture.
    pub job: Job,
    /// What it is rendered from; `None` for one that is there already.
    pub ready: Option<Ready<'a>>,
}

/// A frame that is ready to render.
#[derive(Clone)]
pub(super) struct Ready<'a> {
    /// The scene, everything applied.
    pub scene: Arc<Scene>,
    /// The frame.
    pub loaded: Arc<LoadedFrame>,
    /// What traces it, if it is there already.
    pub tracing: Option<Arc<Tracing<'a>>>,
    /// Reading and decoding its files; 0 where it was read for the picture before.
    pub read_secs: f64,
    /// Building it, and sending it to a card; 0 where it was built for the picture before.
    pub build_secs: f64,
}

/// Which picture comes next.
pub(super) enum Schedule<'a> {
    /// All are known.
    List(std::vec::IntoIter<Job>),
    /// They appear.
    Watch {
        /// Waits for frames.
        watch: Watch<'a>,
        /// Where pictures go.
        target: &'a Target,
        /// Whether pictures that are there stay.
        resumes: bool,
    },
}

/// Prepares one picture after the other.
pub(super) struct Loader<'a> {
    /// The pictures to come.
    pub schedule: Schedule<'a>,
    /// What does not move in a sequence.
    pub fixed: Option<Fixed>,
    /// Joins frames.
    pub joiner: Joiner,
    /// Channels that the frames must carry.
    pub aov: &'a [String],
    /// How to trace.
    pub engine: &'a EngineChoice,
    /// The frame of the last picture, where the next one shows the same.
    pub last: Option<Ready<'a>>,
}

impl<'a> Loader<'a> {
    /// The next picture; `None` after the last.
    fn next(&mut self, reporter: &Reporter) -> Outcome<Option<Step<'a>>> {
        loop {
            interrupt::check()?;
            let Some(job) = self.next_job(reporter)? else {
                return Ok(None);
            };
            if let Some(fixed) = &mut self.fixed {
                fixed.appears(&job.input);
            }
            if job.is_done {
                return Ok(Some(Step { job, ready: None }));
            }
            let last = self.last.take().filter(|_| job.is_same_frame);
            let ready = match last {
                Some(last) => Ready {
                    read_secs: 0.0,
                    build_secs: 0.0,
                    ..last
                },
                None => match self.joiner.read(&job, reporter) {
                    Ok(read) => self.build(&job, read, reporter)?,
                    Err(failure) => {
                        self.try_later(&job, failure)?;
                        continue;
                    }
                },
            };
            if let Schedule::List(jobs) = &self.schedule
                && jobs
                    .as_slice()
                    .first()
                    .is_some_and(|next| next.is_same_frame)
            {
                self.last = Some(ready.clone());
            }
            return Ok(Some(Step {
                job,
                ready: Some(ready),
            }));
        }
    }

    fn next_job(&mut self, reporter: &Reporter) -> Outcome<Option<Job>> {
        match &mut self.schedule {
            Schedule::List(jobs) => Ok(jobs.next()),
            Schedule::Watch {
                watch,
                target,
                resumes,
            } => {
                let input = watch.next(reporter)?;
                let first = self.fixed.as_ref().and_then(Fixed::first_number);
                Ok(input.map(|input| {
                    let first = first.unwrap_or(input.number);
                    let since_first = plan::frames_between(first, input.number);
                    let job = Job::of_frame(input, target);
                    let is_done = *resumes && plan::is_there(&job.output);
                    Job {
                        since_first,
                        is_done,
                        ..job
                    }
                }))
            }
        }
    }

    /// A file that cannot be read may still be in the making where frames appear.
    fn try_later(&mut self, job: &Job, failure: Failure) -> Outcome {
        match (&mut self.schedule, failure) {
            (Schedule::Watch { watch, .. }, Failure::Work(message)) => {
                watch.refuse(&job.input, message.text);
                Ok(())
            }
            (_, failure) => Err(failure),
        }
    }

    fn build(&mut self, job: &Job, read: ReadFrame, reporter: &Reporter) -> Outcome<Ready<'a>> {
        let input = &job.input;
        let mut scene = match &mut self.fixed {
            Some(fixed) => fixed.scene(input, self.engine, reporter)?,
            None => (*input.scene).clone(),
        };
        scene.motion.time += job.since_first / scene.motion.fps;
        reporter.stage("build");
        let without = match self.fixed {
            Some(_) => WithoutParticles::IsEmpty,
            None => WithoutParticles::Fails,
        };
        let files = &read.files;
        let loaded = load::build(
            input,
            &scene,
            files,
            self.aov,
            self.engine,
            without,
            reporter,
        )?;
        let start = Instant::now();
        // The frame before may still be rendered: a card has two in its memory then.
        let tracing = Tracing::ahead(self.engine, &loaded.frame);
        Ok(Ready {
            scene: Arc::new(scene),
            read_secs: read.read_secs,
            build_secs: loaded.build_secs + start.elapsed().as_secs_f64(),
            tracing: tracing.map(Arc::new),
            loaded: Arc::new(loaded),
        })
    }
}

/// Gives every picture to `handle` in order. While it is being handled the next one is prepared, and
/// no more than that one: two frames are in memory at most. What goes wrong with a picture is reported
/// when it is its turn.
pub(super) fn for_each<'a>(
    mut loader: Loader<'a>,
    reporter: &Reporter,
    mut handle: impl FnMut(Step<'a>) -> Outcome,
) -> Outcome {
    let Some(first) = loader.next(reporter)? else {
        return Ok(());
    };
    // Who asks for one thread gets no second one beside it.
    if loader.engine.threads == 1 {
        handle(first)?;
        while let Some(step) = loader.next(reporter)? {
            handle(step)?;
        }
        return Ok(());
    }
    // Without room in the channel the loader waits with a finished frame until it is taken.
    let (sender, receiver) = mpsc::sync_channel(0);
    std::thread::scope(move |scope| {
        scope.spawn(move || {
            loop {
                let held = Reporter::held();
                let step = loader.next(&held);
                let is_last = !matches!(step, Ok(Some(_)));
                if sender.send((held, step)).is_err() || is_last {
                    return;
                }
            }
        });
        let mut step = first;
        loop {
            handle(step)?;
            let Ok((held, next)) = receiver.recv() else {
                return Ok(());
            };
            reporter.replay(held);
            match next? {
                Some(next) => step = next,
                None => return Ok(()),
            }
        }
    })
}
