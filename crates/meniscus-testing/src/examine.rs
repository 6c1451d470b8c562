//! Sends rays through an engine, has every answer judged, and counts.

use crate::excuse::{self, Fault, Reason, Verdict};
use crate::oracle::Oracle;
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, Crossing, Scratch};
use meniscus::math::ray::Ray;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::{self, Display};

/// Rays per task.
const CHUNK: usize = 512;
/// Real errors kept with all their numbers.
const KEPT: usize = 5;

/// Whatever answers rays: an engine, or one that is wrong on purpose.
pub trait Tracer: Sync {
    /// First crossing.
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit>;
    /// Whether there is a crossing.
    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool;
    /// Every crossing, in order.
    fn crossings(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<Crossing>;

    /// First crossings of many rays.
    fn closest_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Option<BlobHit>> {
        rays.iter().map(|ray| self.closest(ray, scratch)).collect()
    }

    /// Whether each of many rays has a crossing.
    fn occluded_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<bool> {
        rays.iter().map(|ray| self.occluded(ray, scratch)).collect()
    }

    /// Every crossing of many rays.
    fn crossings_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Vec<Crossing>> {
        let crossings = rays.iter().map(|ray| self.crossings(ray, scratch));
        crossings.collect()
    }
}

impl Tracer for Blobs {
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        self.closest(ray, scratch)
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.occluded(ray, scratch)
    }

    fn crossings(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<Crossing> {
        let mut found = Vec::new();
        self.crossings(ray, scratch, &mut found);
        found
    }

    fn closest_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Option<BlobHit>> {
        let mut hits = vec![None; rays.len()];
        self.closest_many(rays, &mut hits, scratch);
        hits
    }

    fn occluded_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<bool> {
        let mut hits = vec![false; rays.len()];
        self.occluded_many(rays, &mut hits, scratch);
        hits
    }
}

/// What is asked about each ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Question {
    /// The first crossing.
    Closest,
    /// The same, of many rays at once.
    ClosestTogether,
    /// Whether there is any.
    Any,
    /// The same, of many rays at once.
    AnyTogether,
    /// All of them.
    All,
    /// The same, of many rays at once.
    AllTogether,
}

/// What came out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Rays asked about.
    pub rays: usize,
    /// Rays with at least one crossing.
    pub hits: usize,
    /// Excused differences by reason.
    pub excused: BTreeMap<String, usize>,
    /// Largest |F − T| of an excused difference.
    pub largest_excused: f64,
    /// Real errors by fault.
    pub wrong: BTreeMap<String, usize>,
    /// The first few, with everything that is needed to repeat them.
    pub examples: Vec<String>,
}

impl Tally {
    /// Number of real errors.
    pub fn real_errors(&self) -> usize {
        self.wrong.values().sum()
    }

    /// Number of excused differences.
    pub fn excused_differences(&self) -> usize {
        self.excused.values().sum()
    }

    /// Adds what another part of the rays gave.
    pub fn merge(mut self, other: Self) -> Self {
        self.rays += other.rays;
        self.hits += other.hits;
        for (reason, count) in other.excused {
            *self.excused.entry(reason).or_default() += count;
        }
        for (fault, count) in other.wrong {
            *self.wrong.entry(fault).or_default() += count;
        }
        self.largest_excused = self.largest_excused.max(other.largest_excused);
        self.examples.extend(other.examples);
        self.examples.truncate(KEPT);
        self
    }

    fn count(&mut self, verdict: Verdict, example: impl FnOnce(Fault) -> String) {
        let name = |reason: Reason| format!("{reason:?}");
        match verdict {
            Verdict::Match => {}
            Verdict::Excused { reason, magnitude } => {
                *self.excused.entry(name(reason)).or_default() += 1;
                self.largest_excused = self.largest_excused.max(magnitude);
            }
            Verdict::Wrong(fault) => {
                *self.wrong.entry(format!("{fault:?}")).or_default() += 1;
                if self.examples.len() < KEPT {
                    self.examples.push(example(fault));
                }
            }
        }
    }
}

impl Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} rays, {} hits, excused {:?} (|F - T| up to {:.1e}), real errors {:?}",
            self.rays, self.hits, self.excused, self.largest_excused, self.wrong
        )?;
        self.examples
            .iter()
            .try_for_each(|line| write!(f, "\n  {line}"))
    }
}

/// Asks `tracer` about every ray and judges the answers, on all threads.
pub fn examine(tracer: &impl Tracer, oracle: &Oracle, rays: &[Ray], question: Question) -> Tally {
    let parts: Vec<Tally> = rays
        .par_chunks(CHUNK)
        .map(|rays| examine_part(tracer, oracle, rays, question))
        .collect();
    parts.into_iter().fold(Tally::default(), Tally::merge)
}

fn examine_part(tracer: &impl Tracer, oracle: &Oracle, rays: &[Ray], question: Question) -> Tally {
    let mut tally = Tally {
        rays: rays.len(),
        ..Tally::default()
    };
    let mut scratch = Scratch::default();
    let (mut closest, mut any, mut all) = (Vec::new(), Vec::new(), Vec::new());
    match question {
        Question::ClosestTogether => closest = tracer.closest_many(rays, &mut scratch),
        Question::AnyTogether => any = tracer.occluded_many(rays, &mut scratch),
        Question::AllTogether => all = tracer.crossings_many(rays, &mut scratch),
        Question::Closest | Question::Any | Question::All => {}
    }
    for (i, ray) in rays.iter().enumerate() {
        match question {
            Question::Closest | Question::ClosestTogether => {
                let answer = match question {
                    Question::Closest => tracer.closest(ray, &mut scratch),
                    _ => closest[i],
                };
                tally.hits += usize::from(answer.is_some());
                let verdict = excuse::judge_closest(oracle, ray, answer.as_ref());
                tally.count(verdict, |fault| {
                    let expected = oracle.first(ray, None);
                    format!("{fault:?}: {ray:?} gave {answer:?}, expected {expected:?}")
                });
            }
            Question::Any | Question::AnyTogether => {
                let answer = match question {
                    Question::Any => tracer.occluded(ray, &mut scratch),
                    _ => any[i],
                };
                tally.hits += usize::from(answer);
                let verdict = excuse::judge_occluded(oracle, ray, answer);
                tally.count(verdict, |fault| {
                    let expected = oracle.first(ray, None);
                    format!("{fault:?}: {ray:?} gave {answer}, expected {expected:?}")
                });
            }
            Question::All | Question::AllTogether => {
                let answer = match question {
                    Question::All => tracer.crossings(ray, &mut scratch),
                    _ => std::mem::take(&mut all[i]),
                };
                tally.hits += usize::from(!answer.is_empty());
                let verdict = excuse::judge_crossings(oracle, ray, &answer);
                tally.count(verdict, |fault| {
                    let expected = oracle.crossings(ray);
                    format!("{fault:?}: {ray:?} gave {answer:?}, expected {expected:?}")
                });
            }
        }
    }
    tally
}
