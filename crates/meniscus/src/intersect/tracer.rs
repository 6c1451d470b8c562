//! Who answers rays on blob surfaces, many at a time: this machine's processor or another device. The
//! rest of a frame (meshes, spheres, planes, cuts) is always looked after here.

use super::{BlobHit, Crossing, Scratch};
use crate::frame::Blobs;
use crate::math::ray::Ray;
use std::convert::Infallible;
use thiserror::Error;

/// Why a device gives no answers any more.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct TraceError {
    /// One sentence, with what to do about it.
    pub message: String,
}

/// Answers object-space rays on the blob surfaces of one frame.
pub trait BlobTracer: Sync {
    /// Why there may be no answers.
    type Error: Send;

    /// Rays that are traced together at most.
    fn together(&self) -> usize;

    /// First crossings with geometry `geometry` of the frame, which is `blobs`, one per entry of `hits`.
    ///
    /// # Errors
    /// Where the device fails.
    fn closest_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        scratch: &mut Scratch,
    ) -> Result<(), Self::Error>;

    /// Whether rays cross that geometry at all, one per entry of `hits`.
    ///
    /// # Errors
    /// Where the device fails.
    fn occluded_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<(), Self::Error>;

    /// Every crossing with that geometry in order, appended to the ray's entry of `crossings`.
    ///
    /// # Errors
    /// Where the device fails.
    fn crossings_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), Self::Error>;
}

/// This machine's processor.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnCpu;

/// Rays of neighbouring pixels that still lie close together.
const TOGETHER: usize = 16;

impl BlobTracer for OnCpu {
    type Error = Infallible;

    fn together(&self) -> usize {
        TOGETHER
    }

    fn closest_many(
        &self,
        _geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        scratch: &mut Scratch,
    ) -> Result<(), Infallible> {
        blobs.closest_many(rays, hits, scratch);
        Ok(())
    }

    fn occluded_many(
        &self,
        _geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<(), Infallible> {
        blobs.occluded_many(rays, hits, scratch);
        Ok(())
    }

    fn crossings_many(
        &self,
        _geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), Infallible> {
        blobs.crossings_many(rays, crossings, scratch);
        Ok(())
    }
}
