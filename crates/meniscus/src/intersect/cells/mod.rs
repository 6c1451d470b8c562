//! Engine `cells`: visits the pierced leaves in order; in each gathers the blobs that the segment
//! meets and solves for the first change of side.

pub(super) mod gather;
pub(super) mod gradient;
pub(super) mod local;
mod packet;
mod solve;
mod start;

use super::{BlobHit, Scratch, sweep};
use crate::accel::cells::Cells;
use crate::accel::cells::layout::{Block, LANES, LeafHeader, blocks_per_chunk};
use crate::accel::cells::traverse::{Stack, visit_leaves};
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::ray::{Ray, Side};
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use crate::{at_level, with_kernel};
use fearless_simd::Simd;
use gather::{Active, gather};
use glam::DVec3;
use local::{LocalRay, local_ray};
use packet::{Outcome, PacketScratch};
use solve::{Entry, Pending, Segment, Solver, Verdict};
use start::{OwnStart, is_inside, start_margin};

/// Accuracy of t that the solver aims at, in spacings.
const T_TOLERANCE_SPACINGS: f32 = 2e-5;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct CellsScratch {
    stack: Stack,
    active: Active,
    pending: Pending,
    packet: PacketScratch,
}

/// What a search ended with, in the engine's own terms.
enum Found {
    /// The first crossing.
    Crossing { t: f64, block: u32, entering: bool },
    /// The ray meets blobs too small for f32: engine `sweep` has to look.
    BeyondF32,
}

/// First crossings of object-space rays, in `hits`; rays that lie close together go faster.
pub fn closest_many(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    hits: &mut [Option<BlobHit>],
    scratch: &mut Scratch,
) {
    if rays.len() < packet::FEWEST {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = ray
                .is_traceable()
                .then(|| closest(blobs, cells, ray, scratch))
                .flatten();
        }
        return;
    }
    for (rays, hits) in rays.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        let (local, outcomes) = trace_packet(blobs, cells, rays, false, scratch);
        for (lane, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            *hit = match (outcomes[lane], &local[lane]) {
                (
                    Outcome::Hit {
                        t,
                        outward,
                        strongest,
                    },
                    Some(local),
                ) => Some(BlobHit {
                    t: local.parameter(ray, t),
                    outward: glam::Vec3::from_array(outward).as_dvec3(),
                    strongest,
                    entering: true,
                }),
                (Outcome::Alone, Some(local)) => closest_alone(blobs, cells, ray, local, scratch),
                _ => None,
            };
        }
    }
}

/// Whether object-space rays cross the surface, in `hits`; rays that lie close together go faster.
pub fn occluded_many(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    hits: &mut [bool],
    scratch: &mut Scratch,
) {
    if rays.len() < packet::FEWEST {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = ray.is_traceable() && occluded(blobs, cells, ray, scratch);
        }
        return;
    }
    for (rays, hits) in rays.chunks(LANES).zip(hits.chunks_mut(LANES)) {
        let (local, outcomes) = trace_packet(blobs, cells, rays, true, scratch);
        for (lane, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            *hit = match (outcomes[lane], &local[lane]) {
                (Outcome::Hit { .. }, _) => true,
                (Outcome::Alone, Some(local)) => occluded_alone(blobs, cells, ray, local, scratch),
                _ => false,
            };
        }
    }
}

fn trace_packet(
    blobs: &Blobs,
    cells: &Cells,
    rays: &[Ray],
    any: bool,
    scratch: &mut Scratch,
) -> ([Option<LocalRay>; LANES], [Outcome; LANES]) {
    let mut local = [None; LANES];
    for (local, ray) in local.iter_mut().zip(rays) {
        if ray.is_traceable() {
            scratch.counters.rays += 1;
            *local = local_ray(blobs, cells, ray);
        }
    }
    let outcomes = packet::trace(blobs, cells, &local, any, scratch);
    (local, outcomes)
}

/// First crossing of a traceable object-space ray.
pub fn closest(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
    scratch.counters.rays += 1;
    let local = local_ray(blobs, cells, ray)?;
    closest_alone(blobs, cells, ray, &local, scratch)
}

fn closest_alone(
    blobs: &Blobs,
    cells: &Cells,
    ray: &Ray,
    local: &LocalRay,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    match find(blobs, cells, ray, local, Question::First, scratch)? {
        Found::BeyondF32 => sweep::first(blobs, blobs.exact_tree(), ray, scratch),
        Found::Crossing { t, block, entering } => {
            let at = ray.at(t) - blobs.field.origin;
            let (outward, strongest) = gradient_at(blobs, cells, block, at);
            Some(BlobHit {
                t,
                outward,
                strongest,
                entering,
            })
        }
    }
}

/// Whether a traceable object-space ray has a crossing.
pub fn occluded(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> bool {
    scratch.counters.rays += 1;
    local_ray(blobs, cells, ray)
        .is_some_and(|local| occluded_alone(blobs, cells, ray, &local, scratch))
}

fn occluded_alone(
    blobs: &Blobs,
    cells: &Cells,
    ray: &Ray,
    local: &LocalRay,
    scratch: &mut Scratch,
) -> bool {
    match find(blobs, cells, ray, local, Question::Any, scratch) {
        None => false,
        Some(Found::Crossing { .. }) => true,
        Some(Found::BeyondF32) => sweep::first(blobs, blobs.exact_tree(), ray, scratch).is_some(),
    }
}

/// What is asked of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    /// Where the first crossing is.
    First,
    /// Whether there is one.
    Any,
}

/// Runs `$body` with the field's kernel, primitive and SIMD token as types: the one dispatch.
macro_rules! specialised {
    ($blobs:expr, $simd:ident, $kernel:ident, $primitive:ident => $body:expr) => {
        match &$blobs.field.shapes {
            Shapes::Balls(_) => with_kernel!($blobs.field.kernel, $kernel => {
                type $primitive = Ball;
                at_level!($blobs.level, $simd => $body)
            }),
            Shapes::Ellipsoids(_) => with_kernel!($blobs.field.kernel, $kernel => {
                type $primitive = Ellipsoid;
                at_level!($blobs.level, $simd => $body)
            }),
        }
    };
}

pub(super) use specialised;

fn find(
    blobs: &Blobs,
    cells: &Cells,
    ray: &Ray,
    local: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    scratch.cells.active.reserve(cells.largest_leaf);
    let mut found = specialised!(blobs, simd, K, P => {
        find_in_cells::<_, K, P>(simd, blobs, cells, local, question, scratch)
    })?;
    if let Found::Crossing { t, .. } = &mut found {
        *t = local.parameter(ray, *t);
    }
    Some(found)
}

#[inline(always)]
fn find_in_cells<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    blobs: &Blobs,
    cells: &Cells,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    let slab_ray = ray.slab_ray();
    let CellsScratch {
        stack,
        active,
        pending,
        ..
    } = &mut scratch.cells;
    let counters = &mut scratch.counters;
    let direction = ray.direction.as_vec3().to_array();
    let tolerance = T_TOLERANCE_SPACINGS * blobs.field.spacing;
    let mut solver = Solver {
        threshold: blobs.field.threshold,
        inside: ray.inside,
        tolerance,
    };
    let start_margin = start_margin(cells);
    let start = OwnStart::new(blobs, cells, ray);
    // Whether the ray is known to have been on the side that it is said to start on.
    let mut on_stated_side = ray.side_is_proven && !ray.starts_at_t_min;
    let mut first_leaf = true;
    let mut found = None;
    let nodes = simd.vectorize(
        #[inline(always)]
        || {
            visit_leaves(
                simd,
                cells,
                &slab_ray,
                stack,
                #[inline(always)]
                |block, near, far| {
                    counters.leaves += 1;
                    if first_leaf && near > start_margin && !on_stated_side {
                        // The ray starts in a dropped cell, all of which lies on one side.
                        on_stated_side = ray.side_is_proven
                            || (blobs.field.side(ray.origin) == Side::Inside) == ray.inside;
                    }
                    first_leaf = false;
                    let header = LeafHeader::from_block(&cells.blocks[block as usize]);
                    counters.blob_evaluations += header.count as u64;
                    let center = glam::Vec3::from_array(header.center).as_dvec3();
                    let origin = (ray.origin + ray.direction * f64::from(near) - center).as_vec3();
                    let chunks = leaf_chunks::<P>(&cells.blocks, block, header.count);
                    if header.fine_beta < f32::INFINITY
                        && meets_fine::<P>(blobs, chunks, &header, ray)
                    {
                        found = Some(Found::BeyondF32);
                        return true;
                    }
                    let length = far - near;
                    let reach = gather::<S, K, P>(
                        simd,
                        chunks,
                        origin.to_array(),
                        direction,
                        length,
                        active,
                    );
                    if !solver.inside && reach < solver.threshold {
                        on_stated_side = true;
                        return false;
                    }
                    let away_from_start = near > start_margin || !ray.starts_at_t_min;
                    let entry = if ray.side_is_proven || (on_stated_side && away_from_start) {
                        Entry::Confirmed
                    } else if away_from_start {
                        Entry::Returning
                    } else {
                        Entry::Unconfirmed
                    };
                    if question == Question::Any && f64::from(near) > start.reach {
                        // That there is a crossing is enough.
                        solver.tolerance = f32::INFINITY;
                    }
                    let mut segment = Segment {
                        from: 0.0,
                        length,
                        entry,
                    };
                    let mut stride = start.stride;
                    loop {
                        let crossing =
                            match solver.first_crossing::<S, K>(simd, active, pending, segment) {
                                Verdict::Crossing(s) => s,
                                Verdict::Unclear => segment.from,
                                Verdict::StaysOnSide => {
                                    on_stated_side = true;
                                    return false;
                                }
                                Verdict::NeverOnSide => return false,
                            };
                        let t = f64::from(near) + f64::from(crossing);
                        if start.is_sure(blobs, ray, t) {
                            found = Some(Found::Crossing {
                                t,
                                block,
                                entering: !solver.inside,
                            });
                            return true;
                        }
                        segment.from = crossing + stride;
                        stride *= 2.0;
                        on_stated_side =
                            is_inside(blobs, ray, f64::from(near) + f64::from(segment.from))
                                == ray.inside;
                        if segment.from >= length {
                            return false;
                        }
                        segment.entry = if on_stated_side {
                            Entry::Confirmed
                        } else {
                            Entry::Returning
                        };
                    }
                },
            )
        },
    );
    counters.nodes += nodes;
    found
}

/// The blobs of the leaf at `block`, chunk after chunk.
#[inline(always)]
fn leaf_chunks<P: Primitive>(blocks: &[Block], block: u32, count: usize) -> &[Block] {
    let first = block as usize + 1;
    &blocks[first..first + count.div_ceil(LANES) * blocks_per_chunk(P::COLUMNS)]
}

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
fn meets_fine<P: Primitive>(
    blobs: &Blobs,
    chunks: &[Block],
    header: &LeafHeader,
    ray: &LocalRay,
) -> bool {
    let field = &blobs.field;
    let indices = chunks
        .chunks_exact(blocks_per_chunk(P::COLUMNS))
        .flat_map(|chunk| {
            chunk[4 + P::COLUMNS]
                .0
                .map(|index| index.to_bits() as usize)
        });
    indices.take(header.count).any(|i| {
        let v = field.shapes.transform(i, ray.direction);
        let beta = v.length_squared();
        if beta < f64::from(header.fine_beta) {
            return false;
        }
        let y = field
            .shapes
            .transform(i, ray.origin - field.center(i).as_dvec3());
        let nearest = (-y.dot(v) / beta).max(0.0);
        (y + v * nearest).length_squared() < 1.0
    })
}

/// −∇F and the strongest blob at a local point of the leaf at `block`.
fn gradient_at(blobs: &Blobs, cells: &Cells, block: u32, at: DVec3) -> (DVec3, u32) {
    let header = LeafHeader::from_block(&cells.blocks[block as usize]);
    let center = glam::Vec3::from_array(header.center).as_dvec3();
    let point = (at - center).as_vec3().to_array();
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || gradient::outward_and_strongest::<_, K, P>(
            simd,
            leaf_chunks::<P>(&cells.blocks, block, header.count),
            point,
        )
    ))
}
