//! Refines a coarse cell: split at midpoints, drop what is proven empty or solid.

use super::coarse::CoarseBox;
use super::filter::{self, BlobList, FieldBounds, filter};
use super::layout::{Block, Columns, DEEP};
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
    /// A cell below `few_side` whose field at the centre is this many times the threshold probably is
    /// solid: it is put off, and when a ray comes split down to `smallest_side`.
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
    /// A leaf: its box, and its header block, or its place among the coarse cells, or [`DEEP`] and
    /// its place among the cells put off.
    Leaf { bounds: Aabb, block: u32 },
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Split { bounds, .. } | Self::Leaf { bounds, .. } => *bounds,
        }
    }

    /// Two halves parted across `axis`, the lower first.
    pub(super) fn joined(axis: usize, low: Self, high: Self) -> Self {
        Self::Split {
            bounds: low.bounds().union(high.bounds()),
            axis,
            halves: Box::new([low, high]),
        }
    }

    /// Adds `by` to the places of all leaves.
    pub(super) fn renumber(&mut self, by: u32) {
        match self {
            Self::Split { halves, .. } => halves.iter_mut().for_each(|half| half.renumber(by)),
            Self::Leaf { block, .. } => *block += by,
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

/// What to do with a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Split,
    Finish,
    /// Leave it until a ray comes.
    PutOff,
}

fn next_step<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    cell: Aabb,
    (stalled, depth): (u32, u32),
    context: &BuildContext,
) -> Step {
    let support = smallest_support::<P>(list);
    let side = cell.size().max_element();
    let rule = &context.rule;
    if side < rule.smallest_side * support
        || stalled >= STALLED_SPLITS
        // Smaller cells would drown in their own rounding margin.
        || side < 32.0 * context.pad
        || depth >= MAX_DEPTH
    {
        return Step::Finish;
    }
    if side >= rule.few_side * support {
        return Step::Split;
    }
    let value = filter::field_value::<S, K, P>(simd, list, cell.center());
    if value >= rule.deep * context.threshold {
        Step::PutOff
    } else if list.count <= rule.few_blobs {
        Step::Finish
    } else {
        Step::Split
    }
}

/// Splits in a row that shortened neither half's list.
fn next_stalled(stalled: u32, list: &BlobList, halves: [&BlobList; 2]) -> u32 {
    if halves.iter().all(|half| half.count == list.count) {
        stalled + 1
    } else {
        0
    }
}

/// The inside of a cell.
pub(super) struct Built {
    pub(super) root: BinaryNode,
    pub(super) blocks: Vec<Block>,
    /// Cells put off, in the order of their indices.
    pub(super) deep: Vec<CoarseBox>,
}

/// Builds one subtree; keeps a list buffer per depth.
pub(super) struct Builder<'a, K, P> {
    context: &'a BuildContext,
    leave_deep: bool,
    blocks: Vec<Block>,
    deep: Vec<CoarseBox>,
    buffers: Vec<BlobList>,
    leaf_buffer: BlobList,
    formula: std::marker::PhantomData<(K, P)>,
}

impl<'a, K: KernelShape, P: Primitive> Builder<'a, K, P> {
    /// `leave_deep`: what probably is solid is not split but put on a list.
    pub(super) fn new(context: &'a BuildContext, leave_deep: bool) -> Self {
        Self {
            context,
            leave_deep,
            blocks: Vec::new(),
            deep: Vec::new(),
            buffers: Vec::new(),
            leaf_buffer: BlobList::default(),
            formula: std::marker::PhantomData,
        }
    }

    /// The subtree of `cell`, whose blobs are in `list`.
    pub(super) fn build<S: Simd>(
        mut self,
        simd: S,
        cell: Aabb,
        list: &BlobList,
        depth: u32,
    ) -> Option<Built> {
        let root = self.subtree(simd, cell, list, 0, depth)?;
        Some(Built {
            root,
            blocks: self.blocks,
            deep: self.deep,
        })
    }

    fn subtree<S: Simd>(
        &mut self,
        simd: S,
        cell: Aabb,
        list: &BlobList,
        stalled: u32,
        depth: u32,
    ) -> Option<BinaryNode> {
        let step = next_step::<S, K, P>(simd, list, cell, (stalled, depth), self.context);
        if step == Step::PutOff && self.leave_deep {
            let index = self.deep.len() as u32;
            self.deep.push(CoarseBox {
                bounds: cell,
                depth,
            });
            return Some(BinaryNode::Leaf {
                bounds: cell,
                block: DEEP | index,
            });
        }
        if step == Step::Finish {
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
        match children {
            [Some(low), Some(high)] => Some(BinaryNode::joined(axis, low, high)),
            [one, other] => one.or(other),
        }
    }
}
