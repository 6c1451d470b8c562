//! A frame for engine `peel`: what renderers ask.

use super::field::{PeelField, PeelOptions, PeelWork};
use super::view::View;
use crate::device::Device;
use crate::error::GpuError;
use crate::frame::{FrameTracer, Takeover};
use crate::tracer::TraceWork;
use meniscus::frame::{Blobs, Frame};
use meniscus::intersect::{BlobHit, BlobTracer, Crossing, Scratch, TraceError};
use meniscus::math::ray::Ray;
use meniscus::scene::camera::Camera;
use std::sync::{Mutex, PoisonError};

/// Rays asked about together: a round.
const TOGETHER: usize = 1 << 16;

/// The blob surfaces of a frame as one camera sees them. All other rays are those of the tree on the same
/// device.
pub struct PeelTracer<'d> {
    tree: FrameTracer<'d>,
    /// One per geometry of the frame.
    fields: Vec<Option<PeelField<'d>>>,
    /// What the camera is for each placement of a geometry.
    views: Vec<(u32, View)>,
    work: Mutex<PeelWork>,
}

impl<'d> PeelTracer<'d> {
    /// Uploads the fields of `frame`.
    ///
    /// # Errors
    /// Where one is none of still balls or does not fit, or the device fails.
    pub fn upload(
        device: &'d Device,
        frame: &Frame,
        camera: &Camera,
        takeover: Takeover,
    ) -> Result<Self, GpuError> {
        let fields = frame
            .geometries
            .iter()
            .map(|geometry| {
                let blobs = geometry.blobs()?;
                Some(PeelField::upload(device, blobs, PeelOptions::default()))
            })
            .map(Option::transpose)
            .collect::<Result<Vec<_>, GpuError>>()?;
        let views = (frame.instances.iter())
            .map(|instance| {
                let view = View::new(camera, &instance.object_from_world);
                (instance.geometry, view)
            })
            .collect();
        Ok(Self {
            tree: FrameTracer::upload(device, frame, takeover)?,
            fields,
            views,
            work: Mutex::default(),
        })
    }

    /// Memory taken on the device, with that of the tree.
    pub fn bytes(&self) -> u64 {
        self.tree.bytes()
            + self
                .fields
                .iter()
                .flatten()
                .map(PeelField::bytes)
                .sum::<u64>()
    }

    /// Why the CPU had to take over, if it had to.
    pub fn lost(&self) -> Option<&GpuError> {
        self.tree.lost()
    }

    /// What the tree did.
    pub fn tree_work(&self) -> TraceWork {
        self.tree.work()
    }

    /// What was done for the camera's rays.
    pub fn work(&self) -> PeelWork {
        *self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The view that these rays come from, if it is one.
    fn view(&self, geometry: u32, rays: &[Ray]) -> Option<&View> {
        let eye = rays.first()?.origin;
        let mut views = self.views.iter();
        let found = views.find(|(of, view)| *of == geometry && view.eye == eye);
        found.map(|(_, view)| view)
    }

    fn peel(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        left: &mut Vec<usize>,
    ) -> Result<bool, GpuError> {
        let field = self.fields.get(geometry as usize).and_then(Option::as_ref);
        let (Some(field), Some(view)) = (field, self.view(geometry, rays)) else {
            return Ok(false);
        };
        let done = field.closest_many(view, blobs, rays, hits, left)?;
        *self.work.lock().unwrap_or_else(PoisonError::into_inner) += done;
        Ok(true)
    }
}

impl BlobTracer for PeelTracer<'_> {
    type Error = TraceError;

    fn together(&self) -> usize {
        TOGETHER
    }

    fn closest_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        let mut left = Vec::new();
        let is_peeled = match self.lost() {
            Some(_) => false,
            // The tree's tracer finds out about a lost device, too, and knows what to do then.
            None => self
                .peel(geometry, blobs, rays, hits, &mut left)
                .unwrap_or(false),
        };
        if !is_peeled {
            return self.tree.closest_many(geometry, blobs, rays, hits, scratch);
        }
        if !left.is_empty() {
            let others: Vec<Ray> = left.iter().map(|&index| rays[index]).collect();
            let mut found = vec![None; others.len()];
            self.tree
                .closest_many(geometry, blobs, &others, &mut found, scratch)?;
            for (index, found) in left.into_iter().zip(found) {
                hits[index] = found;
            }
        }
        Ok(())
    }

    fn occluded_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        self.tree
            .occluded_many(geometry, blobs, rays, hits, scratch)
    }

    fn crossings_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        self.tree
            .crossings_many(geometry, blobs, rays, crossings, scratch)
    }
}
