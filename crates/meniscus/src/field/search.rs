//! The blobs at a point, found through a tree that is built when it is first needed.

use super::{BlobField, FieldAt, Span};
use crate::math::aabb::{Aabb, DAabb};
use crate::particles::neighbours::BoxTree;
use glam::DVec3;
use std::sync::OnceLock;

/// A tree over the supports of one field, built when it is first needed. It is no part of the field's
/// value: any two compare equal, and clones build their own. Whoever changes a field's centres or
/// shapes puts `Search::default()` here.
#[derive(Debug, Default)]
pub struct Search(OnceLock<BoxTree>);

impl Clone for Search {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Search {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Search {
    /// Memory held, in bytes: 0 until the tree is built.
    pub fn bytes(&self) -> usize {
        self.0.get().map_or(0, BoxTree::bytes)
    }
}

impl BlobField {
    /// The tree over the packed supports.
    pub fn support_tree(&self) -> &BoxTree {
        self.search
            .0
            .get_or_init(|| BoxTree::build(self.len(), |i| self.support_bounds(i)))
    }

    /// Takes the tree over the particles for that over the supports, which saves sorting them again.
    /// Good for supports of similar sizes.
    pub(super) fn adopt_tree(&mut self, points: &BoxTree) {
        let tree = points.refitted(|i| self.support_bounds(i));
        self.search = Search(OnceLock::from(tree));
    }

    /// A box around the support of blob `i` at any time in `span`.
    pub fn path_bounds_in(&self, span: Span, i: usize) -> DAabb {
        let Aabb { min, max } = self.support_box_in(span, i);
        DAabb {
            min: min.as_dvec3(),
            max: max.as_dvec3(),
        }
    }

    fn support_bounds(&self, i: usize) -> DAabb {
        if let Some(motion) = &self.motion {
            return self.path_bounds_in(motion.whole(), i);
        }
        let center = self.center(i).as_dvec3();
        let half = glam::Vec3::from_array(self.shapes.half_extents(i)).as_dvec3();
        DAabb {
            min: center - half,
            max: center + half,
        }
    }
}

impl FieldAt<'_> {
    /// Calls `visit(blob, y, q)` with every blob whose support contains the local point (q < 1), in a
    /// fixed order; y = A(x − p) and q = |y|², in float64 on the packed numbers.
    pub fn for_each_blob_at(&self, local: DVec3, mut visit: impl FnMut(usize, DVec3, f64)) {
        self.field
            .support_tree()
            .for_each_containing(local, |blob| {
                let blob = blob as usize;
                let y = self.transform(blob, local - self.center(blob));
                let q = y.length_squared();
                if q < 1.0 {
                    visit(blob, y, q);
                }
            });
    }
}

impl BlobField {
    /// [`FieldAt::for_each_blob_at`] at the frame's time.
    pub fn for_each_blob_at(&self, local: DVec3, visit: impl FnMut(usize, DVec3, f64)) {
        self.at(0.0).for_each_blob_at(local, visit);
    }
}
