//! Frames between frames: the particle files of an interval, kept while they are needed, and joined.

use super::plan::{Interval, Job};
use crate::exit::{Failure, Outcome};
use crate::job::input::FrameInput;
use crate::job::load::{self, ReadFrame};
use crate::progress::Reporter;
use meniscus::particles::Particles;
use meniscus::particles::between::{BetweenError, BetweenSettings, Identity, Moment, Pair};
use meniscus::particles::io::ParticleFile;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Frames that an interval depends on: its ends and one beyond each.
const KEPT: usize = 4;

/// What tells frames apart.
type Key = (Vec<PathBuf>, usize);

fn key(input: &FrameInput) -> Key {
    (input.files.clone(), input.step)
}

/// A frame's files, decoded; the particles apart from the rest.
struct Kept {
    particles: Vec<Arc<Particles>>,
    files: Vec<ParticleFile>,
    time_ps: Option<f64>,
}

impl Kept {
    fn files_with(&self, particles: Vec<Particles>) -> Vec<ParticleFile> {
        let files = self.files.iter().cloned().zip(particles);
        let whole = files.map(|(file, particles)| ParticleFile { particles, ..file });
        whole.collect()
    }
}

/// Joins the frames of a sequence.
pub(super) struct Joiner {
    /// Pictures for each frame of the input.
    slow_motion: f64,
    kept: VecDeque<(Key, Arc<Kept>)>,
    /// The last interval's ends and its pairs, one per surface; `None` where both ends read the same
    /// file.
    pairs: Option<([Key; 2], Vec<Option<Pair>>)>,
    has_warned: bool,
}

impl Joiner {
    /// A joiner for this many pictures to each frame of the input.
    pub(super) fn new(slow_motion: f64) -> Self {
        Self {
            slow_motion,
            kept: VecDeque::new(),
            pairs: None,
            has_warned: false,
        }
    }

    /// The particles of a picture's moment.
    pub(super) fn read(&mut self, job: &Job, reporter: &Reporter) -> Outcome<ReadFrame> {
        let Some(interval) = &job.interval else {
            return load::read(&job.input, reporter);
        };
        let start = Instant::now();
        let here = self.frame(&job.input, reporter)?;
        let files = if interval.fraction == 0.0 {
            let particles = here.particles.iter().map(|p| (**p).clone());
            here.files_with(particles.collect())
        } else {
            let next = self.frame(&interval.next, reporter)?;
            let ends = [key(&job.input), key(&interval.next)];
            if self.pairs.as_ref().is_none_or(|(known, _)| *known != ends) {
                let pairs = self.join(job, interval, [&here, &next], reporter)?;
                self.pairs = Some((ends, pairs));
            }
            let pairs = self.pairs.iter().flat_map(|(_, pairs)| pairs);
            let particles = pairs.zip(&here.particles).map(|(pair, still)| match pair {
                Some(pair) => pair.at(interval.fraction),
                None => (**still).clone(),
            });
            here.files_with(particles.collect())
        };
        Ok(ReadFrame {
            files,
            time_ps: None,
            read_secs: start.elapsed().as_secs_f64(),
        })
    }

    /// A frame's files, read once.
    fn frame(&mut self, input: &FrameInput, reporter: &Reporter) -> Outcome<Arc<Kept>> {
        let key = key(input);
        if let Some((_, kept)) = self.kept.iter().find(|(known, _)| *known == key) {
            return Ok(kept.clone());
        }
        let ReadFrame { files, time_ps, .. } = load::read(input, reporter)?;
        let mut particles = Vec::with_capacity(files.len());
        let files = files
            .into_iter()
            .map(|mut file| {
                particles.push(Arc::new(std::mem::take(&mut file.particles)));
                file
            })
            .collect();
        let kept = Arc::new(Kept {
            particles,
            files,
            time_ps,
        });
        if self.kept.len() == KEPT {
            self.kept.pop_front();
        }
        self.kept.push_back((key, kept.clone()));
        Ok(kept)
    }

    fn join(
        &mut self,
        job: &Job,
        interval: &Interval,
        [here, next]: [&Arc<Kept>; 2],
        reporter: &Reporter,
    ) -> Outcome<Vec<Option<Pair>>> {
        let before = interval.before.as_ref();
        let before = before
            .map(|input| self.frame(input, reporter))
            .transpose()?;
        let after = interval.after.as_ref();
        let after = after.map(|input| self.frame(input, reporter)).transpose()?;
        let all = [&before, &Some(here.clone()), &Some(next.clone()), &after];
        // A trajectory's own times count where all frames have one and they rise: its velocities are
        // per picosecond.
        let own: Option<Vec<f64>> = all
            .into_iter()
            .flatten()
            .map(|frame| frame.time_ps)
            .collect();
        let has_times = own.is_some_and(|own| own.is_sorted_by(|a, b| a < b));
        let inputs = [
            interval.before.as_deref(),
            Some(&*job.input),
            Some(&*interval.next),
            interval.after.as_deref(),
        ];
        let motion = &job.input.scene.motion;
        let frame_secs = self.slow_motion / motion.fps;
        let mut pairs = Vec::with_capacity(here.files.len());
        for surface in 0..here.files.len() {
            let paths = [&job.input, &interval.next].map(|input| &input.files[surface]);
            let is_moving = job.input.trajectory.is_some() && surface == 0;
            if paths[0] == paths[1]
                && !is_moving
                && (surface > 0 || job.input.step == interval.next.step)
            {
                pairs.push(None);
                continue;
            }
            let moment = |place: usize| -> Option<Moment> {
                let frame = all[place].as_ref()?;
                let input = inputs[place]?;
                let seconds = interval.times[place] * frame_secs;
                Some(Moment {
                    name: name(input, surface),
                    particles: frame.particles[surface].clone(),
                    time: frame.time_ps.filter(|_| has_times).unwrap_or(seconds),
                })
            };
            let (Some(earlier), Some(later)) = (moment(1), moment(2)) else {
                return Err(Failure::work("an interval without ends"));
            };
            let is_molecule = here.files[surface].format.is_molecule();
            let settings = BetweenSettings {
                identity: if is_moving || is_molecule {
                    Identity::Rows
                } else {
                    Identity::Ids
                },
                velocity_scale: motion.velocity_scale,
            };
            let pair = Pair::new(
                moment(0).as_ref(),
                &earlier,
                &later,
                moment(3).as_ref(),
                &settings,
            )
            .map_err(failure)?;
            if let Some(fitting) = pair.fitting_velocity_scale()
                && !self.has_warned
            {
                self.has_warned = true;
                let fitting = fitting * motion.velocity_scale;
                reporter.warn(&format!(
                    "{}: velocities do not fit the way to the next frame and are not used; \
                     --velocity-scale {fitting:.3} would fit, or another --fps",
                    earlier.name
                ));
            }
            pairs.push(Some(pair));
        }
        Ok(pairs)
    }
}

fn name(input: &FrameInput, surface: usize) -> String {
    input.files[surface].display().to_string()
}

fn failure(error: BetweenError) -> Failure {
    match error {
        BetweenError::NoIds { .. } => Failure::wrong(error.to_string())
            .with_help("write the particles' ids with them, or leave --slow-motion out"),
        BetweenError::Duplicate { .. } => Failure::work(error.to_string()),
    }
}
