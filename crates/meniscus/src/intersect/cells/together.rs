//! Many rays at once: slab of time by slab, sixteen at a time where they are coherent.

use super::packet::{self, Outcome};
use super::{closest_alone, occluded_alone};
use crate::accel::cells::layout::LANES;
use crate::accel::cells::{Cells, TimedCells};
use crate::frame::Blobs;
use crate::intersect::{BlobHit, Scratch};
use crate::math::ray::Ray;

/// What is asked of each ray.
pub trait Answer: Copy {
    /// Whether any crossing will do.
    const ANY: bool;
    /// There is none.
    const NONE: Self;

    /// What a packet found.
    fn of_hit(t: f64, outward: [f32; 3], strongest: u32) -> Self;

    /// Of a traceable ray by itself.
    fn alone(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> Self;
}

/// The first crossing.
impl Answer for Option<BlobHit> {
    const ANY: bool = false;
    const NONE: Self = None;

    #[inline(always)]
    fn of_hit(t: f64, outward: [f32; 3], strongest: u32) -> Self {
        Some(BlobHit {
            t,
            outward: glam::Vec3::from_array(outward).as_dvec3(),
            strongest,
            entering: true,
        })
    }

    fn alone(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> Self {
        closest_alone(blobs, cells, ray, scratch)
    }
}

/// Whether there is a crossing.
impl Answer for bool {
    const ANY: bool = true;
    const NONE: Self = false;

    #[inline(always)]
    fn of_hit(_: f64, _: [f32; 3], _: u32) -> Self {
        true
    }

    fn alone(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> Self {
        occluded_alone(blobs, cells, ray, scratch)
    }
}

/// Answers for object-space rays; those that lie close together and follow each other go faster.
pub fn answer_many<A: Answer>(
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
    if !packet::may_be_coherent(cells, rays) {
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = if ray.is_traceable() {
                scratch.counters.rays += 1;
                A::alone(blobs, cells, ray, scratch)
            } else {
                A::NONE
            };
        }
        return;
    }
    let outcomes = packet::trace(blobs, cells, rays, A::ANY, scratch);
    for ((ray, answer), outcome) in rays.iter().zip(answers).zip(outcomes) {
        *answer = match outcome {
            Outcome::Miss => A::NONE,
            Outcome::Hit {
                t,
                outward,
                strongest,
            } => A::of_hit(t, outward, strongest),
            Outcome::Alone => A::alone(blobs, cells, ray, scratch),
        };
    }
}
