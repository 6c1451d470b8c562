//! Engine `cells`: visits the pierced leaves in order; in each gathers the blobs that the segment
//! meets and solves for the first change of side.

pub(super) mod gather;
pub(super) mod gradient;
mod packet;
mod together;

use super::solve::{
    Active, LocalRay, Pending, Question, Search, local_ray, meets_fine_blob, specialised,
};
use super::{BlobHit, Scratch, sweep};
use crate::accel::cells::layout::{Block, Columns, LANES, LeafHeader};
use crate::accel::cells::traverse::{Stack, visit_leaves};
use crate::accel::cells::{Cells, Part, TimedCells, Unpacked};
use crate::field::BlobField;
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::ray::{Ray, Side};
use crate::primitive::Primitive;
use crate::scene::Leaves;
use fearless_simd::Simd;
use gather::{Segment, gather};
use glam::DVec3;
use packet::PacketScratch;

pub use together::answer_many;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct CellsScratch {
    stack: Stack,
    active: Active,
    pending: Pending,
    packet: PacketScratch,
    unpacked: Unpacked,
    /// Leaves with blobs too small for f32 that single rays have visited so far.
    pub(super) fine_leaves: u64,
}

/// What a search ended with, in the engine's own terms.
enum Found<'a> {
    /// The first crossing.
    Crossing {
        t: f64,
        /// The last leaf that was visited: its part and its header block.
        leaf: (&'a Part, u32),
        entering: bool,
    },
    /// The ray meets blobs too small for f32: engine `sweep` has to look.
    BeyondF32,
}

/// First crossing of a traceable object-space ray.
pub fn closest(
    blobs: &Blobs,
    cells: &TimedCells,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    scratch.counters.rays += 1;
    closest_alone(blobs, cells.at(ray.time), ray, scratch)
}

fn closest_alone(
    blobs: &Blobs,
    cells: &Cells,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    match find(blobs, cells, ray, Question::First, scratch)? {
        Found::BeyondF32 => sweep::first(blobs, blobs.exact_tree(), ray, scratch),
        Found::Crossing { t, leaf, entering } => {
            let at = ray.at(t) - blobs.field.origin;
            let unpacked = &scratch.cells.unpacked;
            let (outward, strongest) = gradient_at(blobs, cells, leaf, (at, ray.time), unpacked);
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
pub fn occluded(blobs: &Blobs, cells: &TimedCells, ray: &Ray, scratch: &mut Scratch) -> bool {
    scratch.counters.rays += 1;
    occluded_alone(blobs, cells.at(ray.time), ray, scratch)
}

fn occluded_alone(blobs: &Blobs, cells: &Cells, ray: &Ray, scratch: &mut Scratch) -> bool {
    match find(blobs, cells, ray, Question::Any, scratch) {
        None => false,
        Some(Found::Crossing { .. }) => true,
        Some(Found::BeyondF32) => sweep::first(blobs, blobs.exact_tree(), ray, scratch).is_some(),
    }
}

fn find<'a>(
    blobs: &'a Blobs,
    cells: &'a Cells,
    ray: &Ray,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found<'a>> {
    let local = local_ray(blobs, cells.bounds, ray)?;
    let mut found = if cells.stored().moves() {
        specialised!(blobs, simd, K, P => {
            find_in_cells::<_, K, P, true>(simd, blobs, cells, &local, question, scratch)
        })?
    } else {
        specialised!(blobs, simd, K, P => {
            find_in_cells::<_, K, P, false>(simd, blobs, cells, &local, question, scratch)
        })?
    };
    if let Found::Crossing { t, .. } = &mut found {
        *t = local.parameter(ray, *t);
    }
    Some(found)
}

#[inline(always)]
fn find_in_cells<'a, S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
    simd: S,
    blobs: &'a Blobs,
    cells: &'a Cells,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found<'a>> {
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
    let mut found = None;
    let nodes = simd.vectorize(
        #[inline(always)]
        || {
            visit_leaves::<_, MOVES>(
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
                            found = Some(Found::BeyondF32);
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
                    found = crossing.map(|t| Found::Crossing {
                        t,
                        leaf: (part, block),
                        entering: !ray.inside,
                    });
                    found.is_some()
                },
            )
        },
    );
    counters.nodes += nodes;
    found
}

/// One leaf of a part.
#[derive(Debug, Clone, Copy)]
struct LeafView<'a> {
    header: LeafHeader,
    /// The blobs, chunk after chunk.
    chunks: &'a [Block],
    stored: &'a Columns,
}

impl<'a> LeafView<'a> {
    /// The leaf of a part at a header block; `unpacked` is where its blobs go if it holds indices.
    #[inline(always)]
    fn new<P: Primitive>(
        field: &BlobField,
        cells: &'a Cells,
        (part, block): (&'a Part, u32),
        unpacked: &'a mut Unpacked,
    ) -> Self {
        if cells.leaves() == Leaves::Indices {
            unpacked.look_up::<P>(field, cells, part, block);
        }
        Self::visited::<P>(cells, (part, block), unpacked)
    }

    /// The leaf that was visited last.
    #[inline(always)]
    fn visited<P: Primitive>(
        cells: &'a Cells,
        (part, block): (&'a Part, u32),
        unpacked: &'a Unpacked,
    ) -> Self {
        let header = LeafHeader::from_block(&part.blocks[block as usize]);
        let stored = cells.stored();
        let chunks = match cells.leaves() {
            Leaves::Copies => {
                let first = block as usize + 1;
                let blocks = header.count.div_ceil(LANES) * stored.blocks_per_chunk::<P>();
                &part.blocks[first..first + blocks]
            }
            Leaves::Indices => unpacked.chunks(),
        };
        Self {
            header,
            chunks,
            stored,
        }
    }

    fn center(&self) -> DVec3 {
        glam::Vec3::from_array(self.header.center).as_dvec3()
    }

    /// Indices of the field's blobs.
    fn blobs<P: Primitive>(&self) -> impl Iterator<Item = usize> {
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        self.chunks
            .chunks_exact(per_chunk)
            .flat_map(move |chunk| chunk[per_chunk - 1].0.map(|index| index.to_bits() as usize))
            .take(self.header.count)
    }
}

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
fn meets_fine<P: Primitive>(blobs: &Blobs, leaf: &LeafView<'_>, ray: &LocalRay) -> bool {
    let field = &blobs.field;
    leaf.blobs::<P>()
        .any(|i| meets_fine_blob(field, i, leaf.header.fine_beta, ray))
}

/// −∇F and the strongest blob at a local point of the leaf that was visited last.
fn gradient_at(
    blobs: &Blobs,
    cells: &Cells,
    leaf: (&Part, u32),
    (at, time_secs): (DVec3, f64),
    unpacked: &Unpacked,
) -> (DVec3, u32) {
    let phase = cells.phase(time_secs);
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || {
            let leaf = LeafView::visited::<P>(cells, leaf, unpacked);
            let point = (at - leaf.center()).as_vec3().to_array();
            gradient::outward_and_strongest::<_, K, P>(
                simd,
                (leaf.stored, phase),
                leaf.chunks,
                point,
            )
        }
    ))
}
