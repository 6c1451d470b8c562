//! The next frame is read and built while this one renders.

use super::fixed::Fixed;
use super::plan::Job;
use crate::exit::Outcome;
use crate::interrupt;
use crate::job::engine::EngineChoice;
use crate::job::load::{self, LoadedFrame};
use crate::progress::Reporter;
use meniscus::scene::Scene;
use std::sync::{Arc, mpsc};

/// A picture's turn.
pub(super) struct Step {
    /// The picture.
    pub job: Job,
    /// What it is rendered from; `None` for one that is there already.
    pub ready: Option<Ready>,
}

/// A frame that is ready to render.
#[derive(Clone)]
pub(super) struct Ready {
    /// The scene, everything applied.
    pub scene: Arc<Scene>,
    /// The frame.
    pub loaded: Arc<LoadedFrame>,
    /// Reading and decoding its files; 0 where it was read for the picture before.
    pub read_secs: f64,
    /// Building it; 0 where it was built for the picture before.
    pub build_secs: f64,
}

/// Prepares one picture after the other.
pub(super) struct Loader<'a> {
    /// The pictures to come.
    pub jobs: std::vec::IntoIter<Job>,
    /// What does not move in a sequence.
    pub fixed: Option<Fixed>,
    /// Channels that the frames must carry.
    pub aov: &'a [String],
    /// How to trace.
    pub engine: &'a EngineChoice,
    /// The frame of the last picture, where the next one may show the same.
    pub last: Option<Ready>,
}

impl Loader<'_> {
    /// The next picture; `None` after the last.
    fn next(&mut self, reporter: &Reporter) -> Outcome<Option<Step>> {
        interrupt::check()?;
        let Some(job) = self.jobs.next() else {
            return Ok(None);
        };
        if job.is_done {
            return Ok(Some(Step { job, ready: None }));
        }
        let ready = match self.last.take() {
            Some(last) if job.is_same_frame => Ready {
                read_secs: 0.0,
                build_secs: 0.0,
                ..last
            },
            _ => self.load(&job, reporter)?,
        };
        let is_wanted_again = (self.jobs.as_slice().first()).is_some_and(|next| next.is_same_frame);
        self.last = is_wanted_again.then(|| ready.clone());
        Ok(Some(Step {
            job,
            ready: Some(ready),
        }))
    }

    fn load(&mut self, job: &Job, reporter: &Reporter) -> Outcome<Ready> {
        let input = &job.input;
        let scene = match &mut self.fixed {
            Some(fixed) => fixed.scene(input, self.engine, reporter)?,
            None => (*input.scene).clone(),
        };
        let loaded = load::load(input, &scene, self.aov, self.engine, reporter)?;
        Ok(Ready {
            scene: Arc::new(scene),
            read_secs: loaded.read_secs,
            build_secs: loaded.build_secs,
            loaded: Arc::new(loaded),
        })
    }
}

/// Gives every picture to `handle` in order. While it is being handled the next one is prepared, and
/// no more than that one: two frames are in memory at most. What goes wrong with a picture is reported
/// when it is its turn.
pub(super) fn for_each(
    mut loader: Loader<'_>,
    reporter: &Reporter,
    mut handle: impl FnMut(Step) -> Outcome,
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
