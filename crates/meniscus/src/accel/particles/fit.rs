//! Boxes and leaf contents of a tree whose topology stands: the last step of a build, and all of a
//! refit.

use super::layout::{Faces, MOTION_COLUMNS, Node, columns, leaf_blocks};
use crate::accel::cells::layout::{Block, LANES, LEAF, LeafHeader};
use crate::field::{BlobField, MotionBoxes};
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use rayon::prelude::*;
use std::ops::Range;

/// Supports below the size of what shares one origin over this are left to float64: a coordinate's
/// rounding, 2⁻²⁴ of that size, moves q by twice itself over the support, which is to stay near 10⁻⁵.
pub const FINEST_PART: f32 = 64.0;

/// So many rounding margins count as size: boxes are entered and rays start no more exactly.
const MARGIN_PARTS: f32 = 512.0;

/// A stretch of so many typical supports may share one origin.
const STRETCH_SUPPORTS: f32 = 4.0;

/// Blobs that one task sums up.
const PIECE: usize = 1 << 14;

/// What the leaves of one field share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// Mean radius of the supports.
    pub typical_support: f32,
    /// How much wider than its blobs a leaf's box is on every side: the slab test's rounding grows with
    /// the distance travelled within the box of all.
    pub pad: f32,
    /// No leaf counts as smaller than this when it is asked which blobs are too small for f32.
    pub least_extent: f32,
}

impl Measures {
    /// Those of `field`.
    pub fn of(field: &BlobField) -> Self {
        let typical_support = typical_support(field);
        let all = support_bounds(field);
        let pad = if field.is_empty() {
            0.0
        } else {
            5e-7 * all.size().length().max(all.center().abs().max_element())
        };
        Self {
            typical_support,
            pad,
            least_extent: (STRETCH_SUPPORTS * typical_support).max(MARGIN_PARTS * pad),
        }
    }
}

/// Mean radius of the supports.
fn typical_support(field: &BlobField) -> f32 {
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
fn support_bounds(field: &BlobField) -> Aabb {
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
pub(super) fn leaves_of<P: Primitive>(
    ranges: &[Range<usize>],
    order: &[u32],
    motion_columns: usize,
) -> Vec<Block> {
    let per_leaf = leaf_blocks::<P>(motion_columns);
    let mut blocks = vec![Block::ZERO; per_leaf * ranges.len()];
    blocks
        .par_chunks_mut(per_leaf)
        .zip(ranges)
        .for_each(|(leaf, range)| {
            leaf[0].0[0] = f32::from_bits(range.len() as u32);
            let indices = &mut leaf[columns::<P>()].0;
            for (slot, &index) in indices.iter_mut().zip(&order[range.clone()]) {
                *slot = f32::from_bits(index);
            }
        });
    blocks
}

/// Fills a leaf with its blobs; returns its boxes, which are all the same where nothing moves.
pub(super) fn fit_leaf<P: Primitive>(
    field: &BlobField,
    measures: &Measures,
    leaf: &mut [Block],
) -> MotionBoxes {
    let count = LeafHeader::from_block(&leaf[0]).count;
    let (front, rest) = leaf.split_at_mut(columns::<P>());
    let (indices, rates) = rest.split_at_mut(1);
    let indices = &indices[0].0[..count];
    let index = |slot: usize| indices[slot].to_bits() as usize;
    let blobs = (0..count).map(index);
    let boxes = match &field.motion {
        None => {
            let boxes = blobs.map(|i| field.support_box(i));
            MotionBoxes::still(boxes.fold(Aabb::EMPTY, Aabb::union))
        }
        Some(_) => {
            let boxes = blobs.map(|i| field.motion_boxes(i));
            boxes.fold(MotionBoxes::EMPTY, MotionBoxes::union)
        }
    };
    let boxes = boxes.padded(measures.pad);
    let bounds = boxes.ends[0].union(boxes.ends[1]);
    let middle = field
        .motion
        .as_ref()
        .map_or(0.0, crate::field::Motion::middle_secs);
    let center = bounds.center();
    let mut steepest = 0.0_f32;
    for slot in 0..LANES {
        // Lanes without a blob get a shape all the same, so that no number is none.
        let i = index(if slot < count { slot } else { 0 });
        let mut columns = [0.0; 6];
        P::pack(&field.shapes, i, &mut columns[..P::COLUMNS]);
        let (offset, weight) = if slot < count {
            let turned = match &field.motion {
                Some(motion) if motion.turns() => motion.most_turn(i) as f32,
                Some(_) | None => 1.0,
            };
            let square: f32 = columns.iter().map(|a| a * a).sum();
            steepest = steepest.max(square * turned * turned);
            let offset = (field.at(middle).center(i) - center.as_dvec3()).as_vec3();
            (offset.to_array(), field.weights[i])
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
        if let Some(motion) = &field.motion {
            let [velocity, half] = motion.rates(i);
            let there = velocity + half * (2.0 * middle);
            for axis in 0..3 {
                rates[axis].0[slot] = there[axis] as f32;
                rates[3 + axis].0[slot] = half[axis] as f32;
            }
            if motion.turns() {
                for (column, &rate) in rates[MOTION_COLUMNS..]
                    .iter_mut()
                    .zip(&motion.velocity_gradients[i])
                {
                    column.0[slot] = rate;
                }
            }
        }
    }
    // |A|² ≥ β along every ray.
    let extent = bounds.size().max_element().max(measures.least_extent);
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
    boxes
}

/// Where lanes without a blob lie: what is there reaches no ray.
const NOWHERE: [f32; 3] = [1e15; 3];

/// The boxes of all nodes at one time.
pub(super) struct Fitted {
    /// Node by node; those of children that do not exist are [`Node::FAR`].
    pub(super) faces: Vec<Faces>,
    /// How many boxes a ray that meets all of them meets, by the surface area heuristic.
    pub(super) cost: f32,
}

/// Fits the boxes of all nodes to those of the leaves.
pub(super) fn fit_nodes(nodes: &[Node], leaves: impl Fn(usize) -> Aabb) -> Fitted {
    let mut areas = 0.0_f64;
    let mut boxes = vec![Aabb::EMPTY; nodes.len()];
    let mut faces = vec![Node::FAR; nodes.len()];
    // Children stand behind their parents.
    for index in (0..nodes.len()).rev() {
        let mut all = Aabb::EMPTY;
        for (slot, &reference) in nodes[index].children.iter().enumerate() {
            if reference == Node::NONE {
                break;
            }
            let bounds = if reference & LEAF != 0 {
                leaves((reference & !LEAF) as usize)
            } else {
                boxes[reference as usize]
            };
            for axis in 0..3 {
                faces[index][axis][slot] = bounds.min[axis];
                faces[index][3 + axis][slot] = bounds.max[axis];
            }
            areas += f64::from(bounds.half_area());
            all = all.union(bounds);
        }
        boxes[index] = all;
    }
    let cost = areas / f64::from(boxes[0].half_area()).max(f64::MIN_POSITIVE);
    Fitted {
        faces,
        cost: cost as f32,
    }
}
