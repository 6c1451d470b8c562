//! Which particles share a leaf, and which leaves a node: decided top down, by a rule that parts a
//! range of particles in two.

use super::layout::Node;
use crate::accel::cells::layout::{LANES, LEAF};
use rayon::prelude::*;
use std::ops::Range;

/// Particles per leaf at most: one chunk.
pub(super) const LEAF_BLOBS: usize = LANES;

/// Longer ranges are built on several threads. Fixed, so that the tree does not depend on the number
/// of threads.
const PARALLEL: usize = 1 << 13;

/// How a builder parts particles.
pub(super) trait Split: Sync {
    /// Ranges of at most this many particles become one node of leaves, which are then well filled.
    const BOTTOM_BLOBS: usize;

    /// What stands for a particle while the tree is built.
    type Item: Copy + Send + Sync;

    /// Reorders more than [`LEAF_BLOBS`] items so that two non-empty groups follow each other;
    /// returns the size of the first.
    fn split(&self, items: &mut [Self::Item]) -> usize;
}

/// A tree without boxes.
#[derive(Debug, Default)]
pub(super) struct Topology {
    /// In depth-first order, root first; only `children` are set.
    pub(super) nodes: Vec<Node>,
    /// The leaves' ranges of items.
    pub(super) leaves: Vec<Range<usize>>,
}

impl Topology {
    /// The tree over `items`, which it reorders.
    pub(super) fn build<S: Split>(splitter: &S, items: &mut [S::Item]) -> Self {
        let mut tree = Self::default();
        if !items.is_empty() {
            tree.add_node(splitter, items, 0);
        }
        tree
    }

    /// Appends the subtree of `items`, of which the first is item `first` of all.
    fn add_node<S: Split>(&mut self, splitter: &S, items: &mut [S::Item], first: usize) {
        let index = self.nodes.len();
        self.nodes.push(Node::EMPTY);
        let parallel = items.len() > PARALLEL;
        let mut groups = groups_of(splitter, items);
        let mut firsts = [first; 8];
        for slot in 1..groups.len() {
            firsts[slot] = firsts[slot - 1] + groups[slot - 1].len();
        }
        if parallel {
            let parts: Vec<Self> = groups
                .into_par_iter()
                .zip(&firsts[..])
                .map(|(group, &first)| {
                    let mut part = Self::default();
                    part.add_child(splitter, group, first);
                    part
                })
                .collect();
            for (slot, part) in parts.into_iter().enumerate() {
                self.nodes[index].children[slot] = self.append(part);
            }
        } else {
            for (slot, group) in groups.drain(..).enumerate() {
                self.nodes[index].children[slot] = self.add_child(splitter, group, firsts[slot]);
            }
        }
    }

    /// Appends a leaf or subtree and returns its reference.
    fn add_child<S: Split>(&mut self, splitter: &S, items: &mut [S::Item], first: usize) -> u32 {
        if items.len() <= LEAF_BLOBS {
            self.leaves.push(first..first + items.len());
            LEAF | (self.leaves.len() - 1) as u32
        } else {
            let index = self.nodes.len() as u32;
            self.add_node(splitter, items, first);
            index
        }
    }

    /// Appends another tree and returns the reference of its root: its first node, or its only leaf.
    fn append(&mut self, part: Self) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let root = if part.nodes.is_empty() {
            LEAF | leaves
        } else {
            nodes
        };
        self.nodes.extend(part.nodes.into_iter().map(|mut node| {
            for child in &mut node.children {
                if *child != Node::NONE {
                    *child += if *child & LEAF != 0 { leaves } else { nodes };
                }
            }
            node
        }));
        self.leaves.extend(part.leaves);
        root
    }
}

/// Two to eight groups of `items` (one, if they fit into a leaf): halves of the largest group that is
/// worth a node, as long as there are fewer than eight.
fn groups_of<'a, S: Split>(splitter: &S, items: &'a mut [S::Item]) -> Vec<&'a mut [S::Item]> {
    if items.len() > PARALLEL {
        return eighths(splitter, items, 3);
    }
    let enough = if items.len() > S::BOTTOM_BLOBS {
        S::BOTTOM_BLOBS
    } else {
        LEAF_BLOBS
    };
    let mut groups = vec![items];
    while groups.len() < 8 {
        let largest = (0..groups.len())
            .max_by_key(|&slot| (groups[slot].len(), std::cmp::Reverse(slot)))
            .filter(|&slot| groups[slot].len() > enough);
        let Some(slot) = largest else { break };
        let group = std::mem::take(&mut groups[slot]);
        let middle = splitter.split(group);
        let (low, high) = group.split_at_mut(middle);
        groups[slot] = low;
        groups.insert(slot + 1, high);
    }
    groups
}

/// Halves of halves of halves, on several threads.
fn eighths<'a, S: Split>(
    splitter: &S,
    items: &'a mut [S::Item],
    levels: u32,
) -> Vec<&'a mut [S::Item]> {
    if levels == 0 || items.len() <= S::BOTTOM_BLOBS {
        return vec![items];
    }
    let middle = splitter.split(items);
    let (low, high) = items.split_at_mut(middle);
    let (mut low, high) = rayon::join(
        || eighths(splitter, low, levels - 1),
        || eighths(splitter, high, levels - 1),
    );
    low.extend(high);
    low
}
