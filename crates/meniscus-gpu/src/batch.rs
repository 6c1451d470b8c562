//! Rays to the device and hits back.

use crate::device::Device;
use crate::error::GpuError;
use crate::readback::{self, Clock, TIME_BYTES};
use crate::stage;

/// A ray as the shader reads it (`LocalRay` in `shaders/accel/particles.wgsl`), in bits.
pub(crate) type RayRecord = [u32; 16];

/// A hit as the shader writes it (`HitRecord` in `shaders/intersect/particles.wgsl`), in bits.
pub(crate) type HitRecord = [u32; 8];

/// What the shader knows beside the field (`Params` in `shaders/field/blobs.wgsl`), in bits.
pub(crate) type ParamsRecord = [u32; 12];

/// Place of the number of rays in the parameters.
const PARAMS_RAYS: usize = 5;

/// Place of the number of blobs that a stretch may meet.
const PARAMS_CAPACITY: usize = 7;

const RAY_BYTES: u64 = size_of::<RayRecord>() as u64;
const HIT_BYTES: u64 = size_of::<HitRecord>() as u64;
/// A blob that a ray meets.
pub(crate) const MET_BLOB_BYTES: u64 = 16;
/// The same, and its word.
const MET_BYTES: [u64; 2] = [MET_BLOB_BYTES, 4];
pub(crate) const PARAMS_BYTES: u64 = size_of::<ParamsRecord>() as u64;
/// Buffers for one batch of rays, reused.
pub(crate) struct Batch {
    params: wgpu::Buffer,
    rays: wgpu::Buffer,
    hits: wgpu::Buffer,
    back: wgpu::Buffer,
    clock: Option<Clock>,
    group: wgpu::BindGroup,
    room: Room,
}

/// How much a batch has room for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Room {
    /// Rays.
    pub(crate) rays: usize,
    /// Records that each of them is answered with.
    pub(crate) records: u32,
    /// Blobs that all of them meet at a time.
    pub(crate) met: usize,
}

impl Room {
    /// Rays that may meet `capacity` blobs each, in whole workgroups.
    fn rays_with(&self, capacity: u32, workgroup: u32) -> usize {
        let groups = self.met / (capacity as usize * workgroup as usize);
        self.rays.min(groups.max(1) * workgroup as usize)
    }
}

/// What to run a batch by.
pub(crate) struct Call<'a> {
    pub(crate) pipeline: &'a wgpu::ComputePipeline,
    pub(crate) params: ParamsRecord,
    /// Blobs that a stretch of a ray may meet.
    pub(crate) capacity: u32,
    /// Rays per workgroup.
    pub(crate) workgroup: u32,
}

impl Batch {
    /// Buffers for `room`, bound beside the field's buffers by `bind`.
    pub(crate) fn new(
        device: &Device,
        room: Room,
        bind: impl FnOnce([&wgpu::Buffer; 5]) -> wgpu::BindGroup,
    ) -> Result<Self, GpuError> {
        let (count, met) = (room.rays as u64, room.met as u64);
        let all_hit_bytes = count * u64::from(room.records) * HIT_BYTES;
        let bytes = count * RAY_BYTES + 2 * all_hit_bytes + met * MET_BYTES.iter().sum::<u64>();
        let buffer = |label, size, usage| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        device.within_memory(bytes, || {
            let params = buffer("params", PARAMS_BYTES, Usage::UNIFORM | Usage::COPY_DST);
            let rays = buffer("rays", count * RAY_BYTES, Usage::STORAGE | Usage::COPY_DST);
            let hits = buffer("hits", all_hit_bytes, Usage::STORAGE | Usage::COPY_SRC);
            let lists = MET_BYTES.map(|bytes| buffer("met blobs", met * bytes, Usage::STORAGE));
            let back_bytes = all_hit_bytes + TIME_BYTES;
            let back = buffer("back", back_bytes, Usage::MAP_READ | Usage::COPY_DST);
            let clock = Clock::new(device);
            let group = bind([&params, &rays, &hits, &lists[0], &lists[1]]);
            Self {
                params,
                rays,
                hits,
                back,
                clock,
                group,
                room,
            }
        })
    }

    /// Rays that may be sent together.
    pub(crate) fn most(&self, call: &Call<'_>) -> usize {
        self.room.rays_with(call.capacity, call.workgroup)
    }

    /// Traces `rays`, no more than there is room for, and reads what they hit into `hits`, the records of
    /// a ray after those of the one before; returns the device's own time in seconds, where it keeps one.
    pub(crate) fn run(
        &self,
        device: &Device,
        call: &Call<'_>,
        rays: &[RayRecord],
        hits: &mut Vec<HitRecord>,
    ) -> Result<Option<f64>, GpuError> {
        device.check()?;
        let mut params = call.params;
        params[PARAMS_RAYS] = rays.len() as u32;
        params[PARAMS_CAPACITY] = call.capacity;
        let queue = &device.queue;
        queue.write_buffer(&self.params, 0, bytemuck::cast_slice(&params));
        queue.write_buffer(&self.rays, 0, bytemuck::cast_slice(rays));
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("trace"),
                timestamp_writes: self.clock.as_ref().map(Clock::writes),
            });
            let groups = (rays.len() as u32).div_ceil(call.workgroup);
            stage::dispatch(device, &mut pass, call.pipeline, &self.group, groups);
        }
        let records = rays.len() * self.room.records as usize;
        let hit_bytes = records as u64 * HIT_BYTES;
        encoder.copy_buffer_to_buffer(&self.hits, 0, &self.back, 0, hit_bytes);
        let mut back_bytes = hit_bytes;
        if let Some(clock) = &self.clock {
            clock.copy_to(&mut encoder, &self.back, hit_bytes);
            back_bytes += TIME_BYTES;
        }
        device.count_batch();
        queue.submit([encoder.finish()]);
        readback::read(device, &self.back, back_bytes, |view| {
            let (found, times) = view.split_at(hit_bytes as usize);
            hits.clear();
            hits.resize(records, [0; 8]);
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(hits);
            bytes.copy_from_slice(found);
            self.clock.as_ref().map(|_| Clock::seconds(device, times))
        })
    }
}
