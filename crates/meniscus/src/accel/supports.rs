//! A bounding volume hierarchy over the supports of blobs, built by binned surface area (Wald 2007).
//!
//! Boxes are rounded outwards, so that a support which a ray pierces is never lost to f32.

use crate::field::BlobField;
use crate::math::aabb::Aabb;
use glam::{DVec3, Vec3};

/// Blobs per leaf at most.
const LEAF_BLOBS: usize = 4;
/// Candidate planes per split, plus one.
const BINS: usize = 16;
/// Direction components below this move a ray by nothing that f64 could show.
const PARALLEL: f64 = 1e-200;
/// Relative rounding error of a slab distance, rounded up.
const SLAB_ERROR: f64 = 2e-15;

/// A box with either two children side by side (`count` = 0) or `count` blobs from `first` on.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    first: u32,
    count: u32,
}

/// What a node holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contents<'a> {
    /// Two inner nodes or leaves.
    Children([u32; 2]),
    /// Indices of blobs.
    Blobs(&'a [u32]),
}

/// A segment of a straight line in local coordinates, ready for box tests. The parameter is length.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Where the parameter is 0.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Smallest parameter; finite.
    pub start: f64,
    /// Largest parameter; may be infinite.
    pub end: f64,
    /// Seconds relative to the frame.
    pub time_secs: f64,
}

impl Segment {
    /// Parameters at which the segment enters and leaves a box, rounded outwards.
    pub fn overlap(&self, bounds: &Aabb) -> Option<(f64, f64)> {
        let (mut near, mut far) = (self.start, self.end);
        for axis in 0..3 {
            let (o, d) = (self.origin[axis], self.direction[axis]);
            let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
            if d.abs() < PARALLEL {
                if o < low || o > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - o) / d, (high - o) / d);
            let (enter, leave) = if a <= b { (a, b) } else { (b, a) };
            near = near.max(enter - enter.abs() * SLAB_ERROR);
            far = far.min(leave + leave.abs() * SLAB_ERROR);
        }
        (near <= far).then_some((near, far))
    }
}

/// Finds the blobs whose support a ray pierces.
#[derive(Debug)]
pub struct SupportTree {
    nodes: Vec<Node>,
    blobs: Vec<u32>,
}

impl SupportTree {
    /// Builds the tree of `field`. The same field gives the same tree.
    pub fn build(field: &BlobField) -> Self {
        let boxes: Vec<Aabb> = (0..field.len()).map(|i| outer_box(field, i)).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity(field.len()),
            blobs: (0..field.len() as u32).collect(),
        };
        if field.is_empty() {
            return tree;
        }
        tree.nodes.push(Node {
            bounds: Aabb::EMPTY,
            first: 0,
            count: field.len() as u32,
        });
        let mut open = vec![0_usize];
        while let Some(node) = open.pop() {
            let (first, count) = (tree.nodes[node].first as usize, tree.nodes[node].count);
            let range = first..first + count as usize;
            tree.nodes[node].bounds = union_of(&tree.blobs[range.clone()], &boxes);
            if range.len() <= LEAF_BLOBS {
                continue;
            }
            let left = split(&mut tree.blobs[range.clone()], &boxes);
            let children = tree.nodes.len();
            for part in [
                range.start..range.start + left,
                range.start + left..range.end,
            ] {
                tree.nodes.push(Node {
                    bounds: Aabb::EMPTY,
                    first: part.start as u32,
                    count: part.len() as u32,
                });
            }
            tree.nodes[node].first = children as u32;
            tree.nodes[node].count = 0;
            open.extend([children + 1, children]);
        }
        tree
    }

    /// The node around everything, unless there is no blob.
    pub fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    /// Box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// What a node holds.
    pub fn contents(&self, node: u32) -> Contents<'_> {
        let node = &self.nodes[node as usize];
        if node.count == 0 {
            Contents::Children([node.first, node.first + 1])
        } else {
            Contents::Blobs(&self.blobs[node.first as usize..(node.first + node.count) as usize])
        }
    }

    /// Calls `visit` with every blob whose support box lies in a leaf that `segment` meets, in no
    /// particular order: all blobs that the segment pierces, and some near it.
    pub fn for_each_on_ray(&self, segment: &Segment, mut visit: impl FnMut(u32)) {
        let mut stack = Vec::from_iter(self.root());
        while let Some(node) = stack.pop() {
            if segment.overlap(self.bounds(node)).is_none() {
                continue;
            }
            match self.contents(node) {
                Contents::Children(children) => stack.extend(children),
                Contents::Blobs(blobs) => blobs.iter().for_each(|&blob| visit(blob)),
            }
        }
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.blobs.capacity() * size_of::<u32>()
    }
}

/// The support box of blob `i` with both corners rounded outwards.
fn outer_box(field: &BlobField, i: usize) -> Aabb {
    let mut bounds = field.support_box(i);
    for axis in 0..3 {
        bounds.min[axis] = bounds.min[axis].next_down();
        bounds.max[axis] = bounds.max[axis].next_up();
    }
    bounds
}

fn union_of(blobs: &[u32], boxes: &[Aabb]) -> Aabb {
    blobs.iter().fold(Aabb::EMPTY, |bounds, &blob| {
        bounds.union(boxes[blob as usize])
    })
}

/// Partitions `blobs` in two non-empty parts and returns the size of the first: the binned plane of
/// least surface area cost, or the middle where all centres coincide.
fn split(blobs: &mut [u32], boxes: &[Aabb]) -> usize {
    let center = |blob: u32| boxes[blob as usize].center();
    let (low, high) = blobs
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &b| {
            (low.min(center(b)), high.max(center(b)))
        });
    let size = high - low;
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in 0..3 {
        // Also false where the extent is too small to be divided into bins, or not a number.
        let scale = BINS as f32 / size[axis];
        if !(size[axis] > 0.0 && scale.is_finite()) {
            continue;
        }
        let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
        for &blob in blobs.iter() {
            let bin = &mut bins[bin_of(center(blob)[axis], low[axis], scale)];
            *bin = (bin.0.union(boxes[blob as usize]), bin.1 + 1);
        }
        let mut right_costs = [0.0_f32; BINS];
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for bin in (1..BINS).rev() {
            (bounds, count) = (bounds.union(bins[bin].0), count + bins[bin].1);
            right_costs[bin] = bounds.half_area() * count as f32;
        }
        let (mut bounds, mut count) = (Aabb::EMPTY, 0);
        for bin in 1..BINS {
            (bounds, count) = (bounds.union(bins[bin - 1].0), count + bins[bin - 1].1);
            if count == 0 || count == blobs.len() {
                continue;
            }
            let cost = bounds.half_area() * count as f32 + right_costs[bin];
            if best.is_none_or(|(least, _, _)| cost < least) {
                best = Some((cost, axis, bin));
            }
        }
    }
    let Some((_, axis, bin)) = best else {
        return blobs.len() / 2;
    };
    let scale = BINS as f32 / size[axis];
    let mut left = 0;
    for i in 0..blobs.len() {
        if bin_of(center(blobs[i])[axis], low[axis], scale) < bin {
            blobs.swap(i, left);
            left += 1;
        }
    }
    left
}

fn bin_of(coordinate: f32, low: f32, scale: f32) -> usize {
    (((coordinate - low) * scale) as usize).min(BINS - 1)
}

#[cfg(test)]
mod tests;
