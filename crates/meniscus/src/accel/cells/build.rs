//! Refines a coarse cell: split at midpoints, drop what is proven empty or solid.

use super::coarse::CoarseBox;
use super::filter::{self, FieldBounds, filter};
use super::layout::{Block, Columns, DEEP};
use super::leaf::{FINEST_PART, finish_leaf};
use super::list::BlobList;
use super::moving::{self, drift, pieces_for};
use super::place::Place;
use crate::field::Span;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::primitive::Primitive;
use crate::scene::Leaves;
use fearless_simd::Simd;
use glam::Vec3;

/// When a cell is small enough, and how hard leaves are trimmed. Lengths are in support radii of
/// the leaf's own smallest blob unless they say otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BuildRule {
    /// A cell of at most this many blobs and below `few_side` is a leaf.
    pub few_blobs: usize,
    /// See `few_blobs`; in radii of the largest of unlike balls, as far as the smallest allows.
    pub few_side: f32,
    /// A cell below this side is a leaf however many blobs it has.
    pub smallest_side: f32,
    /// A cell whose field is this many times the threshold at points `few_side` apart probably is solid:
    /// it is put off, and when a ray comes split down to `smallest_side`.
    pub deep: f32,
}

/// Splits in a row, one per axis, that may leave both children's lists as long as the parent's.
pub(super) const STALLED_SPLITS: u32 = 3;

/// Leaves of few unlike balls are below this side, in supports of the smallest, so that none is left to
/// float64.
const FINE_SIDE: f32 = FINEST_PART - 4.0;

/// Cells below this side, in supports, try bounds of second order.
const CLOSE_SIDE: f32 = 2.0;

/// No tree is deeper: the traversal's stack relies on it.
pub(super) const MAX_DEPTH: u32 = 96;

/// Binary tree of the cells that may contain surface.
#[derive(Debug)]
pub(super) enum BinaryNode {
    /// Two subtrees, the lower first, the axis that parts them and the box around them.
    Split {
        bounds: Place,
        axis: usize,
        halves: Box<[BinaryNode; 2]>,
    },
    /// A leaf: its box, and its header block, or its place among the coarse cells, or [`DEEP`] and
    /// its place among the cells put off.
    Leaf { bounds: Place, block: u32 },
}

impl BinaryNode {
    pub(super) fn bounds(&self) -> Place {
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
    /// The time that the cells are for.
    pub(super) span: Span,
    /// What leaves hold of their blobs.
    pub(super) leaves: Leaves,
}

impl BuildContext {
    /// Whether bounds prove that a box holds no surface.
    pub(super) fn settled(&self, bounds: FieldBounds) -> bool {
        bounds.upper < self.threshold || bounds.lower > self.threshold * (1.0 + 1e-4)
    }
}

/// What a blob's support follows from: the larger, the smaller it is.
fn steepness_of<P: Primitive>(shape: &[f32]) -> f32 {
    P::DIAGONAL.iter().map(|&k| shape[k]).product()
}

/// The support that goes with a steepness; an ellipsoid counts as the ball of the same volume.
fn support_from<P: Primitive>(steepness: f32) -> f32 {
    1.0 / match P::DIAGONAL.len() {
        1 => steepness,
        _ => steepness.cbrt(),
    }
}

/// The list's smallest support.
fn smallest_support<P: Primitive>(list: &BlobList) -> f32 {
    support_from::<P>(-list.smallest_of_shapes::<P>(|shape| -steepness_of::<P>(shape)))
}

/// The lengths by which leaves are measured: the smallest support and the largest, each widened by how the
/// blob moves against the cell.
fn leaf_scales<S: Simd, P: Primitive>(simd: S, list: &BlobList, cell: &Place) -> [f32; 2] {
    if list.stored.moves() {
        return moving::leaf_scales::<S, P>(simd, list, cell, |shape| {
            support_from::<P>(steepness_of::<P>(shape))
        });
    }
    let smallest = smallest_support::<P>(list);
    if list.stored.shape.is_some() {
        return [smallest; 2];
    }
    let least_steep = list.smallest_of_shapes::<P>(steepness_of::<P>);
    [smallest, support_from::<P>(least_steep)]
}

/// The side below which few blobs are a leaf. Among balls of unlike radii it is the largest that fills it,
/// and smaller leaves would only repeat it; but the smallest must not become too small for f32.
fn few_side<P: Primitive>(list: &BlobList, [smallest, largest]: [f32; 2], rule: &BuildRule) -> f32 {
    let by_smallest = rule.few_side * smallest;
    if P::BETA_TURNS || list.stored.shape.is_some() {
        return by_smallest;
    }
    let fine = FINE_SIDE * smallest_support::<P>(list);
    by_smallest.max((rule.few_side * largest).min(fine))
}

/// Whether a half of `cell` is small enough for bounds of second order.
fn is_close<P: Primitive>(list: &BlobList, cell: &Place) -> bool {
    cell.middle().size().max_element() < CLOSE_SIDE * smallest_support::<P>(list)
}

/// The axis along which `size` is longest.
pub(super) fn longest_axis(size: Vec3) -> usize {
    if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    }
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
    cell: &Place,
    (stalled, depth): (u32, u32),
    context: &BuildContext,
) -> Step {
    let scales = leaf_scales::<S, P>(simd, list, cell);
    let support = scales[0];
    let middle = cell.middle();
    let side = middle.size().max_element();
    let rule = &context.rule;
    if side < rule.smallest_side * support
        || stalled >= STALLED_SPLITS
        // Smaller cells would drown in their own rounding margin.
        || side < 32.0 * context.pad
        || depth >= MAX_DEPTH
    {
        return Step::Finish;
    }
    if seems_deep::<S, K, P>(simd, list, middle, rule.few_side * support, context) {
        Step::PutOff
    } else if list.count <= rule.few_blobs && side < few_side::<P>(list, scales, rule) {
        Step::Finish
    } else {
        Step::Split
    }
}

/// Points along each axis that are looked at to tell whether a cell lies deep; larger cells never do.
const MOST_PROBES: usize = 8;

/// Whether the field is far above the threshold at points spread over a cell, no farther apart than
/// `distance`.
fn seems_deep<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    cell: Aabb,
    distance: f32,
    context: &BuildContext,
) -> bool {
    let size = cell.size();
    if context.rule.deep.is_infinite() || size.max_element() > MOST_PROBES as f32 * distance {
        return false;
    }
    let [nx, ny, nz] = size.to_array().map(|side| (side / distance) as usize + 1);
    (0..nx * ny * nz).all(|probe| {
        let place = [probe % nx, probe / nx % ny, probe / (nx * ny)];
        let mut point = cell.min;
        for (axis, count) in [nx, ny, nz].into_iter().enumerate() {
            point[axis] += size[axis] * (place[axis] as f32 + 0.5) / count as f32;
        }
        let value = filter::field_value::<S, K, P>(simd, list, point);
        value >= context.rule.deep * context.threshold
    })
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

/// Builds one subtree; keeps list buffers per depth.
pub(super) struct Builder<'a, K, P> {
    context: &'a BuildContext,
    leave_deep: bool,
    blocks: Vec<Block>,
    deep: Vec<CoarseBox>,
    #[allow(
        clippy::vec_box,
        reason = "lists are large to move in and out of the vector"
    )]
    buffers: Vec<Box<[BlobList; 2]>>,
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
        cell: Place,
        list: &mut BlobList,
        depth: u32,
    ) -> Option<Built> {
        // Whoever comes to a cell that lies deep as a whole wants its inside.
        self.leave_deep &=
            next_step::<S, K, P>(simd, list, &cell, (0, depth), self.context) != Step::PutOff;
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
        cell: Place,
        list: &mut BlobList,
        stalled: u32,
        depth: u32,
    ) -> Option<BinaryNode> {
        let step = next_step::<S, K, P>(simd, list, &cell, (stalled, depth), self.context);
        if step == Step::PutOff && self.leave_deep {
            let index = self.deep.len() as u32;
            self.deep.push(CoarseBox { place: cell, depth });
            return Some(BinaryNode::Leaf {
                bounds: cell,
                block: DEEP | index,
            });
        }
        list.pieces = pieces_for::<S, P>(simd, list, &cell, smallest_support::<P>(list));
        if step == Step::Finish {
            let kept = &mut self.leaf_buffer;
            return finish_leaf::<S, K, P>(simd, self.context, cell, list, kept, &mut self.blocks)
                .map(|(bounds, block)| BinaryNode::Leaf { bounds, block });
        }
        let close = is_close::<P>(list, &cell);
        let axis = longest_axis(cell.middle().size());
        let parts = cell.parted(axis, drift::<P>(list, &cell, axis));
        let mut lists = self.buffers.pop().unwrap_or_default();
        let context = self.context;
        let are_settled = [0, 1].map(|i| {
            let place = parts[i].padded(context.pad);
            let settled = |bounds| context.settled(bounds);
            filter::<S, K, P>(simd, list, &place, close, &mut lists[i], settled)
        });
        let stalled = next_stalled(stalled, list, [&lists[0], &lists[1]]);
        let mut children = [None, None];
        for i in 0..2 {
            if lists[i].count > 0 && !are_settled[i] {
                children[i] = self.subtree(simd, parts[i], &mut lists[i], stalled, depth + 1);
            }
        }
        self.buffers.push(lists);
        match children {
            [Some(low), Some(high)] => Some(BinaryNode::joined(axis, low, high)),
            [one, other] => one.or(other),
        }
    }
}
