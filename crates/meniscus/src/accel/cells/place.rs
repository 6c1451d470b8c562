//! Boxes whose faces may move while the shutter is open.

use crate::math::aabb::Aabb;
use glam::Vec3;

/// A box when the shutter opens and when it closes; in between every face lies in between, in
/// proportion to the time. Where nothing moves both are the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) ends: [Aabb; 2],
}

/// Parts of a cell's width, and of its longest side, of which a child keeps the smaller at both ends of
/// the shutter.
const KEPT_WIDTH: f32 = 0.35;
const KEPT_SIDE: f32 = 0.25;

impl Place {
    /// A box that stands still.
    pub(super) fn still(bounds: Aabb) -> Self {
        Self { ends: [bounds; 2] }
    }

    /// Whether its faces move.
    pub(super) fn moves(&self) -> bool {
        self.ends[0] != self.ends[1]
    }

    /// The box in the middle of the shutter.
    pub(super) fn middle(&self) -> Aabb {
        let [open, close] = self.ends;
        Aabb {
            min: (open.min + close.min) * 0.5,
            max: (open.max + close.max) * 0.5,
        }
    }

    /// How far its middle moves between the middle of the shutter and its end.
    pub(super) fn drift(&self) -> Vec3 {
        (self.ends[1].center() - self.ends[0].center()) * 0.5
    }

    /// The box around it at all times.
    pub(super) fn hull(&self) -> Aabb {
        self.ends[0].union(self.ends[1])
    }

    /// Grown by `margin` on every side.
    #[must_use]
    pub(super) fn padded(self, margin: f32) -> Self {
        Self {
            ends: self.ends.map(|bounds| bounds.padded(margin)),
        }
    }

    /// The smallest place of its kind around both.
    #[must_use]
    pub(super) fn union(self, other: Self) -> Self {
        let [open, close] = self.ends;
        Self {
            ends: [open.union(other.ends[0]), close.union(other.ends[1])],
        }
    }

    /// The halves across `axis`, the lower first; the plane between them moves by `drift` between the
    /// middle of the shutter and its end, as far as that leaves both a fair part.
    pub(super) fn parted(self, axis: usize, drift: f32) -> [Self; 2] {
        let middle = self.middle();
        let at = middle.min[axis] + 0.5 * middle.size()[axis];
        let mut halves = [self; 2];
        for (end, moved) in [-drift, drift].into_iter().enumerate() {
            let bounds = self.ends[end];
            let plane = if self.moves() || drift != 0.0 {
                let kept =
                    (KEPT_WIDTH * bounds.size()[axis]).min(KEPT_SIDE * middle.size().max_element());
                (at + moved).clamp(bounds.min[axis] + kept, bounds.max[axis] - kept)
            } else {
                at
            };
            halves[0].ends[end].max[axis] = plane;
            halves[1].ends[end].min[axis] = plane;
        }
        halves
    }

    /// This place without what lies outside `occupied`, face by face where that is clear for the whole
    /// shutter.
    #[must_use]
    pub(super) fn trimmed_to(mut self, occupied: Self) -> Self {
        let [open, close] = occupied.ends;
        for axis in 0..3 {
            let inside = |end: usize, bounds: &Aabb| self.ends[end].min[axis] <= bounds.min[axis];
            if inside(0, &open) && inside(1, &close) {
                self.ends[0].min[axis] = open.min[axis];
                self.ends[1].min[axis] = close.min[axis];
            }
            let inside = |end: usize, bounds: &Aabb| self.ends[end].max[axis] >= bounds.max[axis];
            if inside(0, &open) && inside(1, &close) {
                self.ends[0].max[axis] = open.max[axis];
                self.ends[1].max[axis] = close.max[axis];
            }
        }
        self
    }

    /// Cut across `axis` at a part of its width from the lower face: what lies below, and what above.
    pub(super) fn cut(self, axis: usize, fraction: f32, from_upper_face: bool) -> [Self; 2] {
        let (mut slab, mut rest) = (self, self);
        for end in 0..2 {
            let bounds = self.ends[end];
            let thickness = fraction * (bounds.max[axis] - bounds.min[axis]);
            if from_upper_face {
                slab.ends[end].min[axis] = bounds.max[axis] - thickness;
                rest.ends[end].max[axis] = slab.ends[end].min[axis];
            } else {
                slab.ends[end].max[axis] = bounds.min[axis] + thickness;
                rest.ends[end].min[axis] = slab.ends[end].max[axis];
            }
        }
        [slab, rest]
    }

    /// One of the eight parts about the middle.
    pub(super) fn octant(self, octant: usize) -> Self {
        Self {
            ends: self.ends.map(|bounds| {
                let center = bounds.center();
                let mut part = bounds;
                for axis in 0..3 {
                    if octant >> axis & 1 == 0 {
                        part.max[axis] = center[axis];
                    } else {
                        part.min[axis] = center[axis];
                    }
                }
                part
            }),
        }
    }
}
