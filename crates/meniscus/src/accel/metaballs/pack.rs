//! From the tree of lists to flat arrays.

use super::build::{Leaf, Subtree};
use super::{Boxes, LEAF, MetaballTree, Node};
use crate::accel::cells::layout::{Block, Columns, LANES};
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use crate::scene::EngineSettings;
use glam::Vec3;
use rayon::prelude::*;

/// Where lanes without a blob lie: far from every ray.
const NOWHERE: f32 = 1e15;

/// The first block of a leaf. Behind it come chunks of [`LANES`] blobs in structure-of-arrays form: x, y,
/// z relative to the leaf's centre, the shape's columns, the weight, the blob's index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafHeader {
    /// Number of blobs.
    pub count: usize,
    /// Chunks whose projected centres are looked at: the leaf's own metaballs where boxes overlap, all
    /// where they do not.
    pub own_chunks: usize,
    /// All chunks.
    pub chunks: usize,
    /// Local position that the blobs' coordinates are relative to.
    pub center: [f32; 3],
}

impl LeafHeader {
    fn to_block(self) -> Block {
        let mut block = Block::ZERO;
        block.0[0] = f32::from_bits(self.count as u32);
        block.0[1] = f32::from_bits(self.own_chunks as u32);
        block.0[2] = f32::from_bits(self.chunks as u32);
        block.0[3..6].copy_from_slice(&self.center);
        block
    }

    /// The header in a block.
    #[inline(always)]
    pub fn from_block(block: &Block) -> Self {
        Self {
            count: block.0[0].to_bits() as usize,
            own_chunks: block.0[1].to_bits() as usize,
            chunks: block.0[2].to_bits() as usize,
            center: [block.0[3], block.0[4], block.0[5]],
        }
    }
}

/// Packs a tree whose boxes are widened by half of `pad`.
pub(super) fn pack(
    field: &BlobField,
    boxes: Boxes,
    settings: EngineSettings,
    tree: Option<Subtree>,
    pad: f32,
) -> MetaballTree {
    let chunk_blocks = match field.shapes {
        Shapes::Balls(_) => Columns::ALL.blocks_per_chunk::<Ball>(),
        Shapes::Ellipsoids(_) => Columns::ALL.blocks_per_chunk::<Ellipsoid>(),
    };
    let mut packed = MetaballTree {
        boxes,
        settings,
        nodes: Vec::new(),
        blocks: Vec::new(),
        root: None,
        bounds: tree.as_ref().map(|tree| tree.bounds().padded(pad)),
        leaves: 0,
        largest_leaf: 0,
    };
    let Some(tree) = tree else {
        return packed;
    };
    let mut flat = Flat {
        boxes,
        chunk_blocks,
        pad: 0.5 * pad,
        nodes: Vec::new(),
        leaves: Vec::new(),
        blocks: 0,
    };
    packed.root = Some(flat.add(tree));
    packed.leaves = flat.leaves.len();
    packed.blocks = vec![Block::ZERO; flat.blocks];
    let mut rest = packed.blocks.as_mut_slice();
    let mut targets = Vec::with_capacity(flat.leaves.len());
    for (leaf, header) in &flat.leaves {
        packed.largest_leaf = packed.largest_leaf.max(header.chunks * LANES);
        let (target, behind) = rest.split_at_mut(1 + header.chunks * flat.chunk_blocks);
        targets.push((target, leaf, header));
        rest = behind;
    }
    targets
        .into_par_iter()
        .for_each(|(target, leaf, header)| match field.shapes {
            Shapes::Balls(_) => fill::<Ball>(field, boxes, leaf, header, target),
            Shapes::Ellipsoids(_) => fill::<Ellipsoid>(field, boxes, leaf, header, target),
        });
    packed.nodes = flat.nodes;
    packed
}

/// Nodes in order, leaves in order, and the blocks that the leaves will take.
struct Flat {
    boxes: Boxes,
    chunk_blocks: usize,
    pad: f32,
    nodes: Vec<Node>,
    leaves: Vec<(Leaf, LeafHeader)>,
    blocks: usize,
}

impl Flat {
    /// Appends a subtree and returns the reference to it. Depth is bounded by the builder.
    fn add(&mut self, tree: Subtree) -> u32 {
        match tree {
            Subtree::Leaf(leaf) => {
                let count = leaf.own.len() + leaf.split.len();
                let own_chunks = leaf.own.len().div_ceil(LANES);
                let (own_chunks, chunks) = match self.boxes {
                    Boxes::Disjoint => (count.div_ceil(LANES), count.div_ceil(LANES)),
                    Boxes::Overlapping => {
                        (own_chunks, own_chunks + leaf.split.len().div_ceil(LANES))
                    }
                };
                let header = LeafHeader {
                    count,
                    own_chunks,
                    chunks,
                    center: leaf.bounds.center().to_array(),
                };
                let block = self.blocks as u32;
                self.blocks += 1 + chunks * self.chunk_blocks;
                self.leaves.push((leaf, header));
                LEAF | block
            }
            Subtree::Inner { children, .. } => {
                let at = self.nodes.len();
                let [first, second] = *children;
                let bounds = node_bounds([first.bounds(), second.bounds()], self.pad);
                self.nodes.push(Node {
                    bounds,
                    children: [0; 2],
                });
                self.nodes[at].children = [self.add(first), self.add(second)];
                at as u32
            }
        }
    }
}

fn node_bounds(children: [Aabb; 2], pad: f32) -> [[f32; 2]; 6] {
    let [first, second] = children.map(|bounds| bounds.padded(pad));
    let mut bounds = [[0.0; 2]; 6];
    for axis in 0..3 {
        bounds[axis] = [first.min[axis], second.min[axis]];
        bounds[3 + axis] = [first.max[axis], second.max[axis]];
    }
    bounds
}

/// Writes a leaf: its own metaballs first, the others in chunks of their own where boxes overlap.
fn fill<P: Primitive>(
    field: &BlobField,
    boxes: Boxes,
    leaf: &Leaf,
    header: &LeafHeader,
    target: &mut [Block],
) {
    target[0] = header.to_block();
    let center = Vec3::from_array(header.center);
    let per_chunk = Columns::ALL.blocks_per_chunk::<P>();
    for chunk in target[1..].chunks_exact_mut(per_chunk) {
        chunk[0] = Block([NOWHERE; LANES]);
        chunk[3].0 = [1.0; LANES];
        chunk[per_chunk - 1] = Block([f32::from_bits(u32::MAX); LANES]);
    }
    let split_from = match boxes {
        Boxes::Disjoint => leaf.own.len(),
        Boxes::Overlapping => header.own_chunks * LANES,
    };
    let slots = (leaf.own.iter().enumerate())
        .chain((leaf.split.iter().enumerate()).map(|(i, blob)| (split_from + i, blob)));
    let mut columns = [0.0; 6];
    for (slot, &blob) in slots {
        let (chunk, lane) = (1 + slot / LANES * per_chunk, slot % LANES);
        let i = blob as usize;
        // Both are f32 and close together: the difference loses at most half an ulp.
        let position = (field.center(i) - center).to_array();
        P::pack(&field.shapes, i, &mut columns[..P::COLUMNS]);
        let values = position.iter().chain(&columns[..P::COLUMNS]);
        for (k, value) in values.chain([&field.weights[i]]).enumerate() {
            target[chunk + k].0[lane] = *value;
        }
        target[chunk + per_chunk - 1].0[lane] = f32::from_bits(blob);
    }
}
