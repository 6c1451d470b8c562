//! Shading on the device: samples of a picture go through stages (the eye's rays, surfaces, integrator)
//! round by round, and come back when they are done. Samples with a ray that f32 cannot decide are marked
//! and done by the processor, whole.

mod blend;
mod field_stage;
mod picture;
mod programs;
mod sources;
#[cfg(test)]
mod twin_tests;
mod wave;

pub use sources::{FieldStage, StageModule};

pub(crate) use programs::StagePrograms;

use crate::device::Device;
use crate::error::GpuError;
use crate::frame::FrameTracer;
use crate::tracer::TraceWork;
use crate::uploaded::Uploaded;
use blend::Blend;
use field_stage::FieldProgram;
use glam::DVec3;
use meniscus::intersect::TraceError;
use meniscus::render::{SampleBlock, SampleRun, SampleStages, StagedPicture, StagedSample};
use meniscus::scene::IntegratorKind;
use meniscus::shade::{RayCounts, StagedField, StagedShading, Unstaged};
use picture::PictureRecord;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};
use wave::{Shape, Wave};

/// Sets of buffers: while one is on the device, what came back of the other is put on film.
const MOST_WAVES: usize = 2;
/// Drivers reset cards after some seconds: rounds that take a part of one on average are halved.
const LONGEST_ROUND: Duration = Duration::from_millis(400);
/// No fewer samples go together, however long they take.
const LEAST_SAMPLES: u64 = 1 << 10;

/// A blob surface on the device.
struct Field<'s> {
    /// Its instance.
    surface: u32,
    /// Where the field's origin lies, relative to that of the stages.
    offset: DVec3,
    uploaded: &'s Uploaded,
    /// Where its looks follow attributes.
    blend: Option<Blend>,
    /// Where highlights are widened.
    derivatives: Option<Arc<FieldProgram>>,
}

impl<'s> Field<'s> {
    fn new(
        device: &Device,
        field: &StagedField,
        uploaded: &'s Uploaded,
        antialiases: bool,
    ) -> Result<Self, Unstaged> {
        let columns = Some(&field.columns).filter(|columns| columns.per_particle > 0);
        let blend = columns
            .map(|columns| match Blend::new(device, uploaded, columns) {
                Ok(Some(blend)) => Ok(blend),
                Ok(None) | Err(_) => Err(Unstaged::Room),
            })
            .transpose()?;
        let derivatives = antialiases
            .then(|| {
                let programs = &device.stages.fields;
                (programs.get(device, uploaded, FieldStage::Derivatives)).ok_or(Unstaged::Room)
            })
            .transpose()?;
        Ok(Self {
            surface: field.surface,
            offset: field.offset,
            uploaded,
            blend,
            derivatives,
        })
    }
}

/// A picture on the device.
struct Run<'s> {
    tracer: &'s FrameTracer<'s>,
    picture: PictureRecord,
    words: wgpu::Buffer,
    fields: Vec<Field<'s>>,
    integrator: Arc<wgpu::ComputePipeline>,
    shape: Shape,
    rounds: Rounds,
    waves: Waves,
    together: AtomicU64,
}

/// How many rounds it takes.
#[derive(Debug, Clone, Copy)]
enum Rounds {
    /// One for first surfaces, then so many for lights alone.
    ForLights(u32),
    /// Until no sample goes on; it is asked after each.
    UntilDone,
}

impl Rounds {
    fn new(shading: &StagedShading) -> Self {
        match shading.integrator.kind {
            IntegratorKind::Shaded => Self::ForLights(shading.hard_lights),
            IntegratorKind::Ao => Self::ForLights(shading.ao_samples),
            IntegratorKind::Whitted | IntegratorKind::Path => Self::UntilDone,
        }
    }
}

/// Sets of buffers that are not in use, and how many there may still be.
struct Waves {
    idle: Mutex<(Vec<Wave>, usize)>,
    returned: Condvar,
}

impl Waves {
    fn new() -> Self {
        Self {
            idle: Mutex::new((Vec::new(), MOST_WAVES)),
            returned: Condvar::new(),
        }
    }

    /// Runs `work` with a set of buffers, when one is there.
    fn lend<T>(
        &self,
        make: impl FnOnce() -> Result<Wave, GpuError>,
        work: impl FnOnce(&Wave) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let mut guard = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        while guard.0.is_empty() && guard.1 == 0 {
            guard = (self.returned.wait(guard)).unwrap_or_else(PoisonError::into_inner);
        }
        let idle = guard.0.pop();
        if idle.is_none() {
            guard.1 -= 1;
        }
        drop(guard);
        let made = idle.map_or_else(make, Ok);
        let result = made.and_then(|wave| Ok((work(&wave)?, wave)));
        let mut guard = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let result = match result {
            Ok((result, wave)) => {
                guard.0.push(wave);
                Ok(result)
            }
            Err(error) => {
                guard.1 += 1;
                Err(error)
            }
        };
        drop(guard);
        self.returned.notify_one();
        result
    }
}

impl SampleStages for FrameTracer<'_> {
    fn start<'s>(&'s self, picture: &StagedPicture) -> Result<Box<dyn SampleRun + 's>, Unstaged> {
        let device = self.device();
        let shading = &picture.shading;
        let rounds = Rounds::new(shading);
        let antialiases = shading.specular_variances.is_some();
        let mut fields = Vec::new();
        for field in &shading.fields {
            let tracer = self.uploaded(field.geometry).ok_or(Unstaged::Room)?;
            // Nothing to hit: no stage.
            if let Some(uploaded) = tracer {
                fields.push(Field::new(device, field, uploaded, antialiases)?);
            }
        }
        let kind = shading.integrator.kind;
        let branches = match kind {
            IntegratorKind::Whitted => wave::branches(shading.integrator.depth),
            IntegratorKind::Shaded | IntegratorKind::Ao | IntegratorKind::Path => 0,
        };
        let shape = Shape {
            capacity: wave::capacity(device, branches, antialiases).ok_or(Unstaged::Room)?,
            light_walks: shading.light_walks,
            branches,
            varies: fields.iter().any(|field: &Field<'_>| field.blend.is_some()),
            antialiases,
        };
        let picture = PictureRecord::new(picture);
        let bytes: &[u8] = bytemuck::cast_slice(&picture.words);
        if bytes.len() as u64 > device.largest_binding() {
            return Err(Unstaged::Room);
        }
        let words = (device.within_memory(bytes.len() as u64, || {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("words"),
                size: bytes.len() as u64,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        }))
        .map_err(|_| Unstaged::Room)?;
        device.queue.write_buffer(&words, 0, bytes);
        let run = Run {
            tracer: self,
            words,
            fields,
            integrator: (device.stages).integrator(device, kind),
            shape,
            rounds,
            waves: Waves::new(),
            together: AtomicU64::new(shape.capacity),
            picture,
        };
        // What does not fit is found out here, where the processor can still shade.
        (run.waves.lend(|| run.wave(), |_| Ok(()))).map_err(|_| Unstaged::Room)?;
        Ok(Box::new(run))
    }
}

impl Run<'_> {
    fn device(&self) -> &Device {
        self.tracer.device()
    }

    fn wave(&self) -> Result<Wave, GpuError> {
        let device = self.device();
        let common = device.stages.common(device);
        Wave::new(device, common, &self.words, &self.fields, self.shape)
    }

    /// Sends samples through all rounds.
    fn send(
        &self,
        wave: &Wave,
        record: &[u32],
        count: u32,
        samples: &mut Vec<StagedSample>,
        rays: &mut RayCounts,
    ) -> Result<TraceWork, GpuError> {
        let device = self.device();
        device.check()?;
        let common = device.stages.common(device);
        let start = Instant::now();
        wave.begin(device, common, record);
        let round = |asks| wave.round(device, common, &self.integrator, asks, count);
        round([true, false]);
        let mut rounds = 1;
        match self.rounds {
            Rounds::ForLights(lights) => {
                rounds += lights;
                for _ in 0..lights {
                    round([false, true]);
                }
            }
            Rounds::UntilDone => {
                while wave.going_on(device)? > 0 {
                    round([true; 2]);
                    rounds += 1;
                }
            }
        }
        let mut own = RayCounts::default();
        let device_secs = wave.finish(device, common, count, samples, &mut own)?;
        if start.elapsed() > LONGEST_ROUND * rounds {
            let fewer = (u64::from(count) / 2).max(LEAST_SAMPLES);
            self.together.fetch_min(fewer, Ordering::Relaxed);
        }
        *rays += own;
        Ok(TraceWork {
            rays: own.total(),
            device_secs,
            ..TraceWork::default()
        })
    }
}

impl SampleRun for Run<'_> {
    fn together(&self) -> u64 {
        self.together.load(Ordering::Relaxed)
    }

    fn shade(
        &self,
        block: &SampleBlock,
        numbers: Range<u64>,
        samples: &mut Vec<StagedSample>,
        rays: &mut RayCounts,
    ) -> Result<bool, TraceError> {
        if self.tracer.lost().is_some() {
            return Ok(false);
        }
        let count = (numbers.end - numbers.start) as u32;
        let record = self.picture.of(block, numbers.start, count);
        let sent = self.waves.lend(
            || self.wave(),
            |wave| self.send(wave, &record, count, samples, rays),
        );
        self.tracer.settle(sent)
    }
}
