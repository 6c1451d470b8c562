//! Finds blobs near a line segment or a point: a balanced tree of float64 boxes, split at medians.

use super::center_at;
use glam::DVec3;
use meniscus::field::BlobField;

const LEAF: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Box64 {
    min: DVec3,
    max: DVec3,
}

/// A complete binary tree: node `k` has the children `2k + 1` and `2k + 2`, and a range of `order`
/// that halves at every level.
#[derive(Debug)]
pub(super) struct Index {
    boxes: Vec<Box64>,
    order: Vec<u32>,
}

impl Index {
    pub(super) fn build(field: &BlobField, time_secs: f64) -> Self {
        let support = |i| support(field, i, time_secs);
        let supports: Vec<Box64> = (0..field.len()).map(support).collect();
        let mut order: Vec<u32> = (0..field.len() as u32).collect();
        let mut boxes = Vec::new();
        if !order.is_empty() {
            fill(0, &mut order, &supports, &mut boxes);
        }
        Self { boxes, order }
    }

    /// Visits all blobs whose support may meet `o + s·d` with s in `[from, to]`.
    pub(super) fn near_segment(
        &self,
        (o, d): (DVec3, DVec3),
        (from, to): (f64, f64),
        visit: &mut impl FnMut(u32),
    ) {
        let hits = |b: &Box64| {
            let (mut near, mut far) = (from, to);
            for axis in 0..3 {
                if d[axis].abs() < 1e-100 {
                    if o[axis] < b.min[axis] || o[axis] > b.max[axis] {
                        return false;
                    }
                } else {
                    let a = (b.min[axis] - o[axis]) / d[axis];
                    let b = (b.max[axis] - o[axis]) / d[axis];
                    near = near.max(a.min(b));
                    far = far.min(a.max(b));
                }
            }
            near <= far + 1e-12 * far.abs()
        };
        self.descend(0, 0, self.order.len(), &hits, visit);
    }

    /// Visits all blobs whose support may contain `x`.
    pub(super) fn near_point(&self, x: DVec3, visit: &mut impl FnMut(u32)) {
        let hits = |b: &Box64| x.cmpge(b.min).all() && x.cmple(b.max).all();
        self.descend(0, 0, self.order.len(), &hits, visit);
    }

    fn descend(
        &self,
        node: usize,
        first: usize,
        last: usize,
        hits: &impl Fn(&Box64) -> bool,
        visit: &mut impl FnMut(u32),
    ) {
        if first == last || !hits(&self.boxes[node]) {
            return;
        }
        if last - first <= LEAF {
            self.order[first..last].iter().for_each(|&i| visit(i));
            return;
        }
        let middle = first + (last - first) / 2;
        self.descend(2 * node + 1, first, middle, hits, visit);
        self.descend(2 * node + 2, middle, last, hits, visit);
    }
}

fn support(field: &BlobField, i: usize, time_secs: f64) -> Box64 {
    let center = center_at(field, i, time_secs);
    let half = DVec3::from_array(field.shapes.half_extents(i).map(f64::from)) * (1.0 + 1e-6);
    Box64 {
        min: center - half,
        max: center + half,
    }
}

fn fill(node: usize, order: &mut [u32], supports: &[Box64], boxes: &mut Vec<Box64>) {
    let empty = Box64 {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    let bounds = order.iter().fold(empty, |bounds, &i| Box64 {
        min: bounds.min.min(supports[i as usize].min),
        max: bounds.max.max(supports[i as usize].max),
    });
    if boxes.len() <= node {
        boxes.resize(node + 1, empty);
    }
    boxes[node] = bounds;
    if order.len() <= LEAF {
        return;
    }
    let size = bounds.max - bounds.min;
    let axis = (0..3).fold(
        0,
        |best, axis| if size[axis] > size[best] { axis } else { best },
    );
    let middle = order.len() / 2;
    let key = |i: u32| supports[i as usize].min[axis] + supports[i as usize].max[axis];
    order.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)));
    let (left, right) = order.split_at_mut(middle);
    fill(2 * node + 1, left, supports, boxes);
    fill(2 * node + 2, right, supports, boxes);
}
