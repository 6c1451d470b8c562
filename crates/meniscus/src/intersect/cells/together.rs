//! Many rays at once: slab of time by slab, sixteen at a time where they are coherent.

use super::packet::{self, Outcome};
use super::{closest_alone, closest_counted, occluded_alone, occluded_counted};
use crate::accel::cells::layout::LANES;
use crate::accel::cells::{Cells, TimedCells};
use crate::frame::Blobs;
use crate::intersect::{BlobHit, Scratch};
use crate::math::ray::Ray;

/// First crossings of object-space rays, in `hits`; rays that lie close together go faster.
pub fn closest_many(
    blobs: &Blobs,
    cells: &TimedCells,
    rays: &[Ray],
    hits: &mut [Option<BlobHit>],
    scratch: &mut Scratch,
) {
    for (rays, hits) in rays.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        slab_by_slab(cells, rays, hits, |cells, rays, hits| {
            closest_few(blobs, cells, rays, hits, scratch);
        });
    }
}

/// Whether object-space rays cross the surface, in `hits`; rays that lie close together go faster.
pub fn occluded_many(
    blobs: &Blobs,
    cells: &TimedCells,
    rays: &[Ray],
    hits: &mut [bool],
    scratch: &mut Scratch,
) {
    for (rays, hits) in rays.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        slab_by_slab(cells, rays, hits, |cells, rays, hits| {
            occluded_few(blobs, cells, rays, hits, scratch);
        });
    }
}

/// Calls `trace` with the cells of each slab of time and those of up to sixteen rays whose times lie in
/// it; answers come back to where the rays were.
fn slab_by_slab<A: Copy>(
    cells: &TimedCells,
    rays: &[Ray],
    answers: &mut [A],
    mut trace: impl FnMut(&Cells, &[Ray], &mut [A]),
) {
    let (Some(&first), Some(&blank)) = (rays.first(), answers.first()) else {
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
        let mut answers_there = [blank; LANES];
        trace(cells_then, &there[..count], &mut answers_there[..count]);
        for (answer, &place) in answers_there.iter().zip(&places[..count]) {
            answers[place] = *answer;
        }
    }
}

/// [`closest_many`] of up to sixteen rays.
fn closest_few(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    hits: &mut [Option<BlobHit>],
    scratch: &mut Scratch,
) {
    if !cells.suit_packets(|| part_of_span(cells, rays)) || !packet::may_be_coherent(rays) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = ray
                .is_traceable()
                .then(|| closest_counted(blobs, cells, ray, scratch))
                .flatten();
        }
        return;
    }
    let outcomes = packet::trace(blobs, cells, rays, false, scratch);
    for ((ray, hit), outcome) in rays.iter().zip(hits).zip(outcomes) {
        *hit = match outcome {
            Outcome::Miss => None,
            Outcome::Hit {
                t,
                outward,
                strongest,
            } => Some(BlobHit {
                t,
                outward: glam::Vec3::from_array(outward).as_dvec3(),
                strongest,
                entering: true,
            }),
            Outcome::Alone => closest_alone(blobs, cells, ray, scratch),
        };
    }
}

/// [`occluded_many`] of up to sixteen rays.
fn occluded_few(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    hits: &mut [bool],
    scratch: &mut Scratch,
) {
    if !cells.suit_packets(|| part_of_span(cells, rays)) || !packet::may_be_coherent(rays) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = ray.is_traceable() && occluded_counted(blobs, cells, ray, scratch);
        }
        return;
    }
    let outcomes = packet::trace(blobs, cells, rays, true, scratch);
    for ((ray, hit), outcome) in rays.iter().zip(hits).zip(outcomes) {
        *hit = match outcome {
            Outcome::Miss => false,
            Outcome::Hit { .. } => true,
            Outcome::Alone => occluded_alone(blobs, cells, ray, scratch),
        };
    }
}

/// What part of the cells' span the times of rays are spread over.
fn part_of_span(cells: &Cells, rays: &[Ray]) -> f32 {
    let phases = rays.iter().map(|ray| cells.phase(ray.time));
    let (first, last) = phases.fold(
        (f32::INFINITY, f32::NEG_INFINITY),
        |(first, last), phase| (first.min(phase), last.max(phase)),
    );
    0.5 * (last - first)
}
