//! Engine `particles`: walks a hierarchy over the particles front to back and solves stretch after
//! stretch of the ray up to the frontier, the nearest box that is not yet open: what lies beyond it
//! cannot reach the field before it.

mod ends;
mod gradient;
mod pool;
mod turning;

use super::solve::{
    Active, FirstCrossing, LocalRay, Pending, Question, Search, Solver, local_ray, meets_fine_blob,
    specialised,
};
use super::{BlobHit, Scratch, sweep};
use crate::accel::cells::layout::{Block, LeafHeader};
use crate::accel::particles::ParticleTree;
use crate::accel::particles::frontier::{Frontier, Slabs};
use crate::accel::particles::layout::{columns, leaf_blocks};
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::ray::Ray;
use crate::primitive::Primitive;
use ends::Ends;
use fearless_simd::Simd;
use gradient::NearHit;
use pool::{LeafRay, Pool};

/// Stretches that are solved at once are this long, in typical supports …
pub const LONGEST_STRETCH: f32 = 1.4;

/// … and a frontier that is nearer than this is moved ahead before anything is solved.
const SHORTEST_STRETCH: f32 = 0.35;

/// After so many stretches in a row that bounds alone settle, each is twice as long as the one before:
/// a large blob among small ones would be walked through in their steps.
const QUIET_STRETCHES: u32 = 4;

/// Of a leaf that comes next every so many blocks are read ahead; processors fetch what lies between.
const AHEAD: usize = 4;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct ParticlesScratch {
    frontier: Frontier,
    pool: Pool,
    active: Active,
    pending: Pending,
    near_hit: NearHit,
    /// Of what was read ahead, so that it is read.
    ahead: u32,
    /// Leaves with blobs too small for f32 visited so far.
    pub(super) fine_leaves: u64,
}

/// What a search ended with, in the engine's own terms.
enum Found {
    /// The first crossing, and where the stretch that holds it begins.
    Crossing { t: f64, from: f32 },
    /// The ray meets blobs too small for f32: engine `sweep` has to look.
    BeyondF32,
}

/// First crossing of a traceable object-space ray.
pub fn closest(
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    closest_by::<Solver>(blobs, tree, ray, scratch)
}

/// Whether a traceable object-space ray has a crossing.
pub fn occluded(blobs: &Blobs, tree: &ParticleTree, ray: &Ray, scratch: &mut Scratch) -> bool {
    occluded_by::<Solver>(blobs, tree, ray, scratch)
}

/// First crossing, stretches being solved by `V`.
pub(super) fn closest_by<V: FirstCrossing>(
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    scratch.counters.rays += 1;
    let local = local_ray(blobs, tree.bounds, ray)?;
    match find::<V>(blobs, tree, &local, Question::First, scratch)? {
        Found::BeyondF32 => sweep::first(blobs, blobs.exact_tree(), ray, scratch),
        Found::Crossing { t: along, from } => {
            let t = local.parameter(ray, along);
            let at = ray.at(t) - blobs.field.origin;
            let place = (from, (along - f64::from(from)) as f32);
            let times = tree.times(ray.time);
            let ParticlesScratch { pool, near_hit, .. } = &mut scratch.particles;
            let (outward, strongest) = specialised!(blobs, simd, K, P => simd.vectorize(
                #[inline(always)]
                || {
                    near_hit.collect::<_, P>(simd, (tree, times), pool, place, at);
                    near_hit.outward_and_strongest::<_, K, P>(simd, times)
                }
            ));
            Some(BlobHit {
                t,
                outward,
                strongest,
                entering: !local.inside,
            })
        }
    }
}

/// Whether there is a crossing, stretches being solved by `V`.
pub(super) fn occluded_by<V: FirstCrossing>(
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> bool {
    scratch.counters.rays += 1;
    let Some(local) = local_ray(blobs, tree.bounds, ray) else {
        return false;
    };
    match find::<V>(blobs, tree, &local, Question::Any, scratch) {
        None => false,
        Some(Found::Crossing { .. }) => true,
        Some(Found::BeyondF32) => sweep::first(blobs, blobs.exact_tree(), ray, scratch).is_some(),
    }
}

fn find<V: FirstCrossing>(
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || find_behind_frontier::<_, K, P, V>(simd, blobs, tree, ray, question, scratch)
    ))
}

#[inline(always)]
fn find_behind_frontier<S: Simd, K: KernelShape, P: Primitive, V: FirstCrossing>(
    simd: S,
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    let ParticlesScratch {
        frontier,
        pool,
        active,
        pending,
        fine_leaves,
        ahead,
        ..
    } = &mut scratch.particles;
    let counters = &mut scratch.counters;
    let slabs = Slabs::new(simd, &ray.slab_ray(), tree, ray.time_secs);
    let times = tree.times(ray.time_secs);
    let per_leaf = leaf_blocks::<P>(tree.motion_columns);
    let direction = ray.direction.as_vec3().to_array();
    let longest = LONGEST_STRETCH * tree.typical_support;
    let shortest = SHORTEST_STRETCH * tree.typical_support;
    let mut search = Search::<V>::new(blobs, tree.bounds, ray, question);
    let mut ends = Ends::new(tree.inner_level, search.own_reach());
    // Up to here the ray is solved.
    let mut solved = 0.0_f32;
    let (mut reach, mut quiet) = (longest, 0);
    frontier.start(tree);
    pool.clear();
    loop {
        // Open what is near.
        while let Some(near) = frontier.near() {
            if pool.count == 0 {
                // No support reaches the ray before.
                if search.is_past_start(f64::from(near.max(solved))) {
                    solved = solved.max(near);
                    search.on_stated_side |= !ray.inside;
                }
            } else if V::COLLECTS_FIRST {
                let end = if ray.inside {
                    ends.last_exit
                } else {
                    ends.inner
                };
                if near > end.max(solved) {
                    break;
                }
            } else if near - solved >= shortest {
                break;
            }
            let Some(leaf) = frontier.visit(simd, tree, &slabs) else {
                counters.nodes += 1;
                continue;
            };
            counters.leaves += 1;
            if let Some(next) = frontier.next_leaf() {
                // Read ahead: it is on its way from memory while this one is looked at.
                let next = &tree.blocks[next as usize * per_leaf..][..per_leaf];
                for block in next.iter().step_by(AHEAD) {
                    *ahead ^= block.0[0].to_bits();
                }
            }
            let first = leaf as usize * per_leaf;
            let header = LeafHeader::from_block(&tree.blocks[first]);
            counters.blob_evaluations += header.count as u64;
            let chunk = &tree.blocks[first + 1..][..per_leaf - 1];
            if header.fine_beta < f32::INFINITY {
                *fine_leaves += 1;
                if meets_fine(blobs, &chunk[columns::<P>() - 1], &header, ray) {
                    return Some(Found::BeyondF32);
                }
            }
            let center = glam::Vec3::from_array(header.center).as_dvec3();
            let origin = (ray.origin + ray.direction * f64::from(near) - center).as_vec3();
            let leaf_ray = LeafRay {
                chunk,
                leaf,
                times,
                origin: origin.to_array(),
                direction,
                near,
                length: ray.length - near,
            };
            pool.add::<S, P>(simd, &leaf_ray, &mut ends);
        }
        if pool.count == 0 {
            return None;
        }
        // Solve what nothing else can reach.
        let known = frontier.near().unwrap_or(ray.length).min(ray.length);
        let mut end = known.min(solved + reach);
        if end <= solved {
            // Supports below the rounding of places along the ray.
            end = known;
        }
        if ends.inner <= solved {
            // By rounding there was nothing, or the ray was not yet on its side.
            ends.inner = f32::INFINITY;
        }
        if search.on_stated_side && !ray.inside && ends.inner <= ray.length {
            if question == Question::Any {
                let t = f64::from(ends.inner);
                return Some(Found::Crossing { t, from: solved });
            }
            end = end.min(ends.inner);
        }
        let stretch = end - solved;
        let most = pool.advance::<S, K>(simd, solved, stretch, active);
        let nothing_there = active.count == 0 && !(ray.inside && search.on_stated_side);
        if search.stays_below(most) || nothing_there {
            quiet += 1;
            if quiet > QUIET_STRETCHES {
                reach *= 2.0;
            }
        } else {
            (reach, quiet) = (longest, 0);
            let near = f64::from(solved);
            if let Some(t) = search.first_on::<S, K>(simd, active, pending, near, stretch) {
                return Some(Found::Crossing { t, from: solved });
            }
        }
        solved = end;
        if solved >= ray.length {
            return None;
        }
    }
}

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
fn meets_fine(blobs: &Blobs, indices: &Block, header: &LeafHeader, ray: &LocalRay) -> bool {
    let indices = &indices.0[..header.count];
    indices.iter().any(|index| {
        let i = index.to_bits() as usize;
        meets_fine_blob(&blobs.field, i, header.fine_beta, ray)
    })
}
