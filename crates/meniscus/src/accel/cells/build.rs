//! Builds the binary tree of cells: split at midpoints, drop what is proven empty or solid.

use super::filter::{self, BlobList, FieldBounds, filter};
use super::layout::Block;
use super::leaf::finish_leaf;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use fearless_simd::Simd;

/// When a cell is small enough, and how hard leaves are trimmed. Lengths are in support radii of
/// the leaf's own smallest blob.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// Lists longer than this are split on several threads. Fixed, so that the tree does not depend on
/// the number of threads.
const PARALLEL_BLOBS: usize = 8192;

/// Splits in a row, one per axis, that may leave both children's lists as long as the parent's.
const STALLED_SPLITS: u32 = 3;

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
    /// A leaf: its box, which part holds it, and its header block there.
    Leaf { bounds: Aabb, part: u32, block: u32 },
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> Aabb {
        match self {
            Self::Split { bounds, .. } | Self::Leaf { bounds, .. } => *bounds,
        }
    }
}

/// Leaf blocks made by one task.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) blocks: Vec<Block>,
}

/// What does not change during a build.
#[derive(Debug, Clone, Copy)]
pub(super) struct Context {
    pub(super) threshold: f32,
    /// Rounding margin by which boxes grow before they are filtered.
    pub(super) pad: f32,
    pub(super) rule: BuildRule,
}

impl Context {
    /// Whether bounds prove that a box holds no surface.
    pub(super) fn settled(&self, bounds: FieldBounds) -> bool {
        bounds.upper < self.threshold || bounds.lower > self.threshold * (1.0 + 1e-4)
    }
}

/// One subtree, its leaves in `parts` (in order).
pub(super) struct Subtree {
    pub(super) root: Option<BinaryNode>,
    pub(super) parts: Vec<Part>,
}

/// The list's smallest and largest support, from the shape columns of balls (1/R) or a bound for
/// ellipsoids (the largest factor entry is at least one over the shortest axis).
fn smallest_support<P: Primitive>(list: &BlobList) -> f32 {
    let steepest = match P::COLUMNS {
        1 => list.columns[3][..list.count]
            .iter()
            .copied()
            .fold(0.0, f32::max),
        _ => (0..list.count)
            .map(|i| {
                let a = |k: usize| list.columns[3 + k][i];
                // ∛det A: an ellipsoid counts as the ball of the same volume.
                (a(0) * a(3) * a(5)).cbrt()
            })
            .fold(0.0, f32::max),
    };
    1.0 / steepest
}

/// Whether a half of `cell` is small enough for bounds of second order.
fn is_close<P: Primitive>(list: &BlobList, cell: Aabb) -> bool {
    cell.size().max_element() < CLOSE_SIDE * smallest_support::<P>(list)
}

/// The longest axis of `cell` and the halves across it, the lower first.
fn halves(cell: Aabb) -> (usize, [Aabb; 2]) {
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
    context: &Context,
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

/// Builds the subtree of `cell`, whose blobs are `list`; forks threads while the list is long.
pub(super) fn build_parallel<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    context: &Context,
    cell: Aabb,
    list: &BlobList,
    stalled: u32,
    depth: u32,
) -> Subtree {
    if list.count <= PARALLEL_BLOBS || is_leaf::<S, K, P>(simd, list, cell, stalled, depth, context)
    {
        let mut builder = Builder::<K, P>::new(context);
        let root = builder.build(simd, cell, list, stalled, depth);
        let parts = if root.is_some() {
            vec![builder.part]
        } else {
            Vec::new()
        };
        return Subtree { root, parts };
    }
    let close = is_close::<P>(list, cell);
    let filtered = |half: Aabb| {
        let mut child = BlobList::default();
        let bounds = filter::<S, K, P>(simd, list, half.padded(context.pad), close, &mut child);
        (half, child, bounds)
    };
    let (axis, [low, high]) = halves(cell);
    let (low, high) = rayon::join(|| filtered(low), || filtered(high));
    let stalled = next_stalled(stalled, list, [&low.1, &high.1]);
    let build_half = |(half, child, bounds): (Aabb, BlobList, FieldBounds)| {
        if child.count == 0 || context.settled(bounds) {
            return Subtree {
                root: None,
                parts: Vec::new(),
            };
        }
        build_parallel::<S, K, P>(simd, context, half, &child, stalled, depth + 1)
    };
    let (mut low, high) = rayon::join(|| build_half(low), || build_half(high));
    let low_parts = low.parts.len() as u32;
    low.parts.extend(high.parts);
    let high_root = high.root.map(|mut root| {
        renumber_parts(&mut root, low_parts);
        root
    });
    Subtree {
        root: joined(axis, low.root, high_root),
        parts: low.parts,
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

fn renumber_parts(node: &mut BinaryNode, by: u32) {
    if by == 0 {
        return;
    }
    match node {
        BinaryNode::Split { halves, .. } => {
            for child in halves.iter_mut() {
                renumber_parts(child, by);
            }
        }
        BinaryNode::Leaf { part, .. } => *part += by,
    }
}

fn joined(axis: usize, low: Option<BinaryNode>, high: Option<BinaryNode>) -> Option<BinaryNode> {
    match (low, high) {
        (Some(low), Some(high)) => Some(BinaryNode::Split {
            bounds: low.bounds().union(high.bounds()),
            axis,
            halves: Box::new([low, high]),
        }),
        (one, other) => one.or(other),
    }
}

/// Builds one subtree on one thread; keeps a list buffer per depth.
struct Builder<'a, K, P> {
    context: &'a Context,
    part: Part,
    buffers: Vec<BlobList>,
    leaf_buffers: [BlobList; 2],
    formula: std::marker::PhantomData<(K, P)>,
}

impl<'a, K: KernelShape, P: Primitive> Builder<'a, K, P> {
    fn new(context: &'a Context) -> Self {
        Self {
            context,
            part: Part::default(),
            buffers: Vec::new(),
            leaf_buffers: Default::default(),
            formula: std::marker::PhantomData,
        }
    }

    fn build<S: Simd>(
        &mut self,
        simd: S,
        cell: Aabb,
        list: &BlobList,
        stalled: u32,
        depth: u32,
    ) -> Option<BinaryNode> {
        if is_leaf::<S, K, P>(simd, list, cell, stalled, depth, self.context) {
            let (context, part, buffers) = (self.context, &mut self.part, &mut self.leaf_buffers);
            return finish_leaf::<S, K, P>(simd, context, cell, list, buffers, &mut part.blocks)
                .map(|(bounds, block)| BinaryNode::Leaf {
                    bounds,
                    part: 0,
                    block,
                });
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
                children[i] = self.build(simd, parts[i], &lists[i], stalled, depth + 1);
            }
        }
        self.buffers.extend(lists);
        let [low, high] = children;
        joined(axis, low, high)
    }
}
