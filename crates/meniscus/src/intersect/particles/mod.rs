//! Engine `particles`: walks a hierarchy over the particles front to back and solves stretch after
//! stretch of the ray up to the frontier, the nearest box that is not yet open: what lies beyond it
//! cannot reach the field before it.

mod gradient;
mod pool;

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
use fearless_simd::Simd;
use gradient::NearHit;
use pool::{LeafRay, Pool};

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct ParticlesScratch {
    frontier: Frontier,
    pool: Pool,
    active: Active,
    pending: Pending,
    near_hit: NearHit,
}

/// What a search ended with, in the engine's own terms.
enum Found {
    /// The first crossing, and the origin of the pool's parameters.
    Crossing { t: f64, base: f64 },
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
        Found::Crossing { t: along, base } => {
            let t = local.parameter(ray, along);
            let at = ray.at(t) - blobs.field.origin;
            let ParticlesScratch { pool, near_hit, .. } = &mut scratch.particles;
            let (outward, strongest) = specialised!(blobs, simd, K, P => simd.vectorize(
                #[inline(always)]
                || {
                    near_hit.collect::<P>(tree, pool, (along - base) as f32, at);
                    near_hit.outward_and_strongest::<_, K, P>(simd)
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
        ..
    } = &mut scratch.particles;
    let counters = &mut scratch.counters;
    let slabs = Slabs::new(simd, &ray.slab_ray());
    let direction = ray.direction.as_vec3().to_array();
    let length = f64::from(ray.length);
    let longest = V::LONGEST_STRETCH * tree.typical_support;
    let shortest = V::SHORTEST_STRETCH * tree.typical_support;
    let mut search = Search::<V>::new(blobs, tree.bounds, ray, question);
    // Up to here the ray is solved; the pool's parameters count from `base`.
    let (mut solved, mut base) = (0.0_f64, 0.0_f64);
    // Where the ray enters the first inner sphere: a ray that comes from outside ends before.
    let mut inner = f64::INFINITY;
    frontier.start(tree);
    pool.clear();
    loop {
        // Open what is near.
        while let Some(near) = frontier.near() {
            let near = f64::from(near);
            if pool.count == 0 {
                solved = solved.max(near);
                if search.is_past_start(solved) {
                    // No support reaches the ray before.
                    search.on_stated_side |= !ray.inside;
                } else {
                    solved = 0.0;
                }
                base = solved;
            } else if near - solved >= f64::from(shortest) {
                break;
            }
            let Some(leaf) = frontier.visit(simd, tree, &slabs) else {
                counters.nodes += 1;
                continue;
            };
            counters.leaves += 1;
            let first = leaf as usize * leaf_blocks::<P>();
            let header = LeafHeader::from_block(&tree.blocks[first]);
            counters.blob_evaluations += header.count as u64;
            let chunk = &tree.blocks[first + 1..][..columns::<P>()];
            if header.fine_beta < f32::INFINITY && meets_fine(blobs, chunk, &header, ray) {
                return Some(Found::BeyondF32);
            }
            let center = glam::Vec3::from_array(header.center).as_dvec3();
            let leaf_ray = LeafRay {
                chunk,
                leaf,
                origin: (ray.origin + ray.direction * near - center)
                    .as_vec3()
                    .to_array(),
                direction,
                length: (length - near) as f32,
                offset: (near - base) as f32,
            };
            let enter = pool.add::<S, P>(
                simd,
                &leaf_ray,
                tree.inner_level,
                search.own_reach() - base as f32,
            );
            inner = inner.min(base + f64::from(enter));
        }
        if pool.count == 0 {
            return None;
        }
        // Solve what nothing else can reach.
        let known = frontier
            .near()
            .map_or(length, |near| f64::from(near).min(length));
        let mut end = known.min(solved + f64::from(longest));
        if search.on_stated_side && !ray.inside && inner > solved && inner <= length {
            if question == Question::Any {
                return Some(Found::Crossing { t: inner, base });
            }
            if inner <= end {
                // Reached once: by rounding there may be nothing.
                (end, inner) = (inner, f64::INFINITY);
            }
        }
        let stretch = (end - solved) as f32;
        let most = pool.advance::<S, K>(simd, (solved - base) as f32, stretch, active);
        base = solved;
        let nothing_there = active.count == 0 && !(ray.inside && search.on_stated_side);
        if !search.stays_below(most) && !nothing_there {
            let found = search.first_on::<S, K>(simd, active, pending, solved, stretch);
            if let Some(t) = found {
                return Some(Found::Crossing { t, base });
            }
        }
        solved += f64::from(stretch);
        if solved >= length {
            return None;
        }
    }
}

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
fn meets_fine(blobs: &Blobs, chunk: &[Block], header: &LeafHeader, ray: &LocalRay) -> bool {
    let indices = &chunk[chunk.len() - 1].0[..header.count];
    indices.iter().any(|index| {
        let i = index.to_bits() as usize;
        meets_fine_blob(&blobs.field, i, header.fine_beta, ray)
    })
}
