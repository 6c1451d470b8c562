//! Bounding volume hierarchies over metaballs (Gourmel, Pajot, Paulin, Barthe & Poulin, "Fitted BVH for
//! Fast Raytracing of Metaballs", 2010): overlapping boxes (§4) and disjoint, fitted ones (§5).
//!
//! A leaf holds its own metaballs and the split metaballs, which belong to other leaves and reach into
//! it: together they are all that is needed to evaluate the field there. Trees are binary, as in the
//! paper. Metaballs here are blobs of any kernel; ellipsoids are bounded by their support boxes.

mod build;
mod fit;
mod pack;
mod split;

use crate::accel::cells::layout::Block;
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use crate::scene::EngineSettings;
use build::Builder;

/// Marks a child reference as a leaf; the rest is the index of its header block.
pub use crate::accel::cells::layout::LEAF;
pub use pack::LeafHeader;

/// No tree is deeper: the traversal's stack relies on it.
pub const MAX_DEPTH: usize = 100;

/// Boxes are widened by this part of the structure's size: what f32 slab tests may be off.
const PAD: f32 = 1e-6;

/// How the boxes of two children lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boxes {
    /// Each around the supports of its own metaballs (§4).
    Overlapping,
    /// Parted by a plane, so that the first leaf with a hit ends a ray (§5).
    Disjoint,
}

/// Two children.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct Node {
    /// `bounds[axis]`: lower faces of both boxes, `bounds[3 + axis]`: upper faces.
    pub bounds: [[f32; 2]; 6],
    /// Index of a node, or [`LEAF`] | index of a leaf's header block.
    pub children: [u32; 2],
}

/// The structure of engines `metaball-bvh` and `fitted-bvh`.
#[derive(Debug, PartialEq)]
pub struct MetaballTree {
    /// How boxes lie.
    pub boxes: Boxes,
    /// The switches that took effect: bounds that assume a growing sum are off for negative weights.
    pub settings: EngineSettings,
    /// Nodes, children behind their parents.
    pub nodes: Vec<Node>,
    /// Leaves: a header block and chunks of blobs each; see [`LeafHeader`].
    pub blocks: Vec<Block>,
    /// The root: a node or a leaf like any child; `None` where there is no surface.
    pub root: Option<u32>,
    /// Local box around all leaves.
    pub bounds: Option<Aabb>,
    /// Number of leaves.
    pub leaves: usize,
    /// Most blobs in a leaf, padding included.
    pub largest_leaf: usize,
}

impl MetaballTree {
    /// Builds the tree of `field`, the same for any number of threads.
    pub fn build(field: &BlobField, boxes: Boxes, settings: &EngineSettings) -> Self {
        let may_bound = boxes == Boxes::Disjoint && !field.has_negative_weights();
        let settings = EngineSettings {
            fit: settings.fit && may_bound,
            rmax_boxes: settings.rmax_boxes && settings.fit && may_bound,
            discard: settings.discard && may_bound,
            ..*settings
        };
        let bounds = field.bounds();
        let size = bounds.size().length();
        let pad = PAD * size.max(bounds.center().abs().max_element());
        let tree = Builder::new(field, boxes, settings, pad).build();
        pack::pack(field, boxes, settings, tree, pad)
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.blocks.len() * size_of::<Block>()
    }
}

#[cfg(test)]
mod tests;
