//! Up to sixteen coherent rays at once, with lanes for rays.
//!
//! Rays whose directions agree in sign meet disjoint cells in the same order, so one walk through the
//! tree serves them all, and each blob of a leaf is read once for sixteen rays. A lane that needs
//! more care than stepping offers (a start on the surface that rounding leaves in doubt, a start
//! inside) is handed back to be traced alone.

mod leaf;
mod step;
mod visit;

use crate::accel::cells::Cells;
use crate::accel::cells::layout::LANES;
use crate::accel::cells::traverse::SlabRay;
use crate::frame::Blobs;
use crate::intersect::Scratch;
use crate::intersect::solve::{
    LocalRay, T_TOLERANCE_SPACINGS, near_start, specialised, start_margin,
};
use crate::kernel::KernelShape;
use crate::math::simd::xyz;
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use leaf::{ActiveLanes, Leaf};
use visit::PacketStack;

/// Largest difference of two unit directions of a packet.
const DIRECTION_SPREAD: f64 = 0.1;

/// Largest distance of the places where two rays of a packet enter the cells' box, in spacings.
const ORIGIN_SPREAD_SPACINGS: f64 = 8.0;

/// Fewer rays are traced one by one.
pub(super) const FEWEST: usize = 4;

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
        /// Distance from the start of the traced stretch.
        t: f64,
        /// −∇F there.
        outward: [f32; 3],
        /// The strongest blob there.
        strongest: u32,
    },
    /// It has to be traced alone.
    Alone,
}

/// The rays of a packet, one per lane.
struct Lanes<S: Simd> {
    /// Starts, local, axis by axis.
    origin_f64: [[f64; LANES]; 3],
    /// Unit directions.
    direction_f64: [[f64; LANES]; 3],
    direction: [f32x16<S>; 3],
    /// Starts and inverse directions, for slab tests.
    origin: [f32x16<S>; 3],
    inverse: [f32x16<S>; 3],
    /// Whether the directions' components are negative, alike in all lanes.
    negative: [bool; 3],
    /// Length of the stretches; negative in lanes without a ray.
    length: f32x16<S>,
    /// Lanes whose ray starts at the caller's t_min.
    starts_at_t_min: u32,
    /// Lanes that were seen on the side on which they are said to start.
    on_stated_side: u32,
    /// Lanes whose side the field, not the caller, has told.
    side_is_proven: u32,
}

/// The equation and what is asked.
#[derive(Debug, Clone, Copy)]
struct Job {
    threshold: f32,
    /// Wanted accuracy of a crossing, as a length.
    tolerance: f32,
    /// A leaf entered this close to t_min may hold the start although rounding says otherwise.
    start_margin: f32,
    /// Up to this distance from its own start a ray with a stated side is traced alone.
    near_start: f32,
    /// Only whether there is a crossing is asked for.
    any: bool,
}

/// Traces up to sixteen rays (`None`: misses the cells' box) and says what became of each.
pub(super) fn trace(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Option<LocalRay>],
    any: bool,
    scratch: &mut Scratch,
) -> [Outcome; LANES] {
    let mut outcomes = [Outcome::Miss; LANES];
    for (outcome, ray) in outcomes.iter_mut().zip(rays) {
        if ray.is_some() {
            *outcome = Outcome::Alone;
        }
    }
    let Some(slab_rays) = coherent(rays, f64::from(blobs.field.spacing)) else {
        return outcomes;
    };
    let PacketScratch { active, .. } = &mut scratch.cells.packet;
    active.reserve(cells.largest_leaf);
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || trace_lanes::<_, K, P>(simd, blobs, cells, (rays, &slab_rays), any, scratch, &mut outcomes)
    ));
    outcomes
}

/// The rays as the slab test wants them, where they point the same way from about the same place
/// and travel outside.
fn coherent(rays: &[Option<LocalRay>], spacing: f64) -> Option<[Option<SlabRay>; LANES]> {
    let mut slab_rays = [None; LANES];
    let mut first: Option<(&LocalRay, [bool; 3])> = None;
    let mut count = 0;
    let reach = ORIGIN_SPREAD_SPACINGS * spacing;
    for (slab_ray, ray) in slab_rays.iter_mut().zip(rays) {
        let Some(ray) = ray else { continue };
        if ray.inside {
            continue;
        }
        let slabs = ray.slab_ray();
        let negative = slabs.inverse.map(|inverse| inverse < 0.0);
        let (leader, signs) = *first.get_or_insert((ray, negative));
        let apart = (ray.origin - leader.origin).length_squared();
        let turned = (ray.direction - leader.direction).length_squared();
        if negative != signs
            || turned > DIRECTION_SPREAD * DIRECTION_SPREAD
            || apart > reach * reach
        {
            return None;
        }
        *slab_ray = Some(slabs);
        count += 1;
    }
    (count >= FEWEST).then_some(slab_rays)
}

#[inline(always)]
fn load3<S: Simd>(simd: S, columns: &[[f32; LANES]; 3]) -> [f32x16<S>; 3] {
    xyz(
        #[inline(always)]
        |axis| f32x16::from_slice(simd, &columns[axis]),
    )
}

#[inline(always)]
fn lanes_of<S: Simd>(
    simd: S,
    rays: &[Option<LocalRay>],
    slab_rays: &[Option<SlabRay>; LANES],
) -> (Lanes<S>, u32) {
    let mut origin_f64 = [[0.0; LANES]; 3];
    let mut direction_f64 = [[0.0; LANES]; 3];
    let (mut direction, mut origin) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
    let mut inverse = [[1.0; LANES]; 3];
    let mut length = [-1.0; LANES];
    let (mut present, mut starts_at_t_min, mut side_is_proven) = (0, 0, 0);
    let mut negative = [false; 3];
    for lane in 0..LANES.min(rays.len()) {
        let (Some(ray), Some(slabs)) = (&rays[lane], &slab_rays[lane]) else {
            continue;
        };
        present |= 1 << lane;
        starts_at_t_min |= u32::from(ray.starts_at_t_min) << lane;
        side_is_proven |= u32::from(ray.side_is_proven) << lane;
        for axis in 0..3 {
            origin_f64[axis][lane] = ray.origin[axis];
            direction_f64[axis][lane] = ray.direction[axis];
            direction[axis][lane] = ray.direction[axis] as f32;
            origin[axis][lane] = slabs.origin[axis];
            inverse[axis][lane] = slabs.inverse[axis];
            negative[axis] = slabs.inverse[axis] < 0.0;
        }
        length[lane] = ray.length;
    }
    let lanes = Lanes {
        origin_f64,
        direction_f64,
        direction: load3(simd, &direction),
        origin: load3(simd, &origin),
        inverse: load3(simd, &inverse),
        negative,
        length: f32x16::from_slice(simd, &length),
        starts_at_t_min,
        on_stated_side: side_is_proven & !starts_at_t_min,
        side_is_proven,
    };
    (lanes, present)
}

#[inline(always)]
fn trace_lanes<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    blobs: &Blobs,
    cells: &Cells,
    (rays, slab_rays): (&[Option<LocalRay>], &[Option<SlabRay>; LANES]),
    any: bool,
    scratch: &mut Scratch,
    outcomes: &mut [Outcome; LANES],
) {
    let (mut lanes, present) = lanes_of(simd, rays, slab_rays);
    for (lane, outcome) in outcomes.iter_mut().enumerate() {
        if present >> lane & 1 == 1 {
            *outcome = Outcome::Miss;
        }
    }
    let job = Job {
        threshold: blobs.field.threshold,
        tolerance: T_TOLERANCE_SPACINGS * blobs.field.spacing,
        start_margin: start_margin(cells.bounds),
        near_start: near_start(blobs, cells.bounds),
        any,
    };
    let PacketScratch { stack, active } = &mut scratch.cells.packet;
    let counters = &mut scratch.counters;
    let mut leaves_visited = [0; 2];
    let mut seen_leaf = 0;
    let nodes = visit::visit_leaves(
        simd,
        cells,
        &mut lanes,
        present,
        stack,
        #[inline(always)]
        |lanes, block, mask, near, far| {
            let leaf = Leaf::new::<P>(cells, block);
            let in_leaf = u64::from(mask.count_ones());
            leaves_visited[0] += in_leaf;
            leaves_visited[1] += in_leaf * leaf.count as u64;
            leaf.trace::<S, K, P>(
                simd,
                &job,
                lanes,
                active,
                (mask, near, far),
                &mut seen_leaf,
                outcomes,
            )
        },
    );
    counters.nodes += nodes;
    counters.leaves += leaves_visited[0];
    counters.blob_evaluations += leaves_visited[1];
}
