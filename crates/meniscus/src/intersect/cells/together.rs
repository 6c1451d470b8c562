//! Many rays at once: slab of time by slab, sixteen at a time where they are coherent.

use super::{alone, packet};
use crate::accel::cells::layout::LANES;
use crate::accel::cells::{Cells, TimedCells};
use crate::frame::Blobs;
use crate::intersect::solve::{LocalRay, Question, local_ray};
use crate::intersect::{BlobHit, Scratch, sweep};
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;

/// Fewer rays are clipped one by one.
const FEWEST_PREPARED: usize = 3;

/// What is asked of each ray.
pub(in crate::intersect) trait Answer: Copy {
    /// Whether the first crossing is wanted, or any.
    const QUESTION: Question;
    /// There is none.
    const NONE: Self;

    /// There is this one.
    fn of(hit: BlobHit) -> Self;

    /// By engine `sweep`.
    fn by_sweep(blobs: &Blobs, ray: &Ray, scratch: &mut Scratch) -> Self;
}

/// The first crossing.
impl Answer for Option<BlobHit> {
    const QUESTION: Question = Question::First;
    const NONE: Self = None;

    #[inline(always)]
    fn of(hit: BlobHit) -> Self {
        Some(hit)
    }

    fn by_sweep(blobs: &Blobs, ray: &Ray, scratch: &mut Scratch) -> Self {
        sweep::first(blobs, blobs.exact_tree(), ray, scratch)
    }
}

/// Whether there is a crossing.
impl Answer for bool {
    const QUESTION: Question = Question::Any;
    const NONE: Self = false;

    #[inline(always)]
    fn of(_: BlobHit) -> Self {
        true
    }

    fn by_sweep(blobs: &Blobs, ray: &Ray, scratch: &mut Scratch) -> Self {
        sweep::first(blobs, blobs.exact_tree(), ray, scratch).is_some()
    }
}

/// The answer for one object-space ray.
pub(super) fn answer<A: Answer>(
    blobs: &Blobs,
    cells: &Cells,
    ray: &Ray,
    scratch: &mut Scratch,
) -> A {
    let mut answers = [A::NONE];
    answer_few(
        blobs,
        cells,
        std::slice::from_ref(ray),
        &mut answers,
        scratch,
    );
    answers[0]
}

/// Answers for object-space rays; those that lie close together and follow each other go faster.
pub(in crate::intersect) fn answer_many<A: Answer>(
    blobs: &Blobs,
    cells: &TimedCells,
    rays: &[Ray],
    answers: &mut [A],
    scratch: &mut Scratch,
) {
    for (rays, answers) in rays.chunks(LANES).zip(answers.chunks_mut(LANES)) {
        slab_by_slab(cells, rays, answers, |cells, rays, answers| {
            answer_few(blobs, cells, rays, answers, scratch);
        });
    }
}

/// Calls `trace` with the cells of each slab of time and those of up to sixteen rays whose times lie in
/// it; answers come back to where the rays were.
fn slab_by_slab<A: Answer>(
    cells: &TimedCells,
    rays: &[Ray],
    answers: &mut [A],
    mut trace: impl FnMut(&Cells, &[Ray], &mut [A]),
) {
    let Some(&first) = rays.first() else {
        return;
    };
    let slab = cells.slab_at(first.time);
    if rays.iter().all(|ray| cells.slab_at(ray.time) == slab) {
        return trace(&cells.slabs()[slab], rays, answers);
    }
    for (slab, cells_then) in cells.slabs().iter().enumerate() {
        let mut there = [first; LANES];
        let mut places = [0; LANES];
        let mut count = 0;
        for (place, ray) in rays.iter().enumerate() {
            if cells.slab_at(ray.time) == slab {
                (there[count], places[count]) = (*ray, place);
                count += 1;
            }
        }
        let mut answers_there = [A::NONE; LANES];
        trace(cells_then, &there[..count], &mut answers_there[..count]);
        for (answer, &place) in answers_there.iter().zip(&places[..count]) {
            answers[place] = *answer;
        }
    }
}

/// [`answer_many`] for up to sixteen rays.
fn answer_few<A: Answer>(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    answers: &mut [A],
    scratch: &mut Scratch,
) {
    answers.fill(A::NONE);
    let Some(bounds) = &cells.bounds else {
        scratch.counters.rays += rays.iter().filter(|ray| ray.is_traceable()).count() as u64;
        return;
    };
    let mut alone = std::mem::take(&mut scratch.cells.alone);
    alone.clear();
    if rays.len() < FEWEST_PREPARED {
        for (lane, ray) in rays.iter().enumerate() {
            if ray.is_traceable() {
                scratch.counters.rays += 1;
                let local = local_ray(blobs, cells.bounds, ray);
                alone.extend(local.map(|local| (lane, local)));
            }
        }
    } else {
        answer_coherent(blobs, (cells, bounds), rays, answers, scratch, &mut alone);
    }
    if !alone.is_empty() {
        answer_alone(blobs, cells, (rays, &alone), answers, scratch);
    }
    scratch.cells.alone = alone;
}

/// Answers for the rays of up to sixteen that go together; the others, each with its place, go to `alone`.
fn answer_coherent<A: Answer>(
    blobs: &Blobs,
    (cells, bounds): (&Cells, &Aabb),
    rays: &[Ray],
    answers: &mut [A],
    scratch: &mut Scratch,
    alone: &mut Vec<(usize, LocalRay)>,
) {
    let mut prepared = scratch.cells.prepared.take().unwrap_or_default();
    prepared.fill(blobs, cells, bounds, rays);
    scratch.counters.rays += prepared.traceable;
    let outcomes = if packet::may_be_coherent(cells, rays) {
        let any = A::QUESTION == Question::Any;
        packet::trace(blobs, cells, &prepared, any, scratch)
    } else {
        [packet::Outcome::Alone; LANES]
    };
    for (lane, (answer, outcome)) in answers.iter_mut().zip(outcomes).enumerate() {
        match outcome {
            packet::Outcome::Miss => {}
            packet::Outcome::Hit {
                t,
                outward,
                strongest,
            } => {
                *answer = A::of(BlobHit {
                    t: prepared.parameter(&rays[lane], lane, t),
                    outward: glam::Vec3::from_array(outward).as_dvec3(),
                    strongest,
                    entering: true,
                });
            }
            packet::Outcome::Alone if prepared.present >> lane & 1 == 1 => {
                alone.push((lane, prepared.local(lane)));
            }
            packet::Outcome::Alone => {}
        }
    }
    scratch.cells.prepared = Some(prepared);
}

/// Answers for rays one by one.
fn answer_alone<A: Answer>(
    blobs: &Blobs,
    cells: &Cells,
    (rays, alone): (&[Ray], &[(usize, LocalRay)]),
    answers: &mut [A],
    scratch: &mut Scratch,
) {
    let mut beyond_f32 = 0_u32;
    let asked = (alone, A::QUESTION);
    alone::trace(
        blobs,
        cells,
        asked,
        scratch,
        &mut |(lane, local), outcome| match outcome {
            alone::Outcome::Miss => {}
            alone::Outcome::Hit(hit) => {
                let t = local.parameter(&rays[*lane], hit.t);
                answers[*lane] = A::of(BlobHit { t, ..hit });
            }
            alone::Outcome::BeyondF32 => beyond_f32 |= 1 << lane,
        },
    );
    for (lane, ray) in rays.iter().enumerate() {
        if beyond_f32 >> lane & 1 == 1 {
            answers[lane] = A::by_sweep(blobs, ray, scratch);
        }
    }
}
