//! A frame on the device: what renderers ask.

use crate::device::Device;
use crate::error::GpuError;
use crate::tracer::{FieldTracer, TraceWork, TracerOptions};
use crate::uploaded::Uploaded;
use meniscus::frame::{Blobs, Frame, Geometry};
use meniscus::intersect::{BlobHit, BlobTracer, Crossing, Scratch, TraceError};
use meniscus::math::ray::Ray;
use std::sync::{Mutex, OnceLock, PoisonError};

/// What happens when the device fails in the middle of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Takeover {
    /// The frame fails.
    #[default]
    Never,
    /// The CPU traces what is left; what is done stays.
    ByCpu,
}

/// The blob surfaces of a frame on a device; everything else of it stays where it is.
pub struct FrameTracer<'d> {
    device: &'d Device,
    /// One per geometry of the frame.
    fields: Vec<Option<FieldTracer<'d>>>,
    takeover: Takeover,
    /// Why the device is no longer asked.
    lost: OnceLock<GpuError>,
    work: Mutex<TraceWork>,
}

impl<'d> FrameTracer<'d> {
    /// Uploads the fields of `frame`.
    ///
    /// # Errors
    /// Where one does not fit, or the device fails.
    pub fn upload(device: &'d Device, frame: &Frame, takeover: Takeover) -> Result<Self, GpuError> {
        let upload = |geometry: &Geometry| {
            let blobs = geometry.blobs()?;
            Some(FieldTracer::upload(device, blobs, TracerOptions::default()))
        };
        let fields = frame
            .geometries
            .iter()
            .map(|geometry| upload(geometry).transpose())
            .collect::<Result<Vec<_>, GpuError>>()?;
        Ok(Self {
            device,
            fields,
            takeover,
            lost: OnceLock::new(),
            work: Mutex::default(),
        })
    }

    /// Takes the next frame of a moving set: trees that the device built are refitted or built anew in
    /// their buffers ([`FieldTracer::update`]), everything else is sent as by [`FrameTracer::upload`].
    ///
    /// # Errors
    /// Where it does not fit, or the device fails.
    pub fn update(&mut self, frame: &Frame) -> Result<(), GpuError> {
        let blobs: Vec<_> = frame.geometries.iter().map(Geometry::blobs).collect();
        let is_alike = self.fields.len() == blobs.len()
            && (self.fields.iter().zip(&blobs))
                .all(|(field, blobs)| field.is_some() == blobs.is_some());
        if !is_alike || self.lost().is_some() {
            *self = Self::upload(self.device, frame, self.takeover)?;
            return Ok(());
        }
        for (field, blobs) in self.fields.iter_mut().zip(blobs) {
            if let (Some(field), Some(blobs)) = (field, blobs) {
                field.update(blobs)?;
            }
        }
        Ok(())
    }

    /// Time of the device for the last build or refit of its trees, in seconds by its own clock; 0 where
    /// the processor builds them or the device keeps no time.
    pub fn build_secs(&self) -> f64 {
        let fields = self.fields.iter().flatten();
        fields.map(FieldTracer::build_secs).sum()
    }

    /// Memory taken on the device.
    pub fn bytes(&self) -> u64 {
        self.fields.iter().flatten().map(FieldTracer::bytes).sum()
    }

    /// Why the CPU had to take over, if it had to.
    pub fn lost(&self) -> Option<&GpuError> {
        self.lost.get()
    }

    /// What was done so far.
    pub fn work(&self) -> TraceWork {
        *self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was done so far, which counts from 0 again.
    pub fn take_work(&self) -> TraceWork {
        std::mem::take(&mut *self.work.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The device.
    pub(crate) fn device(&self) -> &'d Device {
        self.device
    }

    /// The field of a geometry: `None` where it is not on the device, `Some(None)` where there is nothing
    /// to hit.
    pub(crate) fn uploaded(&self, geometry: u32) -> Option<Option<&Uploaded>> {
        self.field(geometry).map(FieldTracer::uploaded)
    }

    /// Takes note of what was done; whether the device did it. Else the CPU has to.
    pub(crate) fn settle(&self, result: Result<TraceWork, GpuError>) -> Result<bool, TraceError> {
        match (result, self.takeover) {
            (Ok(work), _) => {
                *self.work.lock().unwrap_or_else(PoisonError::into_inner) += work;
                Ok(true)
            }
            (Err(error), Takeover::ByCpu) => {
                self.lost.get_or_init(|| error);
                Ok(false)
            }
            (Err(error), Takeover::Never) => Err(error.into()),
        }
    }

    /// The tracer of a geometry, as long as the device is there.
    fn field(&self, geometry: u32) -> Option<&FieldTracer<'d>> {
        match self.lost.get() {
            Some(_) => None,
            None => self.fields.get(geometry as usize)?.as_ref(),
        }
    }
}

impl BlobTracer for FrameTracer<'_> {
    type Error = TraceError;

    fn together(&self) -> usize {
        let most = self.fields.iter().flatten().map(FieldTracer::together);
        most.min().unwrap_or(1)
    }

    fn closest_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        let done = match self.field(geometry) {
            Some(field) => self.settle(field.closest_many(blobs, rays, hits, scratch))?,
            None => false,
        };
        if !done {
            blobs.closest_many(rays, hits, scratch);
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
        let done = match self.field(geometry) {
            Some(field) => self.settle(field.occluded_many(blobs, rays, hits, scratch))?,
            None => false,
        };
        if !done {
            blobs.occluded_many(rays, hits, scratch);
        }
        Ok(())
    }

    fn crossings_many(
        &self,
        geometry: u32,
        blobs: &Blobs,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        let done = match self.field(geometry) {
            Some(field) => self.settle(field.crossings_many(blobs, rays, crossings, scratch))?,
            None => false,
        };
        if !done {
            blobs.crossings_many(rays, crossings, scratch);
        }
        Ok(())
    }
}
