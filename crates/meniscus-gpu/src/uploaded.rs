//! A field in a device's buffers, and the batches of rays that are sent to it.

use crate::batch::{Batch, Call, HitRecord, MET_BLOB_BYTES, ParamsRecord, RayRecord, Room};
use crate::device::Device;
use crate::error::GpuError;
use crate::pack::{Packed, Word};
use crate::program::Question;
use crate::shader::{ShaderKind, WORKGROUP};
use crate::tracer::TracerOptions;
use glam::DVec3;
use meniscus::accel::particles::ParticleTree;
use meniscus::frame::Blobs;
use meniscus::intersect::particles::LONGEST_STRETCH;
use meniscus::intersect::{ClippedRay, Tolerances};
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
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

/// Words of the largest chunk as a power of two: 2 GiB.
const MOST_CHUNK_BITS: u32 = 27;

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
    chunks: Vec<wgpu::Buffer>,
    kind: ShaderKind,
    /// For ordinary rays and for crowded ones.
    capacities: [u32; 2],
    params: ParamsRecord,
    idle: Mutex<Vec<Batch>>,
    batch: AtomicUsize,
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
        (tree, bounds): (&ParticleTree, Aabb),
        packed: &Packed,
        options: TracerOptions,
    ) -> Result<Self, GpuError> {
        let chunk_bits = chunk_bits(device, options);
        let chunk_words = 1_usize << chunk_bits;
        let count = packed.words.len().div_ceil(chunk_words) as u32;
        let bytes = size_of_val(&packed.words[..]) as u64;
        // Rays, hits and what they meet take four.
        let most = device
            .limits
            .max_storage_buffers_per_shader_stage
            .saturating_sub(4);
        if count > most {
            let message = format!(
                "it takes {count} buffers of {} bytes and can bind {most}",
                chunk_words * size_of::<Word>()
            );
            return Err(device.too_large(bytes, message));
        }
        let chunks = packed
            .words
            .chunks(chunk_words)
            .map(|words| upload(device, words))
            .collect::<Result<Vec<_>, GpuError>>()?;
        // Few numbers of buffers, so that few shaders are needed.
        let bound = count.next_power_of_two().min(most);
        let tolerances = Tolerances::of(blobs, bounds);
        let capacity = options.capacity.unwrap_or(CAPACITIES[0]);
        Ok(Self {
            field_origin: blobs.field.origin,
            bounds,
            shutter_secs: tree.shutter_secs,
            chunks,
            capacities: [capacity, CAPACITIES[1].max(capacity)],
            kind: ShaderKind {
                kernel: blobs.field.kernel,
                ellipsoids: matches!(blobs.field.shapes, Shapes::Ellipsoids(_)),
                moves: tree.moves(),
                chunks: bound,
                chunk_bits,
                stack: packed
                    .stack
                    .next_power_of_two()
                    .clamp(SMALLEST_STACK, DEEPEST_STACK),
            },
            params: [
                blobs.field.threshold.to_bits(),
                tolerances.crossing.to_bits(),
                tolerances.rounding.to_bits(),
                tolerances.near_start.to_bits(),
                (LONGEST_STRETCH * tree.typical_support).to_bits(),
                0,
                packed.leaves_at,
                0,
            ],
            idle: Mutex::default(),
            batch: AtomicUsize::new(BATCH),
        })
    }

    pub(crate) fn clip(&self, ray: &Ray) -> Option<ClippedRay> {
        ClippedRay::new(self.field_origin, self.bounds, ray)
    }

    /// Sends rays batch by batch; returns the device's own time in seconds.
    pub(crate) fn send(
        &self,
        device: &Device,
        question: Question,
        room: usize,
        rays: &[Ray],
        waiting: &[Sent],
        mut visit: impl FnMut(&Sent, &HitRecord),
    ) -> Result<f64, GpuError> {
        let mut seconds = 0.0;
        if waiting.is_empty() {
            return Ok(seconds);
        }
        let program = device.programs.get(device, self.kind);
        let call = Call {
            pipeline: program.pipeline(device, question),
            params: self.params,
            capacity: self.capacities[room],
            workgroup: WORKGROUP,
        };
        let batch = self.borrow(device, &program.group_layout)?;
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
            for (sent, record) in now.iter().zip(&hits) {
                visit(sent, record);
            }
            rest = later;
        }
        self.idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(batch);
        Ok(seconds)
    }

    /// A ray as the shader reads it.
    fn record(&self, ray: &Ray, clipped: &ClippedRay) -> RayRecord {
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

    fn borrow(&self, device: &Device, layout: &wgpu::BindGroupLayout) -> Result<Batch, GpuError> {
        let idle = self
            .idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop();
        match idle {
            Some(batch) => Ok(batch),
            None => Batch::new(device, room(device), |buffers| {
                let mut entries: Vec<wgpu::BindGroupEntry<'_>> = Vec::new();
                // Bindings without a buffer of their own are never read.
                let spare = self.chunks.iter().cycle().skip(self.chunks.len());
                let spare = spare.take(self.kind.chunks as usize - self.chunks.len());
                let chunks = self.chunks.iter().chain(spare);
                for (binding, buffer) in (0..).zip(buffers.into_iter().chain(chunks)) {
                    entries.push(wgpu::BindGroupEntry {
                        binding,
                        resource: buffer.as_entire_binding(),
                    });
                }
                device.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("trace"),
                    layout,
                    entries: &entries,
                })
            }),
        }
    }
}

/// What a batch has room for: no more blobs than the adapter binds.
fn room(device: &Device) -> Room {
    let limits = &device.limits;
    let largest = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    Room {
        rays: BATCH,
        met: (BATCH * CAPACITIES[0] as usize).min((largest / MET_BLOB_BYTES) as usize),
    }
}

/// Words per buffer, as a power of two.
fn chunk_bits(device: &Device, options: TracerOptions) -> u32 {
    let limits = &device.limits;
    let largest = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
        .min(options.largest_chunk_bytes.unwrap_or(u64::MAX));
    let words = (largest / size_of::<Word>() as u64).max(1);
    words.ilog2().min(MOST_CHUNK_BITS)
}

/// Bytes written at once, so that what is on its way stays small.
const PORTION: usize = 16 << 20;

fn upload(device: &Device, words: &[Word]) -> Result<wgpu::Buffer, GpuError> {
    let bytes: &[u8] = bytemuck::cast_slice(words);
    let buffer = device.within_memory(bytes.len() as u64, || {
        device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("field"),
            size: bytes.len() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    })?;
    for (portion, bytes) in bytes.chunks(PORTION).enumerate() {
        let at = (portion * PORTION) as u64;
        device.queue.write_buffer(&buffer, at, bytes);
        if bytes.len() == PORTION {
            device.queue.submit([]);
            device.wait()?;
        }
    }
    Ok(buffer)
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
