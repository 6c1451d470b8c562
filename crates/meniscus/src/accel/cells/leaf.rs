//! Finishes a leaf: proves it solid if it is, shaves faces that hold no surface, packs its blobs.

use super::build::BuildContext;
use super::filter::{filter, is_settled};
use super::layout::{Block, Columns, LANES, LeafHeader};
use super::list::BlobList;
use super::place::Place;
use crate::kernel::KernelShape;
use crate::primitive::Primitive;
use crate::scene::Leaves;
use fearless_simd::Simd;

/// Slabs tried on each face, as fractions of the box that is left. Where a thin one holds surface, so
/// does a thicker one: most faces are done after one question.
const SHAVES: [f32; 3] = [0.125, 0.25, 0.5];

/// Supports below the leaf's size over this are left to float64.
pub(super) const FINEST_PART: f32 = 64.0;

/// So many rounding margins count as size of a leaf: boxes are entered and rays start no more exactly.
const MARGIN_PARTS: f32 = 512.0;

/// Returns the leaf's trimmed box and its header block, or `None` when the cell is proven to hold no
/// surface. `kept` is scratch.
pub(super) fn finish_leaf<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    context: &BuildContext,
    cell: Place,
    list: &BlobList,
    kept: &mut BlobList,
    blocks: &mut Vec<Block>,
) -> Option<(Place, u32)> {
    if octants_are_settled::<S, K, P>(simd, context, cell, list) {
        return None;
    }
    let mut trimmed = cell;
    for axis in 0..3 {
        for upper_face in [false, true] {
            let mut shaved = trimmed;
            for fraction in SHAVES {
                let [slab, rest] = trimmed.cut(axis, fraction, upper_face);
                let slab = slab.padded(context.pad);
                if !is_settled::<S, K, P>(simd, list, &slab, |bounds| context.settled(bounds)) {
                    break;
                }
                shaved = rest;
            }
            trimmed = shaved;
        }
    }
    let place = trimmed.padded(context.pad);
    let is_settled = filter::<S, K, P>(simd, list, &place, true, kept, |b| context.settled(b));
    if kept.count == 0 || is_settled {
        return None;
    }
    let block = blocks.len() as u32;
    pack::<P>(kept, trimmed, context, blocks);
    Some((trimmed, block))
}

/// Whether all eight octants are proven free of surface.
fn octants_are_settled<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    context: &BuildContext,
    cell: Place,
    list: &BlobList,
) -> bool {
    (0..8).all(|octant| {
        let place = cell.octant(octant).padded(context.pad);
        is_settled::<S, K, P>(simd, list, &place, |bounds| context.settled(bounds))
    })
}

/// The steepness from which blobs are too small for f32 in a leaf of this size; infinite where no
/// blob of the list is.
fn fine_beta<P: Primitive>(list: &BlobList, size: f32) -> f32 {
    // |A|² ≥ β along every ray. A coordinate's rounding, 2⁻²⁴ of the leaf's size, moves q by twice
    // itself times √β, which is to stay near 10⁻⁵.
    let limit = (FINEST_PART / size).powi(2);
    let steepest = -list.smallest_of_shapes::<P>(|a| -a.iter().map(|a| a * a).sum::<f32>());
    if steepest < limit {
        f32::INFINITY
    } else {
        limit
    }
}

fn pack<P: Primitive>(
    list: &BlobList,
    place: Place,
    context: &BuildContext,
    blocks: &mut Vec<Block>,
) {
    let center = place.middle().center();
    let extent = place.hull().size().max_element();
    let header = LeafHeader {
        count: list.count,
        center: center.to_array(),
        fine_beta: fine_beta::<P>(list, extent.max(MARGIN_PARTS * context.pad)),
    };
    blocks.push(header.to_block());
    let columns = match context.leaves {
        Leaves::Copies => list.stored.count::<P>(),
        Leaves::Indices => 0,
    };
    for at in (0..list.count).step_by(LANES) {
        for k in 0..columns {
            let mut block = Block::ZERO;
            block.0.copy_from_slice(&list.columns[k][at..at + LANES]);
            if k < Columns::SHAPE {
                for value in &mut block.0 {
                    // Both are f32 and close together: the difference loses at most half an ulp.
                    *value -= center[k];
                }
            }
            blocks.push(block);
        }
        let mut indices = Block::ZERO;
        for (slot, index) in indices.0.iter_mut().zip(&list.indices[at..at + LANES]) {
            *slot = f32::from_bits(*index);
        }
        blocks.push(indices);
    }
}
