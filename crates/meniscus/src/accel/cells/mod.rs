//! Cells: a tree of disjoint boxes that contain the surface, not the particles.
//!
//! Boxes proven to hold no surface (upper bound of the field below the threshold, or lower bound
//! above it) are dropped while the tree is built. Each leaf copies the blobs that reach it. Leaves
//! are disjoint, so the first one along a ray that reports a crossing ends the ray.
//!
//! Only coarse cells are made at once. What lies below one is refined when the first ray
//! comes there, once and to the same bits whoever comes first: a picture sees a part of the surface,
//! and nothing of what is deep inside.

mod build;
mod coarse;
mod collapse;
mod filter;
pub mod layout;
mod leaf;
pub mod traverse;

pub use build::BuildRule;

use crate::field::BlobField;
use crate::kernel::KernelShape;
use crate::math::aabb::{Aabb, DAabb};
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use build::{BuildContext, Builder};
use coarse::CoarseBox;
use fearless_simd::Simd;
use filter::BlobList;
use layout::{Block, Columns, Node};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// The structure of engine `cells`.
#[derive(Debug, Default)]
pub struct Cells {
    /// Eight-wide nodes over the coarse cells, root first; empty when the field has no surface. Leaf
    /// references are indices of coarse cells.
    pub nodes: Vec<Node>,
    coarse: Vec<CoarseCell>,
    /// Local box around all cells.
    pub bounds: Option<Aabb>,
    context: BuildContext,
    refinement_nanos: AtomicU64,
}

/// A coarse cell and what lies below it once a ray has come.
#[derive(Debug)]
struct CoarseCell {
    place: CoarseBox,
    part: OnceLock<Option<Box<Part>>>,
}

/// The refined inside of a coarse cell.
#[derive(Debug, PartialEq)]
pub struct Part {
    /// Eight-wide nodes, root first. Leaf references are indices of header blocks.
    pub nodes: Vec<Node>,
    /// Leaves; see [`layout`].
    pub blocks: Vec<Block>,
}

impl Cells {
    /// Builds the coarse cells of `field` with the leaf rule that suits it.
    pub fn build(field: &BlobField) -> Self {
        Self::build_with(field, default_rule(field))
    }

    /// Builds the coarse cells of `field` with a stated leaf rule.
    pub fn build_with(field: &BlobField, rule: BuildRule) -> Self {
        if field.is_empty() {
            return Self::default();
        }
        let bounds = field.bounds();
        let context = BuildContext {
            threshold: field.threshold,
            // The slab test's rounding grows with the distance travelled within the box.
            pad: 1e-6
                * bounds
                    .size()
                    .length()
                    .max(bounds.center().abs().max_element()),
            rule,
            stored: match field.shapes {
                Shapes::Balls(_) => Columns::of::<Ball>(field, &bounds),
                Shapes::Ellipsoids(_) => Columns::of::<Ellipsoid>(field, &bounds),
            },
        };
        let mut boxes = Vec::new();
        let Some(root) = coarse::split(field, &context, bounds, &mut boxes) else {
            return Self::default();
        };
        let pad = 0.5 * context.pad;
        Self {
            nodes: collapse::collapse(&root, pad),
            coarse: boxes
                .into_iter()
                .map(|place| CoarseCell {
                    place,
                    part: OnceLock::new(),
                })
                .collect(),
            bounds: Some(root.bounds().padded(pad)),
            context,
            refinement_nanos: AtomicU64::new(0),
        }
    }

    /// Which columns the leaves store.
    #[inline(always)]
    pub fn stored(&self) -> &Columns {
        &self.context.stored
    }

    /// What lies below coarse cell `index` of the structure of `field`; refined if this is the first
    /// question. `None`: no surface.
    #[inline(always)]
    pub fn part<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
        field: &BlobField,
        index: u32,
    ) -> Option<&Part> {
        let part = &self.coarse[index as usize].part;
        let part = match part.get() {
            Some(part) => part,
            None => part.get_or_init(
                #[cold]
                || self.refined::<S, K, P>(simd, field, index),
            ),
        };
        part.as_deref()
    }

    #[inline(never)]
    fn refined<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
        field: &BlobField,
        index: u32,
    ) -> Option<Box<Part>> {
        let start = Instant::now();
        let CoarseBox { bounds, depth } = self.coarse[index as usize].place;
        let list = blobs_reaching::<P>(field, self.context.stored, bounds.padded(self.context.pad));
        let builder = Builder::<K, P>::new(&self.context);
        let part = builder
            .build(simd, bounds, &list, depth)
            .map(|(root, blocks)| {
                Box::new(Part {
                    nodes: collapse::collapse(&root, 0.5 * self.context.pad),
                    blocks,
                })
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
        let parts = self
            .coarse
            .iter()
            .filter_map(|cell| cell.part.get()?.as_deref());
        let refined: usize = parts
            .map(|part| {
                size_of::<Part>()
                    + part.nodes.capacity() * size_of::<Node>()
                    + part.blocks.capacity() * size_of::<Block>()
            })
            .sum();
        self.nodes.capacity() * size_of::<Node>()
            + self.coarse.capacity() * size_of::<CoarseCell>()
            + refined
    }
}

/// Leaf constants by how many supports overlap: dense fluids want small leaves, sparse sets large.
fn default_rule(field: &BlobField) -> BuildRule {
    if matches!(field.shapes, Shapes::Ellipsoids(_)) {
        return BuildRule {
            few_blobs: 128,
            few_side: 4.0,
            smallest_side: 1.5,
            deep: f32::INFINITY,
        };
    }
    let supports = (0..field.len())
        .map(|i| field.shapes.mean_radius(i))
        .sum::<f64>()
        / field.len() as f64;
    if supports > 1.5 * f64::from(field.spacing) {
        BuildRule {
            few_blobs: 128,
            few_side: 2.0,
            smallest_side: 0.7,
            deep: 1.5,
        }
    } else {
        BuildRule {
            few_blobs: 64,
            few_side: 4.0,
            smallest_side: 1.0,
            deep: f32::INFINITY,
        }
    }
}

/// The blobs whose support may reach `region`, with some that do not.
fn blobs_reaching<P: Primitive>(field: &BlobField, stored: Columns, region: Aabb) -> BlobList {
    let region = DAabb {
        min: region.min.as_dvec3(),
        max: region.max.as_dvec3(),
    };
    let mut blobs = Vec::new();
    let tree = field.support_tree();
    tree.for_each_group_overlapping(&region, |group| blobs.extend_from_slice(group));
    let mut list = BlobList::default();
    list.fill::<P>(field, stored, &blobs);
    list
}
