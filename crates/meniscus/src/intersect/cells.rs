//! Engine `cells`: gather and solve in the leaves that a ray visits.

use super::{BlobHit, Scratch};
use crate::accel::cells::Cells;
use crate::frame::Blobs;
use crate::math::ray::Ray;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct CellsScratch {}

/// First crossing.
pub fn closest(
    _blobs: &Blobs,
    _cells: &Cells,
    _ray: &Ray,
    _scratch: &mut Scratch,
) -> Option<BlobHit> {
    None
}

/// Whether there is a crossing.
pub fn occluded(_blobs: &Blobs, _cells: &Cells, _ray: &Ray, _scratch: &mut Scratch) -> bool {
    false
}
