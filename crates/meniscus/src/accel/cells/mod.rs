//! Cells: a tree of disjoint boxes that contain the surface, not the particles.

use crate::field::BlobField;
use crate::math::simd::Level;

/// The structure of engine `cells`.
#[derive(Debug)]
pub struct Cells {}

impl Cells {
    /// Builds the cells of `field`.
    pub fn build(_field: &BlobField, _level: Level) -> Self {
        Self {}
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        0
    }
}
