//! Cells: a tree of disjoint boxes that contain the surface, not the particles.
//!
//! Boxes proven to hold no surface (upper bound of the field below the threshold, or lower bound
//! above it) are dropped while the tree is built. Each leaf copies the blobs that reach it. Leaves
//! are disjoint, so the first one along a ray that reports a crossing ends the ray.

mod build;
mod collapse;
mod filter;
pub mod layout;
mod leaf;
pub mod traverse;

pub use build::BuildRule;

use crate::field::BlobField;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::math::simd::Level;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use crate::{at_level, with_kernel};
use build::{Context, Part, build_parallel};
use fearless_simd::Simd;
use filter::BlobList;
use layout::{Block, LEAF, Node};
use rayon::prelude::*;

/// The structure of engine `cells`.
#[derive(Debug, Default, PartialEq)]
pub struct Cells {
    /// Eight-wide nodes, root first; empty when the field has no surface.
    pub nodes: Vec<Node>,
    /// Leaves; see [`layout`].
    pub blocks: Vec<Block>,
    /// Local box around all leaves.
    pub bounds: Option<Aabb>,
    /// Most blobs in a leaf.
    pub largest_leaf: usize,
    /// Number of leaves.
    pub leaves: usize,
    /// Whether some leaves hold blobs too small for f32.
    pub has_fine_blobs: bool,
}

impl Cells {
    /// Builds the cells of `field` with the leaf rule that suits it.
    pub fn build(field: &BlobField, level: Level) -> Self {
        Self::build_with(field, level, default_rule(field))
    }

    /// Builds the cells of `field` with a stated leaf rule.
    pub fn build_with(field: &BlobField, level: Level, rule: BuildRule) -> Self {
        if field.is_empty() {
            return Self::default();
        }
        match &field.shapes {
            Shapes::Balls(_) => {
                with_kernel!(field.kernel, K => at_level!(level, simd => build::<_, K, Ball>(simd, field, rule)))
            }
            Shapes::Ellipsoids(_) => {
                with_kernel!(field.kernel, K => at_level!(level, simd => build::<_, K, Ellipsoid>(simd, field, rule)))
            }
        }
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.blocks.len() * size_of::<Block>()
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

fn build<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    field: &BlobField,
    rule: BuildRule,
) -> Cells {
    let cell = field.bounds();
    let context = Context {
        threshold: field.threshold,
        // The slab test's rounding grows with the distance travelled within the box.
        pad: 1e-6 * cell.size().length().max(cell.center().abs().max_element()),
        rule,
    };
    let list = all_blobs::<P>(field);
    let tree = build_parallel::<S, K, P>(simd, &context, cell, &list, 0, 0);
    drop(list);
    let Some(root) = tree.root else {
        return Cells::default();
    };
    let (blocks, offsets) = join_parts(tree.parts);
    let pad = 0.5 * context.pad;
    let nodes = collapse::collapse(&root, &offsets, pad);
    let leaf_counts = nodes.iter().flat_map(|node| {
        (0..8)
            .filter(|&slot| {
                node.bounds[0][slot] <= node.bounds[3][slot] && node.children[slot] & LEAF != 0
            })
            .map(|slot| &blocks[(node.children[slot] & !LEAF) as usize])
    });
    let (mut leaves, mut largest_leaf, mut has_fine_blobs) = (0, 0, false);
    for block in leaf_counts {
        let header = layout::LeafHeader::from_block(block);
        leaves += 1;
        largest_leaf = largest_leaf.max(header.count);
        has_fine_blobs |= header.fine_beta < f32::INFINITY;
    }
    Cells {
        bounds: Some(root.bounds().padded(pad)),
        nodes,
        blocks,
        largest_leaf,
        leaves,
        has_fine_blobs,
    }
}

fn all_blobs<P: Primitive>(field: &BlobField) -> BlobList {
    let mut list = BlobList::default();
    list.reset(3 + P::COLUMNS + 1, field.len());
    let mut values = [0.0; 10];
    for i in 0..field.len() {
        values[..3].copy_from_slice(&field.centers[i]);
        P::pack(&field.shapes, i, &mut values[3..3 + P::COLUMNS]);
        values[3 + P::COLUMNS] = field.weights[i];
        list.push(&values[..3 + P::COLUMNS + 1], i as u32);
    }
    list.finish();
    list
}

/// One array of all parts' blocks, and where each part begins in it.
fn join_parts(parts: Vec<Part>) -> (Vec<Block>, Vec<u32>) {
    let mut offsets = Vec::with_capacity(parts.len());
    let mut total = 0;
    for part in &parts {
        offsets.push(total as u32);
        total += part.blocks.len();
    }
    let mut blocks = vec![Block::ZERO; total];
    let mut rest = blocks.as_mut_slice();
    let mut targets = Vec::with_capacity(parts.len());
    for part in &parts {
        let (target, behind) = rest.split_at_mut(part.blocks.len());
        targets.push(target);
        rest = behind;
    }
    targets
        .into_par_iter()
        .zip(&parts)
        .for_each(|(target, part)| target.copy_from_slice(&part.blocks));
    (blocks, offsets)
}
