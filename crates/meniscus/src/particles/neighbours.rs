//! Which boxes contain a point, which overlap a box: a bounding volume hierarchy for supports whose
//! sizes may lie many orders of magnitude apart.
//!
//! Items are first parted by size, two octaves to a class, so that no large box blows up a node of
//! small ones; within a class they are sorted along a Morton curve (Karras 2012) and split where the
//! highest differing bit changes. Memory is linear in the number of items. Nodes stand in depth-first
//! order, each with the distance to the node after its subtree, so a query needs no stack.

use crate::math::aabb::DAabb;
use crate::math::morton;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Items per leaf at most.
const LEAF_SIZE: usize = 16;
/// Below this many items a subtree is built by one thread.
const SEQUENTIAL: usize = 1 << 14;
/// Bits per axis of a Morton code: with an item's index it fills 64 bits, and a cell that still holds
/// many items gets a curve of its own.
const MORTON_BITS: u32 = 10;

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: DAabb,
    /// Distance to the node after this subtree; 1 in leaves.
    skip: u32,
    /// First entry of `order` and number of entries; 0 entries in interior nodes.
    first: u32,
    count: u32,
}

/// A hierarchy over boxes, given by index. Two trees of the same boxes are equal, whatever the number
/// of threads.
#[derive(Debug, Clone)]
pub struct BoxTree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl BoxTree {
    /// A tree of the boxes `bounds(0)` … `bounds(count - 1)`, all finite and none empty.
    pub fn build(count: usize, bounds: impl Fn(usize) -> DAabb + Sync) -> Self {
        let mut keyed: Vec<(i32, u32)> = (0..count as u32)
            .into_par_iter()
            .map(|i| (size_class(&bounds(i as usize)), i))
            .collect();
        let several = keyed.iter().any(|(class, _)| *class != keyed[0].0);
        if several {
            keyed.par_sort_unstable();
        }
        let mut order: Vec<u32> = keyed.iter().map(|(_, i)| *i).collect();
        let mut nodes = Vec::new();
        let mut first = 0;
        for members in keyed.chunk_by(|a, b| a.0 == b.0) {
            let range = first..first + members.len();
            subtree(&mut order[range.clone()], first as u32, &bounds, &mut nodes);
            first = range.end;
        }
        Self { nodes, order }
    }

    /// The same hierarchy around other boxes: right for any, good for boxes with the same centres and
    /// similar sizes.
    #[must_use]
    pub fn refitted(&self, bounds: impl Fn(usize) -> DAabb + Sync) -> Self {
        let mut tree = self.clone();
        let order = &tree.order;
        tree.nodes.par_iter_mut().for_each(|node| {
            if node.count > 0 {
                node.bounds = union_of(leaf_items(order, node), &bounds);
            }
        });
        // Children follow their parent, so going backwards meets them first.
        for i in (0..tree.nodes.len()).rev() {
            if tree.nodes[i].count == 0 {
                let second = i + 1 + tree.nodes[i + 1].skip as usize;
                tree.nodes[i].bounds = tree.nodes[i + 1].bounds.union(tree.nodes[second].bounds);
            }
        }
        tree
    }

    /// All items along the curve, in the order of [`BoxTree::groups`].
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The same hierarchy with items renamed by their place in [`BoxTree::order`].
    #[must_use]
    pub fn ranked(&self) -> Self {
        Self {
            nodes: self.nodes.clone(),
            order: (0..self.order.len() as u32).collect(),
        }
    }

    /// Calls `visit` with each leaf whose box passes `enter`; whole subtrees that fail are skipped.
    #[inline]
    fn for_each_leaf<'a>(
        &'a self,
        mut enter: impl FnMut(&DAabb) -> bool,
        mut visit: impl FnMut(&'a [u32]),
    ) {
        self.for_each_range(&mut enter, |_, range| visit(&self.order[range]));
    }

    /// Calls `visit` with every item whose box contains `point`, and with some whose box does not:
    /// the caller tests. The order is fixed.
    #[inline]
    pub fn for_each_containing(&self, point: DVec3, mut visit: impl FnMut(u32)) {
        self.for_each_leaf(
            |bounds| bounds.min.cmple(point).all() && point.cmple(bounds.max).all(),
            |items| items.iter().for_each(|&item| visit(item)),
        );
    }

    /// Calls `visit` with groups of items that hold all those whose box overlaps `region`.
    #[inline]
    pub fn for_each_group_overlapping<'a>(&'a self, region: &DAabb, visit: impl FnMut(&'a [u32])) {
        self.for_each_leaf(
            |bounds| bounds.min.cmple(region.max).all() && region.min.cmple(bounds.max).all(),
            visit,
        );
    }

    /// Calls `visit` with the box and the range of [`BoxTree::order`] of each leaf whose box, and whose
    /// ancestors' boxes, pass `enter`.
    #[inline]
    pub fn for_each_range(
        &self,
        mut enter: impl FnMut(&DAabb) -> bool,
        mut visit: impl FnMut(&DAabb, Range<usize>),
    ) {
        let mut i = 0;
        while let Some(node) = self.nodes.get(i) {
            if enter(&node.bounds) {
                if node.count > 0 {
                    visit(&node.bounds, leaf_range(node));
                }
                i += 1;
            } else {
                i += node.skip as usize;
            }
        }
    }

    /// The ranges of [`BoxTree::order`] that the leaves hold, with their boxes.
    pub fn ranges(&self) -> impl Iterator<Item = (&DAabb, Range<usize>)> {
        let leaves = self.nodes.iter().filter(|node| node.count > 0);
        leaves.map(|node| (&node.bounds, leaf_range(node)))
    }

    /// The leaves: groups of items near each other, in order along the curve.
    pub fn groups(&self) -> impl Iterator<Item = &[u32]> {
        self.leaves().map(|(_, items)| items)
    }

    /// [`BoxTree::groups`] with the boxes around them.
    pub fn leaves(&self) -> impl Iterator<Item = (&DAabb, &[u32])> {
        let leaves = self.nodes.iter().filter(|node| node.count > 0);
        leaves.map(|node| (&node.bounds, leaf_items(&self.order, node)))
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>() + self.order.len() * size_of::<u32>()
    }
}

fn leaf_range(node: &Node) -> Range<usize> {
    node.first as usize..(node.first + node.count) as usize
}

fn leaf_items<'a>(order: &'a [u32], node: &Node) -> &'a [u32] {
    &order[leaf_range(node)]
}

fn union_of(items: &[u32], bounds: &impl Fn(usize) -> DAabb) -> DAabb {
    items.iter().fold(DAabb::EMPTY, |union, &item| {
        union.union(bounds(item as usize))
    })
}

/// Two octaves of the longest edge; all points share one class.
fn size_class(bounds: &DAabb) -> i32 {
    let edge = bounds.size().max_element();
    if edge > 0.0 {
        edge.log2().div_euclid(2.0) as i32
    } else {
        i32::MIN
    }
}

/// Midpoint that does not overflow.
fn center(bounds: &DAabb) -> DVec3 {
    bounds.min * 0.5 + bounds.max * 0.5
}

/// Sorts `items` along the curve and appends the nodes over them; `first` is their place in the order.
fn subtree(
    items: &mut [u32],
    first: u32,
    bounds: &(impl Fn(usize) -> DAabb + Sync),
    nodes: &mut Vec<Node>,
) {
    let centers = items
        .par_iter()
        .with_min_len(SEQUENTIAL)
        .map(|&item| {
            let center = center(&bounds(item as usize));
            DAabb {
                min: center,
                max: center,
            }
        })
        .reduce(|| DAabb::EMPTY, DAabb::union);
    let mut coded: Vec<u64> = items
        .par_iter()
        .with_min_len(SEQUENTIAL)
        .map(|&item| morton(center(&bounds(item as usize)), &centers) << 32 | u64::from(item))
        .collect();
    if coded.len() > SEQUENTIAL {
        coded.par_sort_unstable();
    } else {
        coded.sort_unstable();
    }
    for (item, sorted) in items.iter_mut().zip(&coded) {
        *item = *sorted as u32;
    }
    split(items, &coded, first, bounds, nodes);
}

/// Appends the nodes over items that stand in the order of `codes`, each a Morton code above its item.
fn split(
    items: &mut [u32],
    codes: &[u64],
    first: u32,
    bounds: &(impl Fn(usize) -> DAabb + Sync),
    nodes: &mut Vec<Node>,
) {
    let count = items.len();
    if count <= LEAF_SIZE {
        nodes.push(leaf(items, first, bounds));
        return;
    }
    let differing = (codes[0] ^ codes[count - 1]) >> 32;
    let middle = if differing == 0 {
        let place = |item: u32| center(&bounds(item as usize));
        let start = place(items[0]);
        if items.iter().any(|&item| place(item) != start) {
            // A cluster far smaller than the whole gets a curve of its own.
            subtree(items, first, bounds, nodes);
            return;
        }
        count / 2
    } else {
        let bit = 1_u64 << (32 + differing.ilog2());
        codes.partition_point(|code| code & bit == 0)
    };
    let root = nodes.len();
    nodes.push(Node {
        bounds: DAabb::EMPTY,
        skip: 0,
        first,
        count: 0,
    });
    let (low, high) = items.split_at_mut(middle);
    let (low_codes, high_codes) = codes.split_at(middle);
    let high_first = first + middle as u32;
    let second;
    if count > SEQUENTIAL {
        let mut high_nodes = Vec::new();
        rayon::join(
            || split(low, low_codes, first, bounds, nodes),
            || split(high, high_codes, high_first, bounds, &mut high_nodes),
        );
        second = nodes.len();
        nodes.append(&mut high_nodes);
    } else {
        split(low, low_codes, first, bounds, nodes);
        second = nodes.len();
        split(high, high_codes, high_first, bounds, nodes);
    }
    nodes[root].bounds = nodes[root + 1].bounds.union(nodes[second].bounds);
    nodes[root].skip = (nodes.len() - root) as u32;
}

fn leaf(items: &[u32], first: u32, bounds: &impl Fn(usize) -> DAabb) -> Node {
    Node {
        bounds: union_of(items, bounds),
        skip: 1,
        first,
        count: items.len() as u32,
    }
}

/// The Morton code of `point` within `bounds`.
fn morton(point: DVec3, bounds: &DAabb) -> u64 {
    let cells = f64::from(1_u32 << MORTON_BITS);
    // Halves, so that the extent of finite coordinates is finite; one scale for all axes.
    let extent = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
    let cell = (point * 0.5 - bounds.min * 0.5) / extent * cells;
    // A cast from f64 saturates, and takes NaN (no extent) to 0.
    morton::morton(
        cell.to_array()
            .map(|c| (c as u64).min((1 << MORTON_BITS) - 1)),
    )
}

#[cfg(test)]
mod tests;
