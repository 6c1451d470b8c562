//! A bounding volume hierarchy over the supports of blobs.

use crate::field::BlobField;

/// Finds the blobs whose support a ray pierces.
#[derive(Debug)]
pub struct SupportTree {}

impl SupportTree {
    /// Builds the tree of `field`.
    pub fn build(_field: &BlobField) -> Self {
        Self {}
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        0
    }
}
