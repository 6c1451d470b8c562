//! Up to sixteen coherent rays at once, with lanes for rays.
//!
//! Rays whose directions agree in sign meet disjoint cells in the same order, so one walk through the
//! tree serves them all, and each blob of a leaf is read once for sixteen rays. Where blobs
//! move each lane has a time of its own. A lane that needs more care than stepping offers (a start on
//! the surface that rounding leaves in doubt, a start inside) is handed back to be traced alone.

mod cull;
mod few;
mod gather;
mod gradient;
mod leaf;
mod step;
mod visit;

use super::prepare::Prepared;
use super::{CellsScratch, LeafView};
use crate::accel::cells::Cells;
use crate::accel::cells::layout::LANES;
use crate::frame::Blobs;
use crate::intersect::Scratch;
use crate::intersect::solve::{T_TOLERANCE_SPACINGS, near_start, specialised, start_margin};
use crate::kernel::KernelShape;
use crate::math::ray::Ray;
use crate::math::simd::xyz;
use crate::primitive::Primitive;
use cull::Frame;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use gather::{ActiveLanes, Alike};
use visit::PacketStack;

/// Largest difference of two unit directions of a packet, in each coordinate.
const DIRECTION_SPREAD: f64 = 0.06;

/// Largest distance of the places where two rays of a packet enter the cells' box, in spacings and in
/// each coordinate.
const ORIGIN_SPREAD_SPACINGS: f64 = 8.0;

/// Fewer rays are traced one by one.
const FEWEST: usize = 4;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub(super) struct PacketScratch {
    stack: PacketStack,
    active: ActiveLanes,
}

/// What became of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outcome {
    /// It crosses nothing.
    Miss,
    /// Its first crossing.
    Hit {
        /// The distance along the local ray; not found out where any crossing does.
        t: f64,
        /// −∇F there; likewise.
        outward: [f32; 3],
        /// The strongest blob there; likewise.
        strongest: u32,
    },
    /// It has to be traced alone.
    Alone,
}

/// The rays of a packet, one per lane.
struct Lanes<'a, S: Simd> {
    /// The same in f64.
    prepared: &'a Prepared,
    direction: [f32x16<S>; 3],
    frame: Frame<S>,
    /// Starts and inverse directions, for slab tests, and −start times inverse direction.
    origin: [f32x16<S>; 3],
    inverse: [f32x16<S>; 3],
    shift: [f32x16<S>; 3],
    /// Whether the directions' components are negative, alike in all lanes.
    negative: [bool; 3],
    /// Length of the stretches; negative in lanes without a ray.
    length: f32x16<S>,
    /// Times within the shutter, from −1 to 1, and how far apart they are.
    phase: f32x16<S>,
    phases: [f32; 2],
    /// Lanes that were seen on the side on which they are said to start.
    on_stated_side: u32,
}

/// The equation and what is asked.
#[derive(Debug, Clone, Copy)]
struct Job {
    /// What the blobs have in common.
    alike: Alike,
    /// In weights of blobs that are alike.
    threshold: f32,
    /// Wanted accuracy of a crossing, as a length along the ray; in radii of blobs that are alike.
    tolerance: f32,
    /// A leaf entered this close to t_min may hold the start although rounding says otherwise.
    start_margin: f32,
    /// Up to this distance from its own start a ray with a stated side is traced alone.
    near_start: f32,
    /// Only whether there is a crossing is asked for.
    any: bool,
}

/// Whether some rays point the same way at about the same time, so that it may pay to look for groups.
/// Those that start a bounce in all directions are told apart here, for less than that costs.
pub(super) fn may_be_coherent(cells: &Cells, rays: &[Ray]) -> bool {
    let apart = cells.phases_together();
    [0, rays.len() / 2].into_iter().any(|leader| {
        let Some(leader) = rays.get(leader) else {
            return false;
        };
        let spread = DIRECTION_SPREAD * leader.direction.abs().max_element() * 2.0;
        let phase = cells.phase(leader.time);
        let alike = |ray: &&Ray| {
            (ray.direction - leader.direction).abs().max_element() <= spread
                && (cells.phase(ray.time) - phase).abs() <= apart
        };
        rays.iter().filter(alike).count() >= FEWEST
    })
}

/// Traces the rays that go together and says what became of each.
pub(super) fn trace(
    blobs: &Blobs,
    cells: &Cells,
    prepared: &Prepared,
    any: bool,
    scratch: &mut Scratch,
) -> [Outcome; LANES] {
    let mut outcomes = [Outcome::Miss; LANES];
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || trace_groups::<_, K, P>(simd, blobs, cells, prepared, any, scratch, &mut outcomes)
    ));
    outcomes
}

/// Traces together what points the same way from about the same place.
#[inline(always)]
fn trace_groups<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    blobs: &Blobs,
    cells: &Cells,
    prepared: &Prepared,
    any: bool,
    scratch: &mut Scratch,
    outcomes: &mut [Outcome; LANES],
) {
    let alike = Alike::of::<P>(cells.stored());
    let job = Job {
        alike,
        threshold: blobs.field.threshold / alike.weight,
        tolerance: T_TOLERANCE_SPACINGS * blobs.field.spacing * alike.per_radius,
        start_margin: start_margin(cells.bounds),
        near_start: near_start(blobs, cells.bounds),
        any,
    };
    let reach = ORIGIN_SPREAD_SPACINGS * f64::from(blobs.field.spacing);
    for (lane, outcome) in outcomes.iter_mut().enumerate() {
        if prepared.present >> lane & 1 == 1 {
            *outcome = Outcome::Alone;
        }
    }
    let mut rest = prepared.present & !prepared.inside;
    while rest.count_ones() as usize >= FEWEST {
        let leader = rest.trailing_zeros() as usize % LANES;
        let group = prepared.alike(rest, leader, reach, DIRECTION_SPREAD)
            & prepared.near_in_time(leader, cells.phases_together())
            | 1 << leader;
        rest &= !group;
        if group.count_ones() as usize >= FEWEST {
            let work = (prepared, group);
            if cells.stored().moves() {
                trace_group::<S, K, P, true>(simd, (blobs, cells), &job, work, scratch, outcomes);
            } else {
                trace_group::<S, K, P, false>(simd, (blobs, cells), &job, work, scratch, outcomes);
            }
        }
    }
}

#[inline(always)]
fn load3<S: Simd>(simd: S, columns: &[[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    xyz(
        #[inline(always)]
        |axis| f32x16::from_slice(simd, &columns[axis]),
    )
}

#[inline(always)]
fn trace_group<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
    simd: S,
    (blobs, cells): (&Blobs, &Cells),
    job: &Job,
    (prepared, group): (&Prepared, u32),
    scratch: &mut Scratch,
    outcomes: &mut [Outcome; LANES],
) {
    let mut origin = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            origin[axis][lane] = prepared.origin[axis][lane] as f32;
        }
    }
    let mut length = [-1.0; LANES];
    for lane in 0..LANES {
        if group >> lane & 1 == 1 {
            length[lane] = prepared.length[lane];
            outcomes[lane] = Outcome::Miss;
        }
    }
    let leader = group.trailing_zeros() as usize % LANES;
    let origin = load3(simd, &origin);
    let inverse = load3(simd, &prepared.inverse);
    let direction = load3(simd, &prepared.direction_f32);
    let middle = xyz(
        #[inline(always)]
        |axis| prepared.direction_f32[axis][leader],
    );
    let mut lanes = Lanes {
        prepared,
        direction,
        frame: Frame::new(simd, direction, middle),
        origin,
        inverse,
        shift: xyz(
            #[inline(always)]
            |axis| -origin[axis] * inverse[axis],
        ),
        negative: [
            prepared.inverse[0][leader] < 0.0,
            prepared.inverse[1][leader] < 0.0,
            prepared.inverse[2][leader] < 0.0,
        ],
        length: f32x16::from_slice(simd, &length),
        phase: f32x16::from_slice(simd, &prepared.phase),
        phases: prepared.phases(group),
        on_stated_side: prepared.side_is_proven & !prepared.starts_at_t_min,
    };
    let CellsScratch {
        packet: PacketScratch { stack, active },
        unpacked,
        ..
    } = &mut scratch.cells;
    let counters = &mut scratch.counters;
    let mut leaves_visited = [0; 2];
    let mut seen_leaf = 0;
    let nodes = visit::visit_leaves::<_, MOVES>(
        simd,
        cells,
        &mut lanes,
        group,
        stack,
        #[inline(always)]
        |within, index| cells.part::<S, K, P>(simd, &blobs.field, within, index),
        #[inline(always)]
        |lanes, part, block, mask, near, far| {
            let leaf = LeafView::new::<P>(&blobs.field, cells, (part, block), unpacked);
            let in_leaf = u64::from(mask.count_ones());
            leaves_visited[0] += in_leaf;
            leaves_visited[1] += in_leaf * leaf.header.count as u64;
            let there = (mask, near, far);
            if !P::BETA_TURNS && job.alike.are {
                leaf.trace::<S, K, P, MOVES, true>(
                    simd,
                    job,
                    lanes,
                    active,
                    there,
                    &mut seen_leaf,
                    outcomes,
                )
            } else {
                leaf.trace::<S, K, P, MOVES, false>(
                    simd,
                    job,
                    lanes,
                    active,
                    there,
                    &mut seen_leaf,
                    outcomes,
                )
            }
        },
    );
    counters.nodes += nodes;
    counters.leaves += leaves_visited[0];
    counters.blob_evaluations += leaves_visited[1];
}
