//! Engine `sweep`: every support along the ray, sorted, one Bézier polynomial per interval.

use super::{BlobHit, Scratch};
use crate::accel::supports::SupportTree;
use crate::frame::Blobs;
use crate::math::ray::Ray;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct SweepScratch {}

/// First crossing.
pub fn closest(
    _blobs: &Blobs,
    _tree: &SupportTree,
    _ray: &Ray,
    _scratch: &mut Scratch,
) -> Option<BlobHit> {
    None
}
