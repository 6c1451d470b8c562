//! Blobs of a leaf as columns: written when it is packed, or for [`Leaves::Indices`](crate::scene::Leaves)
//! whenever a ray comes.

use super::layout::{Block, Columns, LANES, LeafHeader};
use super::{Cells, Part};
use crate::field::{BlobField, Span};
use crate::primitive::Primitive;
use glam::Vec3;

/// Calls `put(k, value)` for each stored column k of a blob, as it moves in `span`.
#[inline(always)]
pub(super) fn row_of<P: Primitive>(
    field: &BlobField,
    span: Span,
    stored: &Columns,
    blob: usize,
    mut put: impl FnMut(usize, f32),
) {
    let center = field.centers[blob];
    match &field.motion {
        None => {
            for k in 0..3 {
                put(k, center[k]);
            }
        }
        Some(motion) => {
            let center = Vec3::from_array(center).as_dvec3();
            let [place, velocity, half] = motion.by_phase(span, blob, center);
            let first = stored.motion_at::<P>();
            for k in 0..3 {
                put(k, place[k] as f32);
                put(first + k, velocity[k] as f32);
                if stored.is_accelerated() {
                    put(first + 3 + k, half[k] as f32);
                }
            }
        }
    }
    if stored.shape.is_none() {
        let mut shape = [0.0; 6];
        P::pack(&field.shapes, blob, &mut shape[..P::COLUMNS]);
        for k in 0..P::COLUMNS {
            put(Columns::SHAPE + k, shape[k]);
        }
    }
    if stored.weight.is_none() {
        put(stored.weight_at::<P>(), field.weights[blob]);
    }
}

/// The chunks of the leaf of indices that was looked up last.
#[derive(Debug, Default)]
pub struct Unpacked(Vec<Block>);

impl Unpacked {
    /// The chunks.
    #[inline(always)]
    pub fn chunks(&self) -> &[Block] {
        &self.0
    }

    /// Looks up the blobs of the leaf at `block`, which holds indices: the same bits that a copy holds.
    #[inline(never)]
    pub fn look_up<P: Primitive>(
        &mut self,
        field: &BlobField,
        cells: &Cells,
        part: &Part,
        block: u32,
    ) {
        let stored = cells.stored();
        let header = LeafHeader::from_block(&part.blocks[block as usize]);
        let chunks = header.count.div_ceil(LANES);
        let per_chunk = stored.blocks_per_chunk::<P>();
        self.0.resize(chunks * per_chunk, Block::ZERO);
        let indices = &part.blocks[block as usize + 1..][..chunks];
        let mut left = header.count;
        for (indices, chunk) in indices.iter().zip(self.0.chunks_exact_mut(per_chunk)) {
            let (places, others) = chunk.split_at_mut(3);
            let present = left.min(LANES);
            for lane in 0..present {
                let blob = indices.0[lane].to_bits() as usize;
                row_of::<P>(field, cells.span(), stored, blob, |k, value| {
                    if k < 3 {
                        places[k].0[lane] = value - header.center[k];
                    } else {
                        others[k - 3].0[lane] = value;
                    }
                });
            }
            for k in 0..per_chunk - 1 {
                let absent = stored.absent::<P>(k);
                if k < 3 {
                    places[k].0[present..].fill(absent - header.center[k]);
                } else {
                    others[k - 3].0[present..].fill(absent);
                }
            }
            chunk[per_chunk - 1] = *indices;
            left -= present;
        }
    }
}
