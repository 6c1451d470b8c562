//! Engine `cells`: visits the pierced leaves in order; in each gathers the blobs that the segment
//! meets and solves for the first change of side. Coherent rays go sixteen at a time, others one by one.

mod alone;
pub(super) mod gather;
pub(super) mod gradient;
mod packet;
mod prepare;
mod together;

use super::solve::{Active, LocalRay, Pending};
use super::{BlobHit, Scratch};
use crate::accel::cells::layout::{Block, Columns, LANES, LeafHeader};
use crate::accel::cells::traverse::Stack;
use crate::accel::cells::{Cells, Part, TimedCells, Unpacked};
use crate::field::BlobField;
use crate::frame::Blobs;
use crate::math::ray::Ray;
use crate::primitive::Primitive;
use crate::scene::Leaves;
use glam::DVec3;
use packet::PacketScratch;
use prepare::Prepared;

pub(super) use together::answer_many;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct CellsScratch {
    stack: Stack,
    active: Active,
    pending: Pending,
    packet: PacketScratch,
    /// Rays that are asked together, and of these, each with its place, those that go alone; taken out
    /// while in use.
    prepared: Option<Box<Prepared>>,
    alone: Vec<(usize, LocalRay)>,
    unpacked: Unpacked,
    /// Leaves with blobs too small for f32 that single rays have visited so far.
    pub(super) fine_leaves: u64,
}

/// First crossing of an object-space ray.
pub fn closest(
    blobs: &Blobs,
    cells: &TimedCells,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    together::answer(blobs, cells.at(ray.time), ray, scratch)
}

/// Whether an object-space ray has a crossing.
pub fn occluded(blobs: &Blobs, cells: &TimedCells, ray: &Ray, scratch: &mut Scratch) -> bool {
    together::answer(blobs, cells.at(ray.time), ray, scratch)
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
