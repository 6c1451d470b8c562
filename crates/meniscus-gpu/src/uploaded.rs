//! A field in a device's buffers, and the batches of rays that are sent to it.

use crate::batch::{Batch, Call, HitRecord, MET_BLOB_BYTES, ParamsRecord, RayRecord, Room};
use crate::chunks::Chunks;
use crate::device::Device;
use crate::error::GpuError;
use crate::program::{Program, Question};
use crate::shader::{FieldMotion, ShaderKind, WORKGROUP};
use crate::stage::Bindings;
use crate::tracer::TracerOptions;
use glam::DVec3;
use meniscus::frame::Blobs;
use meniscus::intersect::particles::LONGEST_STRETCH;
use meniscus::intersect::{ClippedRay, Tolerances};
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Rays that are sent together.
pub(crate) const BATCH: usize = 1 << 15;

/// No fewer are sent together, however long they take.
const LEAST_BATCH: usize = 1 << 10;

/// Drivers reset cards after some seconds; batches that take a part of one are halved.
const LONGEST_BATCH: Duration = Duration::from_millis(400);

/// Blobs that a stretch of a ray may meet: at first, and for rays that need more.
pub(crate) const CAPACITIES: [u32; 2] = [96, 512];

/// Stacks are powers of two from here on, so that few shaders are needed.
const SMALLEST_STACK: u32 = 64;

/// A stack is no deeper than this; the CPU answers rays that need more.
const DEEPEST_STACK: u32 = 256;

/// Storage buffers that rays, hits and what they meet take.
pub(crate) const RAY_BUFFERS: u32 = 4;

/// `LocalRay::flags`.
const STARTS_INSIDE: u32 = 1;
const STARTS_AT_T_MIN: u32 = 2;
const SIDE_IS_PROVEN: u32 = 4;
const ASKS_SIDE: u32 = 8;

/// The buffers of one field, and what its rays are asked with.
pub(crate) struct Uploaded {
    field_origin: DVec3,
    bounds: Aabb,
    shutter_secs: [f64; 2],
    placed: Placed,
    kind: ShaderKind,
    /// For ordinary rays and for crowded ones.
    capacities: [u32; 2],
    params: ParamsRecord,
    /// For rays that are answered with one record, and with several.
    idle: [Mutex<Vec<Batch>>; 2],
    batch: AtomicUsize,
}

/// A tree in a device's buffers.
#[derive(Debug)]
pub(crate) struct Placed {
    /// Nodes, then leaves.
    pub(crate) chunks: Chunks,
    /// Word of the first leaf.
    pub(crate) leaves_at: u32,
    /// Most references that a ray can have waiting.
    pub(crate) stack: u32,
}

/// What is known of a tree beside its buffers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Around {
    /// Local box around all supports.
    pub(crate) bounds: Aabb,
    /// Mean radius of the supports.
    pub(crate) typical_support: f32,
}

/// One ray on its way.
#[derive(Clone, Copy)]
pub(crate) struct Sent {
    /// Index of the caller's ray.
    pub(crate) index: usize,
    pub(crate) clipped: ClippedRay,
}

impl Uploaded {
    pub(crate) fn new(
        device: &Device,
        blobs: &Blobs,
        placed: Placed,
        around: Around,
        options: TracerOptions,
    ) -> Self {
        let most = device
            .limits
            .max_storage_buffers_per_shader_stage
            .saturating_sub(RAY_BUFFERS);
        let count = placed.chunks.buffers.len() as u32;
        // Few numbers of buffers, so that few shaders are needed.
        let bound = count.next_power_of_two().min(most);
        let capacity = options.capacity.unwrap_or(CAPACITIES[0]);
        let mut uploaded = Self {
            field_origin: blobs.field.origin,
            bounds: around.bounds,
            shutter_secs: [0.0; 2],
            capacities: [capacity, CAPACITIES[1].max(capacity)],
            kind: ShaderKind {
                kernel: blobs.field.kernel,
                ellipsoids: matches!(blobs.field.shapes, Shapes::Ellipsoids(_)),
                motion: FieldMotion::of(&blobs.field),
                chunks: bound,
                chunk_bits: placed.chunks.bits,
                stack: placed
                    .stack
                    .next_power_of_two()
                    .clamp(SMALLEST_STACK, DEEPEST_STACK),
            },
            placed,
            params: [0; 12],
            idle: Default::default(),
            batch: AtomicUsize::new(BATCH),
        };
        uploaded.set(blobs, around);
        uploaded
    }

    /// Takes the numbers of another field whose tree stands in the same buffers.
    pub(crate) fn set(&mut self, blobs: &Blobs, around: Around) {
        let field = &blobs.field;
        let tolerances = Tolerances::of(blobs, around.bounds);
        self.field_origin = field.origin;
        self.bounds = around.bounds;
        self.shutter_secs = field
            .motion
            .as_ref()
            .map_or([0.0; 2], |motion| motion.shutter);
        self.kind.kernel = field.kernel;
        let middle_secs = 0.5 * (self.shutter_secs[0] + self.shutter_secs[1]);
        self.params = [
            field.threshold.to_bits(),
            tolerances.crossing.to_bits(),
            tolerances.rounding.to_bits(),
            tolerances.near_start.to_bits(),
            (LONGEST_STRETCH * around.typical_support).to_bits(),
            0,
            self.placed.leaves_at,
            0,
            (middle_secs as f32).to_bits(),
            0,
            0,
            0,
        ];
    }

    /// The tree's buffers.
    pub(crate) fn placed(&self) -> &Placed {
        &self.placed
    }

    pub(crate) fn clip(&self, ray: &Ray) -> Option<ClippedRay> {
        ClippedRay::new(self.field_origin, self.bounds, ray)
    }

    /// Local box around all supports.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// When the shutter opens and closes; both 0 where nothing moves.
    pub(crate) fn shutter_secs(&self) -> [f64; 2] {
        self.shutter_secs
    }

    /// The parameters without number of rays and room.
    pub(crate) fn params(&self) -> ParamsRecord {
        self.params
    }

    /// What its shader is made for.
    pub(crate) fn kind(&self) -> ShaderKind {
        self.kind
    }

    /// The shader that traces it.
    pub(crate) fn program(&self, device: &Device) -> Arc<Program> {
        device.programs.get(device, self.kind)
    }

    /// The field's buffers beside parameters, rays, hits and what rays meet.
    pub(crate) fn bound(
        &self,
        device: &Device,
        program: &Program,
        buffers: [&wgpu::Buffer; 5],
    ) -> wgpu::BindGroup {
        self.bound_by(device, &program.bindings, buffers)
    }

    fn bound_by(
        &self,
        device: &Device,
        bindings: &Bindings,
        buffers: [&wgpu::Buffer; 5],
    ) -> wgpu::BindGroup {
        // Bindings without a buffer of their own are never read.
        let field = self.placed.chunks.buffers.iter().cycle();
        let field = field.take(self.kind.chunks as usize);
        bindings.group(&device.device, buffers.into_iter().chain(field))
    }

    /// Sends rays batch by batch; returns the device's own time in seconds.
    pub(crate) fn send(
        &self,
        device: &Device,
        question: Question,
        room: usize,
        rays: &[Ray],
        waiting: &[Sent],
        mut visit: impl FnMut(&Sent, &[HitRecord]),
    ) -> Result<f64, GpuError> {
        let mut seconds = 0.0;
        if waiting.is_empty() {
            return Ok(seconds);
        }
        let program = self.program(device);
        let call = Call {
            pipeline: program.pipeline(device, question),
            params: self.params,
            capacity: self.capacities[room],
            workgroup: WORKGROUP,
        };
        let batch = self.borrow(device, question, &program.bindings)?;
        let mut records = Vec::new();
        let mut hits = Vec::new();
        let mut rest = waiting;
        while !rest.is_empty() {
            let most = self.batch.load(Ordering::Relaxed).min(batch.most(&call));
            let (now, later) = rest.split_at(rest.len().min(most));
            records.clear();
            records.extend(
                now.iter()
                    .map(|sent| self.record(&rays[sent.index], &sent.clipped)),
            );
            let start = Instant::now();
            seconds += batch
                .run(device, &call, &records, &mut hits)?
                .unwrap_or(0.0);
            if start.elapsed() > LONGEST_BATCH && now.len() == most {
                self.batch
                    .store((most / 2).max(LEAST_BATCH), Ordering::Relaxed);
            }
            let records = hits.chunks_exact(question.records() as usize);
            for (sent, records) in now.iter().zip(records) {
                visit(sent, records);
            }
            rest = later;
        }
        self.idle(question).push(batch);
        Ok(seconds)
    }

    /// A ray as the shader reads it.
    pub(crate) fn record(&self, ray: &Ray, clipped: &ClippedRay) -> RayRecord {
        let starts_at = clipped.starts_at_t_min;
        let side = match ray.side {
            Side::Inside => STARTS_INSIDE,
            Side::Outside if starts_at => 0,
            Side::Unknown if starts_at => ASKS_SIDE,
            // All blobs lie in the box.
            Side::Outside | Side::Unknown => SIDE_IS_PROVEN,
        };
        let flags = side | if starts_at { STARTS_AT_T_MIN } else { 0 };
        let [open, close] = self.shutter_secs;
        let time = ray.time.clamp(open, close);
        let since_middle = (time - 0.5 * (open + close)) as f32;
        let elapsed = if close > open {
            ((time - open) / (close - open)) as f32
        } else {
            0.0
        };
        let (origin, origin_low) = two_floats(clipped.origin);
        let (direction, direction_low) = two_floats(clipped.direction);
        [
            origin[0],
            origin[1],
            origin[2],
            clipped.length.to_bits(),
            origin_low[0],
            origin_low[1],
            origin_low[2],
            flags,
            direction[0],
            direction[1],
            direction[2],
            since_middle.to_bits(),
            direction_low[0],
            direction_low[1],
            direction_low[2],
            elapsed.to_bits(),
        ]
    }

    /// Buffers for a question that are not in use.
    fn idle(&self, question: Question) -> MutexGuard<'_, Vec<Batch>> {
        let idle = &self.idle[usize::from(question.records() > 1)];
        idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn borrow(
        &self,
        device: &Device,
        question: Question,
        bindings: &Bindings,
    ) -> Result<Batch, GpuError> {
        let idle = self.idle(question).pop();
        match idle {
            Some(batch) => Ok(batch),
            None => Batch::new(device, room(device, question), |buffers| {
                self.bound_by(device, bindings, buffers)
            }),
        }
    }
}

/// What a batch has room for: no more blobs than the adapter binds.
fn room(device: &Device, question: Question) -> Room {
    let largest = device.largest_binding();
    Room {
        rays: BATCH,
        records: question.records(),
        met: (BATCH * CAPACITIES[0] as usize).min((largest / MET_BLOB_BYTES) as usize),
    }
}

/// Each component as a sum of two f32, in bits.
fn two_floats(v: DVec3) -> ([u32; 3], [u32; 3]) {
    let high = v.as_vec3();
    let low = (v - high.as_dvec3()).as_vec3();
    (
        high.to_array().map(f32::to_bits),
        low.to_array().map(f32::to_bits),
    )
}
