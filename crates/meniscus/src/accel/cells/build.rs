//! Refines a coarse cell: split at midpoints, drop what is proven empty or solid.

use super::filter::{self, BlobList, FieldBounds, filter};
use super::layout::{Block, Columns};
use super::leaf::finish_leaf;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use fearless_simd::Simd;

/// When a cell is small enough, and how hard leaves are trimmed. Lengths are in support radii of
/// the leaf's own smallest blob.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BuildRule {
    /// A cell of at most this many blobs and below `few_side` is a leaf.
    pub few_blobs: usize,
    /// See `few_blobs`.
    pub few_side: f32,
    /// A cell below this side is a leaf however many blobs it has.
    pub smallest_side: f32,
    /// A cell whose field at the centre is this many times the threshold probably is solid, and is
    /// split down to `smallest_side`.
    pub deep: f32,
}

/// Splits in a row, one per axis, that may leave both children's lists as long as the parent's.
pub(super) const STALLED_SPLITS: u32 = 3;

/// Cells below this side, in supports, try bounds of second order.
const CLOSE_SIDE: f32 = 2.0;

/// No tree is deeper: the traversal's stack relies on it.
pub(super) const MAX_DEPTH: u32 = 96;

/// Binary tree of the cells that may contain surface.
#[derive(Debug)]
pub(super) enum BinaryNode {
    /// Two subtrees, the lower first, the axis that parts them and the box around them.
    Split {
        bounds: Aabb,
        axis: usize,
        halves: Box<[BinaryNode; 2]>,
    },
    /// A leaf: its box, and its header block or its place among the coarse cells.
    Leaf { bounds: Aabb, block: u32 },
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Split { bounds, .. } | Self::Leaf { bounds, .. } => *bounds,
        }
    }
}

/// What does not change during a build.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct BuildContext {
    pub(super) threshold: f32,
    /// Rounding margin by which boxes grow before they are filtered.
    pub(super) pad: f32,
    pub(super) rule: BuildRule,
    /// Which columns leaves store.
    pub(super) stored: Columns,
}

impl BuildContext {
    /// Whether bounds prove that a box holds no surface.
    pub(super) fn settled(&self, bounds: FieldBounds) -> bool {
        bounds.upper < self.threshold || bounds.lower > self.threshold * (1.0 + 1e-4)
    }
}

/// The list's smallest support; an ellipsoid counts as the ball of the same volume.
fn smallest_support<P: Primitive>(list: &BlobList) -> f32 {
    1.0 / list.largest_of_shapes::<P>(|a| match P::DIAGONAL {
        [k] => a[*k],
        diagonal => diagonal.iter().map(|&k| a[k]).product::<f32>().cbrt(),
    })
}

/// Whether a half of `cell` is small enough for bounds of second order.
fn is_close<P: Primitive>(list: &BlobList, cell: Aabb) -> bool {
    cell.size().max_element() < CLOSE_SIDE * smallest_support::<P>(list)
}

/// The longest axis of `cell` and the halves across it, the lower first.
pub(super) fn halves(cell: Aabb) -> (usize, [Aabb; 2]) {
    let size = cell.size();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = cell.min[axis] + 0.5 * size[axis];
    let mut halves = [cell; 2];
    halves[0].max[axis] = middle;
    halves[1].min[axis] = middle;
    (axis, halves)
}

fn is_leaf<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    cell: Aabb,
    stalled: u32,
    depth: u32,
    context: &BuildContext,
) -> bool {
    let support = smallest_support::<P>(list);
    let side = cell.size().max_element();
    let rule = &context.rule;
    if side < rule.smallest_side * support
        || stalled >= STALLED_SPLITS
        // Smaller cells would drown in their own rounding margin.
        || side < 32.0 * context.pad
        || depth >= MAX_DEPTH
    {
        return true;
    }
    // Deep inside, smaller cells will soon be proven solid and cost nothing.
    list.count <= rule.few_blobs
        && side < rule.few_side * support
        && filter::field_value::<S, K, P>(simd, list, cell.center()) < rule.deep * context.threshold
}

/// Splits in a row that shortened neither half's list.
fn next_stalled(stalled: u32, list: &BlobList, halves: [&BlobList; 2]) -> u32 {
    if halves.iter().all(|half| half.count == list.count) {
        stalled + 1
    } else {
        0
    }
}

pub(super) fn joined(
    axis: usize,
    low: Option<BinaryNode>,
    high: Option<BinaryNode>,
) -> Option<BinaryNode> {
    match (low, high) {
        (Some(low), Some(high)) => Some(BinaryNode::Split {
            bounds: low.bounds().union(high.bounds()),
            axis,
            halves: Box::new([low, high]),
        }),
        (one, other) => one.or(other),
    }
}

/// Builds one subtree; keeps a list buffer per depth.
pub(super) struct Builder<'a, K, P> {
    context: &'a BuildContext,
    blocks: Vec<Block>,
    buffers: Vec<BlobList>,
    leaf_buffer: BlobList,
    formula: std::marker::PhantomData<(K, P)>,
}

impl<'a, K: KernelShape, P: Primitive> Builder<'a, K, P> {
    pub(super) fn new(context: &'a BuildContext) -> Self {
        Self {
            context,
            blocks: Vec::new(),
            buffers: Vec::new(),
            leaf_buffer: BlobList::default(),
            formula: std::marker::PhantomData,
        }
    }

    /// The subtree of `cell`, whose blobs are in `list`, and its leaf blocks.
    pub(super) fn build<S: Simd>(
        mut self,
        simd: S,
        cell: Aabb,
        list: &BlobList,
        depth: u32,
    ) -> Option<(BinaryNode, Vec<Block>)> {
        let root = self.subtree(simd, cell, list, 0, depth)?;
        Some((root, self.blocks))
    }

    fn subtree<S: Simd>(
        &mut self,
        simd: S,
        cell: Aabb,
        list: &BlobList,
        stalled: u32,
        depth: u32,
    ) -> Option<BinaryNode> {
        if is_leaf::<S, K, P>(simd, list, cell, stalled, depth, self.context) {
            let kept = &mut self.leaf_buffer;
            return finish_leaf::<S, K, P>(simd, self.context, cell, list, kept, &mut self.blocks)
                .map(|(bounds, block)| BinaryNode::Leaf { bounds, block });
        }
        let close = is_close::<P>(list, cell);
        let (axis, parts) = halves(cell);
        let mut lists = [(); 2].map(|()| self.buffers.pop().unwrap_or_default());
        let bounds = [0, 1].map(|i| {
            let place = parts[i].padded(self.context.pad);
            filter::<S, K, P>(simd, list, place, close, &mut lists[i])
        });
        let stalled = next_stalled(stalled, list, [&lists[0], &lists[1]]);
        let mut children = [None, None];
        for i in 0..2 {
            if lists[i].count > 0 && !self.context.settled(bounds[i]) {
                children[i] = self.subtree(simd, parts[i], &lists[i], stalled, depth + 1);
            }
        }
        self.buffers.extend(lists);
        let [low, high] = children;
        joined(axis, low, high)
    }
}
