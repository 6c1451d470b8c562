//! Boxes and leaf contents of a tree whose topology stands: the last step of a build, and all of a
//! refit.

use super::layout::{Node, leaf_blocks};
use crate::accel::cells::layout::{Block, LANES, LEAF, LeafHeader};
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use rayon::prelude::*;
use std::ops::Range;

/// Supports below the size of what shares one origin over this are left to float64: a coordinate's
/// rounding, 2⁻²⁴ of that size, moves q by twice itself over the support, which is to stay near 10⁻⁵.
const FINEST_PART: f32 = 64.0;

/// So many rounding margins count as size: boxes are entered and rays start no more exactly.
const MARGIN_PARTS: f32 = 512.0;

/// A stretch of so many typical supports may share one origin.
const STRETCH_SUPPORTS: f32 = 4.0;

/// Blobs that one task sums up.
const PIECE: usize = 1 << 14;

/// Mean radius of the supports.
pub(super) fn typical_support(field: &BlobField) -> f32 {
    // Pieces in a fixed order, so that the sum does not depend on the number of threads.
    let pieces: Vec<f64> = (0..field.len().div_ceil(PIECE))
        .into_par_iter()
        .map(|piece| {
            let end = ((piece + 1) * PIECE).min(field.len());
            (piece * PIECE..end)
                .map(|i| field.shapes.mean_radius(i))
                .sum()
        })
        .collect();
    (pieces.iter().sum::<f64>() / field.len().max(1) as f64) as f32
}

/// Box around all supports.
pub(super) fn support_bounds(field: &BlobField) -> Aabb {
    (0..field.len())
        .into_par_iter()
        .with_min_len(PIECE)
        .map(|i| field.support_box(i))
        .reduce(|| Aabb::EMPTY, Aabb::union)
}

/// See [`ParticleTree::inner_level`](super::ParticleTree::inner_level).
pub(super) fn inner_level(field: &BlobField) -> f32 {
    let least = field.weights.iter().copied().fold(f32::INFINITY, f32::min);
    let level = f64::from(field.threshold) / f64::from(least);
    match field.kernel.q_at(level) {
        Some(q) => (1.0 - q) as f32,
        None => 1.0,
    }
}

/// Leaves that know how many blobs they hold and which.
pub(super) fn leaves_of<P: Primitive>(ranges: &[Range<usize>], order: &[u32]) -> Vec<Block> {
    let per_leaf = leaf_blocks::<P>();
    let mut blocks = vec![Block::ZERO; per_leaf * ranges.len()];
    blocks
        .par_chunks_mut(per_leaf)
        .zip(ranges)
        .for_each(|(leaf, range)| {
            leaf[0].0[0] = f32::from_bits(range.len() as u32);
            let indices = &mut leaf[per_leaf - 1].0;
            for (slot, &index) in indices.iter_mut().zip(&order[range.clone()]) {
                *slot = f32::from_bits(index);
            }
        });
    blocks
}

/// Fills a leaf with its blobs; returns its box.
pub(super) fn fit_leaf<P: Primitive>(
    field: &BlobField,
    typical: f32,
    pad: f32,
    leaf: &mut [Block],
) -> Aabb {
    let count = LeafHeader::from_block(&leaf[0]).count;
    let (front, indices) = leaf.split_at_mut(4 + P::COLUMNS + 1);
    let indices = &indices[0].0[..count];
    let index = |slot: usize| indices[slot].to_bits() as usize;
    let bounds = (0..count).fold(Aabb::EMPTY, |bounds, slot| {
        bounds.union(field.support_box(index(slot)))
    });
    let bounds = bounds.padded(pad);
    let center = bounds.center();
    let mut steepest = 0.0_f32;
    for slot in 0..LANES {
        // Lanes without a blob get a shape all the same, so that no number is none.
        let i = index(if slot < count { slot } else { 0 });
        let mut columns = [0.0; 6];
        P::pack(&field.shapes, i, &mut columns[..P::COLUMNS]);
        let (offset, weight) = if slot < count {
            steepest = steepest.max(columns.iter().map(|a| a * a).sum());
            // Both are f32 and close together: the difference loses at most half an ulp.
            ((field.center(i) - center).to_array(), field.weights[i])
        } else {
            (NOWHERE, 0.0)
        };
        for axis in 0..3 {
            front[1 + axis].0[slot] = offset[axis];
        }
        for k in 0..P::COLUMNS {
            front[4 + k].0[slot] = columns[k];
        }
        front[4 + P::COLUMNS].0[slot] = weight;
    }
    // |A|² ≥ β along every ray.
    let extent = bounds
        .size()
        .max_element()
        .max(STRETCH_SUPPORTS * typical)
        .max(MARGIN_PARTS * pad);
    let limit = (FINEST_PART / extent).powi(2);
    front[0] = LeafHeader {
        count,
        center: center.to_array(),
        fine_beta: if steepest >= limit {
            limit
        } else {
            f32::INFINITY
        },
    }
    .to_block();
    bounds
}

/// Where lanes without a blob lie: what is there reaches no ray.
const NOWHERE: [f32; 3] = [1e15; 3];

/// Sets the boxes of all nodes from those of the leaves; returns the box around everything, and how
/// many boxes a ray that meets it meets by the surface area heuristic.
pub(super) fn fit_nodes(nodes: &mut [Node], leaves: &[Aabb]) -> (Aabb, f32) {
    let mut areas = 0.0_f64;
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    // Children stand behind their parents.
    for index in (0..nodes.len()).rev() {
        let node = &mut nodes[index];
        let mut all = Aabb::EMPTY;
        for slot in 0..8 {
            let reference = node.children[slot];
            if reference == Node::NONE {
                break;
            }
            let bounds = if reference & LEAF != 0 {
                leaves[(reference & !LEAF) as usize]
            } else {
                boxes[reference as usize]
            };
            for axis in 0..3 {
                node.bounds[axis][slot] = bounds.min[axis];
                node.bounds[3 + axis][slot] = bounds.max[axis];
            }
            areas += f64::from(bounds.half_area());
            all = all.union(bounds);
        }
        boxes[index] = all;
    }
    let cost = areas / f64::from(boxes[0].half_area()).max(f64::MIN_POSITIVE);
    (boxes[0], cost as f32)
}
