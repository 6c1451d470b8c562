//! Cells: a tree of disjoint boxes that contain the surface, not the particles.
//!
//! Boxes proven to hold no surface (upper bound of the field below the threshold, or lower bound
//! above it) are dropped while the tree is built. Each leaf copies the blobs that reach it, or holds
//! their indices ([`Leaves`]). Leaves are disjoint, so the first one along a ray that reports a crossing
//! ends the ray.
//!
//! Only coarse cells are made at once. What lies below one is refined when the first ray
//! comes there, once and to the same bits whoever comes first: a picture sees a part of the surface,
//! and nothing of what is deep inside. So a cell in it that seems to lie deep is put off once more.
//!
//! Where blobs move the planes between cells move with them: every face is given when the shutter opens
//! and when it closes and is in between in proportion to the time, so that at any one time the cells are
//! disjoint boxes as ever.

#[cfg(test)]
mod bounds_tests;
mod build;
mod coarse;
mod collapse;
mod filter;
pub mod layout;
mod leaf;
mod list;
mod moving;
mod place;
mod slabs;
pub mod traverse;
mod unpack;

pub use build::BuildRule;
pub use slabs::TimedCells;
pub use unpack::Unpacked;

use crate::field::{BlobField, Span};
use crate::kernel::KernelShape;
use crate::math::aabb::{Aabb, DAabb};
use crate::particles::neighbours::BoxTree;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use crate::scene::Leaves;
use build::{BuildContext, Builder};
use coarse::CoarseBox;
use fearless_simd::Simd;
use layout::{Block, Columns, Node};
use list::BlobList;
use place::Place;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Cells for one span of time.
#[derive(Debug, Default)]
pub struct Cells {
    /// Eight-wide nodes over the coarse cells, root first; empty when the field has no surface. Leaf references are
    /// indices of coarse cells.
    pub nodes: Vec<Node>,
    coarse: Vec<CoarseCell>,
    /// Local box around all cells.
    pub bounds: Option<Aabb>,
    context: BuildContext,
    /// Over the supports in the span, where that is not all the time that the shutter is open.
    tree: Option<BoxTree>,
    /// How far blobs move in the span, in the root mean square.
    way_spacings: f32,
    refinement_nanos: AtomicU64,
}

/// Rays go together where blobs move no farther than this between their times, in spacings: others meet
/// other cells.
const WAY_APART_SPACINGS: f32 = 2.0;

/// A cell whose inside is made when the first ray comes. What rays read is one cache line.
#[derive(Debug)]
#[repr(C, align(64))]
struct CoarseCell {
    part: OnceLock<Option<Part>>,
    place: CoarseBox,
}

impl CoarseCell {
    fn all(boxes: Vec<CoarseBox>) -> Vec<Self> {
        let unrefined = |place| Self {
            place,
            part: OnceLock::new(),
        };
        boxes.into_iter().map(unrefined).collect()
    }

    /// Memory of what has been refined.
    fn refined_bytes(&self) -> usize {
        let Some(Some(part)) = self.part.get() else {
            return 0;
        };
        size_of_val(&*part.nodes)
            + size_of_val(&*part.blocks)
            + size_of_val(&*part.deep)
            + part.deep.iter().map(Self::refined_bytes).sum::<usize>()
    }
}

/// The refined inside of a coarse cell.
#[derive(Debug)]
pub struct Part {
    /// Eight-wide nodes, root first. Leaf references are indices of header blocks.
    pub nodes: Box<[Node]>,
    /// Leaves; see [`layout`].
    pub blocks: Box<[Block]>,
    /// Cells that probably are solid, so that few rays come there.
    deep: Box<[CoarseCell]>,
}

impl Cells {
    /// Builds the coarse cells of `field` in `span` with the leaf rule that suits it; `tree` holds the
    /// supports there, unless the field's does.
    fn build_in(field: &BlobField, span: Span, leaves: Leaves, tree: Option<BoxTree>) -> Self {
        if field.is_empty() {
            return Self::default();
        }
        let place = place_of(field, span);
        let bounds = place.hull();
        let context = BuildContext {
            threshold: field.threshold,
            // The slab test's rounding grows with the distance travelled within the box.
            pad: 1e-6
                * bounds
                    .size()
                    .length()
                    .max(bounds.center().abs().max_element()),
            rule: default_rule(field),
            span,
            leaves,
            stored: match field.shapes {
                Shapes::Balls(_) => Columns::of::<Ball>(field, &bounds),
                Shapes::Ellipsoids(_) => Columns::of::<Ellipsoid>(field, &bounds),
            },
        };
        let Some((root, boxes)) = coarse::split(
            (field, tree.as_ref().unwrap_or_else(|| field.support_tree())),
            &context,
            place,
        ) else {
            return Self::default();
        };
        let pad = 0.5 * context.pad;
        Self {
            nodes: collapse::collapse(&root, pad, context.stored.moves()),
            coarse: CoarseCell::all(boxes),
            bounds: Some(root.bounds().hull().padded(pad)),
            context,
            way_spacings: moving::way_spacings(field, span),
            tree,
            refinement_nanos: AtomicU64::new(0),
        }
    }

    /// Which columns the leaves store.
    #[inline(always)]
    pub fn stored(&self) -> &Columns {
        &self.context.stored
    }

    /// What the leaves hold of their blobs.
    #[inline(always)]
    pub fn leaves(&self) -> Leaves {
        self.context.leaves
    }

    /// The time that these cells are for.
    #[inline(always)]
    pub fn span(&self) -> Span {
        self.context.span
    }

    /// A time, in seconds relative to the frame, on the scale of the span, from −1 to 1; 0 where nothing
    /// moves.
    #[inline(always)]
    pub fn phase(&self, time_secs: f64) -> f32 {
        if self.stored().moves() {
            self.context.span.phase(time_secs) as f32
        } else {
            0.0
        }
    }

    /// How far apart times may lie, on the scale of [`Cells::phase`], of rays that are worth tracing
    /// together; infinite where nothing moves.
    #[inline(always)]
    pub fn phases_together(&self) -> f32 {
        2.0 * WAY_APART_SPACINGS / self.way_spacings
    }

    /// What lies in coarse cell `index` of the structure of `field`, or in deep cell `index` of a part
    /// of it; refined if this is the first question. `None`: no surface.
    #[inline(always)]
    pub fn part<'a, S: Simd, K: KernelShape, P: Primitive>(
        &'a self,
        simd: S,
        field: &BlobField,
        within: Option<&'a Part>,
        index: u32,
    ) -> Option<&'a Part> {
        let cells = within.map_or(&*self.coarse, |part| &part.deep);
        let CoarseCell { part, place } = &cells[index as usize];
        let part = match part.get() {
            Some(part) => part,
            None => part.get_or_init(
                #[cold]
                || self.refined::<S, K, P>(simd, field, place, within.is_none()),
            ),
        };
        part.as_ref()
    }

    /// Refines a cell; `leave_deep` puts off what lies deep inside once more.
    #[inline(never)]
    fn refined<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
        field: &BlobField,
        place: &CoarseBox,
        leave_deep: bool,
    ) -> Option<Part> {
        let start = Instant::now();
        let CoarseBox { place, depth } = *place;
        let BuildContext {
            pad, stored, span, ..
        } = self.context;
        let tree = self.tree.as_ref().unwrap_or_else(|| field.support_tree());
        let mut list = BlobList::default();
        let reaching = blobs_reaching(tree, place.hull().padded(pad));
        list.fill::<P>(field, span, stored, &reaching);
        if place.moves() {
            // Most of them reach it at some time only by the box of their whole way.
            let mut reaching = BlobList::default();
            list.pieces = 1;
            let place = place.padded(pad);
            filter::filter::<S, K, P>(simd, &list, &place, false, &mut reaching, |_| false);
            list = reaching;
        }
        let builder = Builder::<K, P>::new(&self.context, leave_deep);
        let part = builder
            .build(simd, place, &mut list, depth)
            .map(|built| Part {
                nodes: collapse::collapse(&built.root, 0.5 * pad, stored.moves()).into(),
                blocks: built.blocks.into(),
                deep: CoarseCell::all(built.deep).into(),
            });
        let nanos = start.elapsed().as_nanos() as u64;
        self.refinement_nanos.fetch_add(nanos, Ordering::Relaxed);
        part
    }

    /// Time that threads have spent on refinement so far, summed over them.
    pub fn refinement_secs(&self) -> f64 {
        self.refinement_nanos.load(Ordering::Relaxed) as f64 * 1e-9
    }

    /// Memory held now.
    pub fn structure_bytes(&self) -> usize {
        let refined: usize = self.coarse.iter().map(CoarseCell::refined_bytes).sum();
        self.nodes.capacity() * size_of::<Node>()
            + self.coarse.capacity() * size_of::<CoarseCell>()
            + self.tree.as_ref().map_or(0, BoxTree::bytes)
            + refined
    }
}

/// The box around all supports in `span`.
fn place_of(field: &BlobField, span: Span) -> Place {
    if field.motion.is_none() {
        return Place::still(field.bounds());
    }
    let ends = (0..field.len())
        .into_par_iter()
        .map(|i| field.motion_boxes_in(span, i).ends)
        .reduce(
            || [Aabb::EMPTY; 2],
            |a, b| [a[0].union(b[0]), a[1].union(b[1])],
        );
    let pad = 1e-6 * ends[0].union(ends[1]).size().max_element();
    Place { ends }.padded(pad)
}

/// Leaf constants by how many supports overlap: dense fluids want small leaves, sparse sets large.
fn default_rule(field: &BlobField) -> BuildRule {
    if matches!(field.shapes, Shapes::Ellipsoids(_)) {
        return BuildRule {
            few_blobs: 192,
            few_side: 6.0,
            smallest_side: 1.0,
            deep: f32::INFINITY,
        };
    }
    let supports = (0..field.len())
        .map(|i| field.shapes.mean_radius(i))
        .sum::<f64>()
        / field.len() as f64;
    if supports > 1.5 * f64::from(field.spacing) {
        BuildRule {
            few_blobs: 256,
            few_side: 3.0,
            smallest_side: 0.35,
            deep: 1.5,
        }
    } else {
        BuildRule {
            few_blobs: 96,
            few_side: 8.0,
            smallest_side: 1.0,
            deep: f32::INFINITY,
        }
    }
}

/// The blobs whose support may reach `region`, with some that do not.
fn blobs_reaching(tree: &BoxTree, region: Aabb) -> Vec<u32> {
    let region = DAabb {
        min: region.min.as_dvec3(),
        max: region.max.as_dvec3(),
    };
    let mut blobs = Vec::new();
    tree.for_each_group_overlapping(&region, |group| blobs.extend_from_slice(group));
    blobs
}
