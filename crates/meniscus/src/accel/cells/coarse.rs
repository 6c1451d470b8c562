//! Coarse cells: the part of the tree that is built before the first ray.
//!
//! It is split from groups of neighbouring blobs, so its cost is a small part of reading the
//! particles. What lies below a coarse cell is made when the first ray comes there.

use super::build::{BinaryNode, BuildContext, MAX_DEPTH, STALLED_SPLITS, halves};
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use glam::Vec3;

/// A cell of at most this many groups is not split further here: small enough that rays rarely pay
/// for what they do not see, large enough that the groups' overlap costs little.
const FEW_GROUPS: usize = 96;

/// Longer lists are split on several threads.
const PARALLEL_GROUPS: usize = 2048;

/// A coarse cell that may contain surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoarseBox {
    pub(super) bounds: Aabb,
    /// Its depth in the whole tree.
    pub(super) depth: u32,
}

/// The tree of coarse cells of `field` within `cell`; its leaves are indices into the list.
pub(super) fn split(
    field: &BlobField,
    context: &BuildContext,
    cell: Aabb,
) -> Option<(BinaryNode, Vec<CoarseBox>)> {
    let groups: Vec<Aabb> = field
        .support_tree()
        .ranges()
        .map(|(bounds, _)| outward(bounds.min.as_vec3(), bounds.max.as_vec3()))
        .collect();
    let all = (0..groups.len() as u32).collect();
    let splitter = Splitter {
        groups: &groups,
        context,
    };
    splitter.split(cell, all, 0, 0)
}

/// Corners rounded outwards by one step, which conversion from f64 may have cost.
fn outward(min: Vec3, max: Vec3) -> Aabb {
    Aabb {
        min: Vec3::from_array(min.to_array().map(f32::next_down)),
        max: Vec3::from_array(max.to_array().map(f32::next_up)),
    }
}

struct Splitter<'a> {
    groups: &'a [Aabb],
    context: &'a BuildContext,
}

impl Splitter<'_> {
    fn split(
        &self,
        cell: Aabb,
        groups: Vec<u32>,
        stalled: u32,
        depth: u32,
    ) -> Option<(BinaryNode, Vec<CoarseBox>)> {
        if groups.is_empty() {
            return None;
        }
        if groups.len() <= FEW_GROUPS
            || stalled >= STALLED_SPLITS
            || cell.size().max_element() < 32.0 * self.context.pad
            || depth >= MAX_DEPTH
        {
            let occupied = groups.iter().fold(Aabb::EMPTY, |bounds, &group| {
                bounds.union(self.groups[group as usize])
            });
            let bounds = match cell.intersection(occupied) {
                // They only come within the margin.
                bounds if bounds.is_empty() => cell,
                bounds => bounds,
            };
            let leaf = BinaryNode::Leaf { bounds, block: 0 };
            return Some((leaf, vec![CoarseBox { bounds, depth }]));
        }
        let (axis, halves) = halves(cell);
        // All overlap the cell, so one axis tells which of its halves.
        let low_end = halves[0].max[axis] + self.context.pad;
        let high_start = halves[1].min[axis] - self.context.pad;
        let mut lists = [(); 2].map(|()| Vec::with_capacity(groups.len()));
        for &group in &groups {
            let bounds = &self.groups[group as usize];
            if bounds.min[axis] <= low_end {
                lists[0].push(group);
            }
            if bounds.max[axis] >= high_start {
                lists[1].push(group);
            }
        }
        let stalled = if lists.iter().all(|list| list.len() == groups.len()) {
            stalled + 1
        } else {
            0
        };
        let is_long = groups.len() > PARALLEL_GROUPS;
        drop(groups);
        let [low_list, high_list] = lists;
        let low = || self.split(halves[0], low_list, stalled, depth + 1);
        let high = || self.split(halves[1], high_list, stalled, depth + 1);
        let (low, high) = if is_long {
            rayon::join(low, high)
        } else {
            (low(), high())
        };
        match (low, high) {
            (Some((low, mut boxes)), Some((mut high, more))) => {
                high.renumber(boxes.len() as u32);
                boxes.extend(more);
                Some((BinaryNode::joined(axis, low, high), boxes))
            }
            (one, other) => one.or(other),
        }
    }
}
