//! A field and its tree as words of 16 bytes; what they hold stands in `shaders/accel/particles.wgsl`.

use crate::chunks::Word;
use crate::shader::FieldMotion;
use meniscus::accel::cells::layout::{LANES, LEAF, LeafHeader};
use meniscus::accel::particles::ParticleTree;
use meniscus::accel::particles::layout::{Node, columns, leaf_blocks};
use meniscus::field::BlobField;
use meniscus::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use rayon::prelude::*;

/// A field and its tree, packed.
pub(crate) struct Packed {
    /// Nodes, then leaves.
    pub(crate) words: Vec<Word>,
    /// Word of the first leaf.
    pub(crate) leaves_at: u32,
    /// Most references that a ray can have waiting.
    pub(crate) stack: u32,
}

/// Words of a leaf before its blobs.
const LEAF_HEADER_WORDS: usize = 2;

/// Words of the bounds of a node's children at one time.
const BOUNDS_WORDS: usize = 12;

/// Packs a field; `None` where its words cannot be numbered in 32 bits.
pub(crate) fn pack(field: &BlobField, tree: &ParticleTree) -> Option<Packed> {
    match field.shapes {
        Shapes::Balls(_) => pack_of::<Ball>(field, tree),
        Shapes::Ellipsoids(_) => pack_of::<Ellipsoid>(field, tree),
    }
}

fn pack_of<P: Primitive>(field: &BlobField, tree: &ParticleTree) -> Option<Packed> {
    let motion = FieldMotion::of(field);
    let node_words = node_words(motion.moves());
    let blob_words = blob_words::<P>(motion);
    let leaf_words = leaf_words::<P>(motion);
    let leaves_at = tree.nodes.len() * node_words;
    let total = leaves_at + tree.leaves * leaf_words;
    u32::try_from(total).ok()?;
    let mut words = vec![[0; 4]; total];
    let (nodes, leaves) = words.split_at_mut(leaves_at);
    nodes
        .par_chunks_mut(node_words)
        .enumerate()
        .for_each(|(index, words)| pack_node(tree, index, words));
    leaves
        .par_chunks_mut(leaf_words)
        .zip(
            tree.blocks
                .par_chunks(leaf_blocks::<P>(tree.motion_columns)),
        )
        .for_each(|(words, blocks)| {
            let header = LeafHeader::from_block(&blocks[0]);
            let [x, y, z] = header.center.map(f32::to_bits);
            words[0] = [x, y, z, header.count as u32];
            words[1][0] = header.fine_beta.min(f32::MAX).to_bits();
            let column = |k: usize, lane: usize| blocks[1 + k].0[lane].to_bits();
            let blobs = words[LEAF_HEADER_WORDS..].chunks_exact_mut(blob_words);
            for (lane, words) in blobs.enumerate() {
                pack_blob::<P>(words, motion, |k| column(k, lane));
            }
        });
    Some(Packed {
        words,
        leaves_at: leaves_at as u32,
        stack: most_waiting(tree),
    })
}

/// Words of a node.
pub(crate) fn node_words(moves: bool) -> usize {
    BOUNDS_WORDS + 2 + if moves { BOUNDS_WORDS } else { 0 }
}

/// Words of a leaf.
pub(crate) fn leaf_words<P: Primitive>(motion: FieldMotion) -> usize {
    LEAF_HEADER_WORDS + LANES * blob_words::<P>(motion)
}

/// Words of a leaf's blob.
pub(crate) fn blob_words<P: Primitive>(motion: FieldMotion) -> usize {
    columns::<P>().div_ceil(4) + motion.words()
}

/// x, y, z, the shape's columns, the weight and the index follow each other; then, in words of their own,
/// threes of what moves and turns.
pub(crate) fn pack_blob<P: Primitive>(
    words: &mut [Word],
    motion: FieldMotion,
    column: impl Fn(usize) -> u32,
) {
    let columns = columns::<P>();
    for k in 0..columns {
        words[k / 4][k % 4] = column(k);
    }
    let rates = words.len() - motion.words();
    for (three, word) in words[rates..].iter_mut().enumerate() {
        for axis in 0..3 {
            word[axis] = column(columns + 3 * three + axis);
        }
    }
}

/// Boxes move straight: shaders know no curves.
fn pack_node(tree: &ParticleTree, index: usize, words: &mut [Word]) {
    let node = &tree.nodes[index];
    let [opening, closing] = tree.faces(index).straightened();
    let exists = |slot: usize| node.children[slot] != Node::NONE;
    let mut pack = |first: usize, bounds: &[[f32; 8]; 6]| {
        for (row, faces) in bounds.iter().enumerate() {
            for slot in (0..8).filter(|&slot| exists(slot)) {
                words[first + 2 * row + slot / 4][slot % 4] = faces[slot].to_bits();
            }
        }
    };
    pack(0, &opening);
    if tree.moves() {
        pack(BOUNDS_WORDS + 2, &closing);
    }
    for slot in 0..8 {
        words[BOUNDS_WORDS + slot / 4][slot % 4] = node.children[slot];
    }
}

/// The most references that wait while a ray is in any leaf: on the way there every node leaves its other
/// children behind.
fn most_waiting(tree: &ParticleTree) -> u32 {
    // Children stand behind their parents.
    let mut below = vec![0_u32; tree.nodes.len()];
    for index in (0..tree.nodes.len()).rev() {
        let children = tree.nodes[index].children;
        let count = children
            .iter()
            .filter(|&&child| child != Node::NONE)
            .count();
        let deepest = children
            .iter()
            .filter(|&&child| child != Node::NONE && child & LEAF == 0)
            .map(|&child| below[child as usize])
            .max()
            .unwrap_or(0);
        below[index] = (count as u32).max(count.saturating_sub(1) as u32 + deepest);
    }
    below.first().copied().unwrap_or(0)
}
