//! Rays one by one: each visits the pierced leaves in order, in each gathers the blobs that its segment
//! meets, and solves for the first change of side, with lanes for blobs and for samples.

use super::gather::{Segment, gather};
use super::{CellsScratch, LeafView, gradient};
use crate::accel::cells::traverse::visit_leaves;
use crate::accel::cells::{Cells, Part};
use crate::frame::Blobs;
use crate::intersect::solve::{LocalRay, Question, Search, meets_fine_blob, specialised};
use crate::intersect::{BlobHit, Scratch};
use crate::kernel::KernelShape;
use crate::math::ray::Side;
use crate::primitive::Primitive;
use fearless_simd::Simd;
use glam::DVec3;

/// What became of one ray.
#[derive(Debug, Clone, Copy)]
pub(super) enum Outcome {
    /// It crosses nothing.
    Miss,
    /// Its first crossing, `t` being the distance along the local ray. Where any crossing does, only that
    /// there is one counts.
    Hit(BlobHit),
    /// It meets blobs too small for f32: engine `sweep` has to look.
    BeyondF32,
}

/// Traces rays, each with its place among those that are asked, and tells `became` what became of each.
pub(super) fn trace(
    blobs: &Blobs,
    cells: &Cells,
    (rays, question): (&[(usize, LocalRay)], Question),
    scratch: &mut Scratch,
    became: &mut dyn FnMut(&(usize, LocalRay), Outcome),
) {
    let of = (blobs, cells);
    if cells.stored().moves() {
        specialised!(blobs, simd, K, P => simd.vectorize(
            #[inline(always)]
            || for ray in rays {
                became(ray, trace_one::<_, K, P, true>(simd, of, (&ray.1, question), scratch));
            }
        ));
    } else {
        specialised!(blobs, simd, K, P => simd.vectorize(
            #[inline(always)]
            || for ray in rays {
                became(ray, trace_one::<_, K, P, false>(simd, of, (&ray.1, question), scratch));
            }
        ));
    }
}

#[inline(always)]
fn trace_one<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
    simd: S,
    (blobs, cells): (&Blobs, &Cells),
    (ray, question): (&LocalRay, Question),
    scratch: &mut Scratch,
) -> Outcome {
    let slab_ray = ray.slab_ray();
    let CellsScratch {
        stack,
        active,
        pending,
        unpacked,
        fine_leaves,
        ..
    } = &mut scratch.cells;
    let counters = &mut scratch.counters;
    let direction = ray.direction.as_vec3().to_array();
    let mut search: Search = Search::new(blobs, cells.bounds, ray, question);
    let phase = if MOVES {
        cells.phase(ray.time_secs)
    } else {
        0.0
    };
    let mut first_leaf = true;
    // The crossing, and the last leaf that was visited: its part and its header block.
    let mut found: Option<(f64, (&Part, u32))> = None;
    let mut is_beyond_f32 = false;
    let nodes = visit_leaves::<_, MOVES>(
        simd,
        cells,
        (&slab_ray, 0.5 + 0.5 * phase),
        stack,
        #[inline(always)]
        |within, index| cells.part::<S, K, P>(simd, &blobs.field, within, index),
        #[inline(always)]
        |part, block, near, far| {
            counters.leaves += 1;
            let near_f64 = f64::from(near);
            if first_leaf && !search.on_stated_side && search.is_past_start(near_f64) {
                // The ray starts in a dropped cell, all of which lies on one side.
                search.on_stated_side = ray.side_is_proven
                    || (blobs.field.at(ray.time_secs).side(ray.origin) == Side::Inside)
                        == ray.inside;
            }
            first_leaf = false;
            let leaf = LeafView::new::<P>(&blobs.field, cells, (part, block), unpacked);
            counters.blob_evaluations += leaf.header.count as u64;
            let origin = (ray.origin + ray.direction * near_f64 - leaf.center()).as_vec3();
            if leaf.header.fine_beta < f32::INFINITY {
                *fine_leaves += 1;
                if meets_fine::<P>(blobs, &leaf, ray) {
                    is_beyond_f32 = true;
                    return true;
                }
            }
            let length = far - near;
            let segment = Segment {
                origin: origin.to_array(),
                direction,
                length,
                phase,
            };
            let reach = gather::<S, K, P, MOVES>(simd, &leaf, &segment, active);
            if search.stays_below(reach) {
                return false;
            }
            let crossing = search.first_on::<S, K>(simd, active, pending, near_f64, length);
            found = crossing.map(|along| (along, (part, block)));
            found.is_some()
        },
    );
    counters.nodes += nodes;
    let Some((along, leaf)) = found else {
        return if is_beyond_f32 {
            Outcome::BeyondF32
        } else {
            Outcome::Miss
        };
    };
    let mut hit = BlobHit {
        t: along,
        outward: DVec3::ZERO,
        strongest: 0,
        entering: !ray.inside,
    };
    if question == Question::First {
        let leaf = LeafView::visited::<P>(cells, leaf, unpacked);
        let point = (ray.origin + ray.direction * along - leaf.center()).as_vec3();
        (hit.outward, hit.strongest) = gradient::outward_and_strongest::<_, K, P>(
            simd,
            (leaf.stored, phase),
            leaf.chunks,
            point.to_array(),
        );
    }
    Outcome::Hit(hit)
}

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
fn meets_fine<P: Primitive>(blobs: &Blobs, leaf: &LeafView<'_>, ray: &LocalRay) -> bool {
    let field = &blobs.field;
    leaf.blobs::<P>()
        .any(|i| meets_fine_blob(field, i, leaf.header.fine_beta, ray))
}
