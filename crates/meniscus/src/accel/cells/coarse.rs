//! Coarse cells: the part of the tree that is built before the first ray.
//!
//! It is split from groups of neighbouring blobs, so its cost is a small part of reading the
//! particles. What lies below a coarse cell is made when the first ray comes there.

use super::build::{BinaryNode, BuildContext, MAX_DEPTH, STALLED_SPLITS, longest_axis};
use super::place::Place;
use crate::field::{BlobField, Span};
use crate::math::aabb::{Aabb, DAabb};
use crate::particles::neighbours::BoxTree;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A cell of at most this many groups is not split further here: small enough that rays rarely pay
/// for what they do not see, large enough that the groups' overlap costs little.
const FEW_GROUPS: usize = 96;

/// Longer lists are split on several threads.
const PARALLEL_GROUPS: usize = 2048;

/// A coarse cell that may contain surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoarseBox {
    pub(super) place: Place,
    /// Its depth in the whole tree.
    pub(super) depth: u32,
}

/// The tree of coarse cells of `field` within `cell`; its leaves are indices into the list.
pub(super) fn split(
    (field, tree): (&BlobField, &BoxTree),
    context: &BuildContext,
    cell: Place,
) -> Option<(BinaryNode, Vec<CoarseBox>)> {
    let groups = groups_of(field, tree, context.span);
    let all = (0..groups.len() as u32).collect();
    let splitter = Splitter {
        groups: &groups,
        context,
    };
    splitter.split(cell, all, 0, 0)
}

/// Neighbouring blobs.
struct Group {
    /// Around their supports.
    place: Place,
    /// How far they move between the middle of the span and its end, on average.
    drift: Vec3,
}

fn groups_of(field: &BlobField, tree: &BoxTree, span: Span) -> Vec<Group> {
    let Some(motion) = &field.motion else {
        let still = |(bounds, _): (&DAabb, _)| Group {
            place: Place::still(outward(bounds.min.as_vec3(), bounds.max.as_vec3())),
            drift: Vec3::ZERO,
        };
        return tree.ranges().map(still).collect();
    };
    let groups: Vec<&[u32]> = tree.groups().collect();
    let moving = |blobs: &&[u32]| {
        let mut ends = [Aabb::EMPTY; 2];
        let mut drift = DVec3::ZERO;
        for &blob in *blobs {
            let boxes = field.motion_boxes_in(span, blob as usize);
            for (end, bounds) in ends.iter_mut().zip(boxes.ends) {
                *end = end.union(bounds);
            }
            drift += motion.by_phase(span, blob as usize, DVec3::ZERO)[1];
        }
        Group {
            place: Place {
                ends: ends.map(|bounds| outward(bounds.min, bounds.max)),
            },
            drift: (drift / blobs.len() as f64).as_vec3(),
        }
    };
    groups.par_iter().map(moving).collect()
}

/// Corners rounded outwards by one step, which conversion from f64 may have cost.
fn outward(min: Vec3, max: Vec3) -> Aabb {
    Aabb {
        min: Vec3::from_array(min.to_array().map(f32::next_down)),
        max: Vec3::from_array(max.to_array().map(f32::next_up)),
    }
}

struct Splitter<'a> {
    groups: &'a [Group],
    context: &'a BuildContext,
}

impl Splitter<'_> {
    /// How far groups near the middle of `cell` move along `axis` between the middle of the shutter and its
    /// end, on average.
    fn drift(&self, groups: &[u32], cell: Place, axis: usize) -> f32 {
        if !self.context.stored.moves() {
            return 0.0;
        }
        let middle = cell.middle();
        let at = middle.center()[axis];
        let near = 0.25 * middle.size()[axis];
        let (mut sum, mut count) = (0.0, 0.0);
        for &group in groups {
            let group = &self.groups[group as usize];
            if (group.place.middle().center()[axis] - at).abs() <= near {
                sum += group.drift[axis];
                count += 1.0;
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    fn split(
        &self,
        cell: Place,
        groups: Vec<u32>,
        stalled: u32,
        depth: u32,
    ) -> Option<(BinaryNode, Vec<CoarseBox>)> {
        if groups.is_empty() {
            return None;
        }
        if groups.len() <= FEW_GROUPS
            || stalled >= STALLED_SPLITS
            || cell.middle().size().max_element() < 32.0 * self.context.pad
            || depth >= MAX_DEPTH
        {
            let occupied = groups
                .iter()
                .map(|&group| self.groups[group as usize].place);
            let place = match occupied.reduce(Place::union).map(|o| cell.trimmed_to(o)) {
                Some(place) if !place.ends.iter().any(Aabb::is_empty) => place,
                // They only come within the margin.
                _ => cell,
            };
            let leaf = BinaryNode::Leaf {
                bounds: place,
                block: 0,
            };
            return Some((leaf, vec![CoarseBox { place, depth }]));
        }
        let axis = longest_axis(cell.middle().size());
        let halves = cell.parted(axis, self.drift(&groups, cell, axis));
        // All overlap the cell, so one axis tells which of its halves.
        let mut lists = [(); 2].map(|()| Vec::with_capacity(groups.len()));
        for &group in &groups {
            let ends = &self.groups[group as usize].place.ends;
            let meets_low = |end: usize| {
                ends[end].min[axis] <= halves[0].ends[end].max[axis] + self.context.pad
            };
            let meets_high = |end: usize| {
                ends[end].max[axis] >= halves[1].ends[end].min[axis] - self.context.pad
            };
            if meets_low(0) || meets_low(1) {
                lists[0].push(group);
            }
            if meets_high(0) || meets_high(1) {
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
