//! Coarse cells: the part of the tree that is built before the first ray.
//!
//! It is split from groups of neighbouring blobs, so its cost is a small part of reading the
//! particles. What lies below a coarse cell is made when the first ray comes there.

use super::build::{BinaryNode, BuildContext, MAX_DEPTH, STALLED_SPLITS, halves, joined};
use crate::field::BlobField;
use crate::math::aabb::Aabb;
use glam::Vec3;

/// A cell of at most this many groups is not split further here: small enough that rays rarely pay
/// for what they do not see, large enough that the groups' overlap costs little.
const FEW_GROUPS: usize = 96;

/// A coarse cell that may contain surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoarseBox {
    pub(super) bounds: Aabb,
    /// Its depth in the whole tree.
    pub(super) depth: u32,
}

/// The tree of coarse cells of `field` within `cell`; its leaves are indices into `boxes`.
pub(super) fn split(
    field: &BlobField,
    context: &BuildContext,
    cell: Aabb,
    boxes: &mut Vec<CoarseBox>,
) -> Option<BinaryNode> {
    let groups: Vec<Aabb> = field
        .support_tree()
        .leaves()
        .map(|(bounds, _)| outward(bounds.min.as_vec3(), bounds.max.as_vec3()))
        .collect();
    let all = (0..groups.len() as u32).collect();
    Splitter {
        groups: &groups,
        context,
        boxes,
    }
    .split(cell, all, 0, 0)
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
    boxes: &'a mut Vec<CoarseBox>,
}

impl Splitter<'_> {
    fn split(
        &mut self,
        cell: Aabb,
        groups: Vec<u32>,
        stalled: u32,
        depth: u32,
    ) -> Option<BinaryNode> {
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
            let block = self.boxes.len() as u32;
            self.boxes.push(CoarseBox { bounds, depth });
            return Some(BinaryNode::Leaf { bounds, block });
        }
        let (axis, halves) = halves(cell);
        let lists = halves.map(|half| {
            let reach = half.padded(self.context.pad);
            let overlapping = groups
                .iter()
                .filter(|&&group| self.groups[group as usize].overlaps(&reach));
            overlapping.copied().collect::<Vec<u32>>()
        });
        let stalled = if lists.iter().all(|list| list.len() == groups.len()) {
            stalled + 1
        } else {
            0
        };
        drop(groups);
        let [low_list, high_list] = lists;
        let low = self.split(halves[0], low_list, stalled, depth + 1);
        let high = self.split(halves[1], high_list, stalled, depth + 1);
        joined(axis, low, high)
    }
}
