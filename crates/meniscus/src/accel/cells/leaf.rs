//! Finishes a leaf: proves it solid if it is, shaves faces that hold no surface, packs its blobs.

use super::build::Context;
use super::filter::{BlobList, field_bounds, filter};
use super::layout::{Block, LANES, LeafHeader, blocks_per_chunk};
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use fearless_simd::Simd;
use glam::Vec3;

/// Slabs tried on each face, as fractions of the box that is left.
const SHAVES: [f32; 3] = [0.5, 0.25, 0.125];

/// Returns the leaf's trimmed box and its header block, or `None` when the cell is proven to hold no
/// surface. `buffers` are scratch.
pub(super) fn finish_leaf<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    context: &Context,
    cell: Aabb,
    list: &BlobList,
    buffers: &mut [BlobList; 2],
    blocks: &mut Vec<Block>,
) -> Option<(Aabb, u32)> {
    if octants_are_settled::<S, K, P>(simd, context, cell, list) {
        return None;
    }
    let mut trimmed = cell;
    for axis in 0..3 {
        for upper_face in [false, true] {
            for fraction in SHAVES {
                let (slab, rest) = slab_and_rest(trimmed, axis, upper_face, fraction);
                let bounds = field_bounds::<S, K, P>(simd, list, slab.padded(context.pad));
                if context.settled(bounds) {
                    trimmed = rest;
                    break;
                }
            }
        }
    }
    let kept = &mut buffers[0];
    let bounds = filter::<S, K, P>(simd, list, trimmed.padded(context.pad), true, kept);
    if kept.count == 0 || context.settled(bounds) {
        return None;
    }
    let block = blocks.len() as u32;
    pack::<P>(kept, trimmed.center(), blocks);
    Some((trimmed, block))
}

/// Whether all eight octants are proven free of surface.
fn octants_are_settled<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    context: &Context,
    cell: Aabb,
    list: &BlobList,
) -> bool {
    let center = cell.center();
    for octant in 0..8 {
        let corner = Vec3::new(
            if octant & 1 == 0 {
                cell.min.x
            } else {
                cell.max.x
            },
            if octant & 2 == 0 {
                cell.min.y
            } else {
                cell.max.y
            },
            if octant & 4 == 0 {
                cell.min.z
            } else {
                cell.max.z
            },
        );
        let bounds = Aabb {
            min: corner.min(center),
            max: corner.max(center),
        };
        if !context.settled(field_bounds::<S, K, P>(
            simd,
            list,
            bounds.padded(context.pad),
        )) {
            return false;
        }
    }
    true
}

fn slab_and_rest(bounds: Aabb, axis: usize, upper_face: bool, fraction: f32) -> (Aabb, Aabb) {
    let (mut slab, mut rest) = (bounds, bounds);
    let thickness = fraction * (bounds.max[axis] - bounds.min[axis]);
    if upper_face {
        slab.min[axis] = bounds.max[axis] - thickness;
        rest.max[axis] = slab.min[axis];
    } else {
        slab.max[axis] = bounds.min[axis] + thickness;
        rest.min[axis] = slab.max[axis];
    }
    (slab, rest)
}

fn pack<P: Primitive>(list: &BlobList, center: Vec3, blocks: &mut Vec<Block>) {
    let header = LeafHeader {
        count: list.count,
        center: center.to_array(),
    };
    blocks.push(header.to_block());
    let shape_columns = P::COLUMNS;
    for at in (0..list.count).step_by(LANES) {
        for k in 0..blocks_per_chunk(shape_columns) - 1 {
            let mut block = Block::ZERO;
            block.0.copy_from_slice(&list.columns[k][at..at + LANES]);
            if k < 3 {
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
