//! One round: lists of balls per tile, then surfaces, by either variant.

use super::balls::Balls;
use super::field::PeelWork;
use super::programs::{Program, Solve};
use super::room::{HIT_BYTES, Own, Room};
use super::slots::Slots;
use super::sprites;
use super::times::Stage;
use crate::batch::HitRecord;
use crate::device::Device;
use crate::error::GpuError;
use glam::DVec3;
use std::sync::mpsc;
use std::time::Duration;

/// How long a submission may take before the device counts as lost.
const PATIENCE: Duration = Duration::from_secs(120);

/// `HitRecord::status`.
const MISS: u32 = 0;
const HIT: u32 = 1;
const NO_LIST: u32 = 4;

/// What became of a ray.
pub(super) enum Answer {
    Miss,
    Hit(Found),
    /// It has to be answered otherwise.
    Open,
    /// The lists of its tile did not fit.
    NoList,
}

/// A surface that a ray meets.
pub(super) struct Found {
    /// From where the ray enters the field's box.
    pub(super) along: f64,
    pub(super) outward: DVec3,
    pub(super) strongest: u32,
    pub(super) entering: bool,
}

/// What a round is run with.
pub(super) struct Call<'a> {
    pub(super) device: &'a Device,
    pub(super) program: &'a Program,
    pub(super) balls: &'a Balls,
    pub(super) params: [u32; 40],
    pub(super) slots: &'a Slots,
}

impl Call<'_> {
    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
    }

    /// Binds numbered buffers as a pipeline's shader wants them.
    pub(super) fn bind(
        &self,
        layout: &wgpu::BindGroupLayout,
        room: &Room,
        numbers: &[u32],
    ) -> wgpu::BindGroup {
        let layers = match &room.own {
            Own::Sprites(layers) => Some(&**layers),
            Own::Tiles { .. } => None,
        };
        let entries: Vec<wgpu::BindGroupEntry<'_>> = numbers
            .iter()
            .filter_map(|&binding| {
                let buffer = match binding {
                    0 => &room.params,
                    1 => &room.rays,
                    2 => &room.hits,
                    3 | 4 => match &room.own {
                        Own::Tiles { met } => &met[binding as usize - 3],
                        Own::Sprites(_) => return None,
                    },
                    5 => &self.balls.shapes,
                    6 => &self.balls.traits,
                    7 => &room.pairs,
                    8 => &room.starts,
                    9 => &room.tiles,
                    10 => &room.groups,
                    11 => &room.counts,
                    12 => &layers?.states,
                    13 => &layers?.lists,
                    14 => &layers?.finished,
                    15 | 19 => &layers?.seen,
                    16 => &room.drawing,
                    17 | 18 => {
                        let layers = layers?;
                        let view = if binding == 17 {
                            &layers.depths
                        } else {
                            &layers.events
                        };
                        return Some(wgpu::BindGroupEntry {
                            binding,
                            resource: wgpu::BindingResource::TextureView(view),
                        });
                    }
                    _ => return None,
                };
                Some(wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
            })
            .collect();
        self.device
            .device
            .create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("peel"),
                layout,
                entries: &entries,
            })
    }

    /// Runs a pipeline over `groups` workgroups.
    pub(super) fn dispatch(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        pipeline: &wgpu::ComputePipeline,
        (room, numbers): (&Room, &[u32]),
        groups: u32,
    ) {
        let bound = self.bind(&pipeline.get_bind_group_layout(0), room, numbers);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bound, &[]);
        let width = groups.min(self.device.limits.max_compute_workgroups_per_dimension);
        pass.dispatch_workgroups(width, groups.div_ceil(width.max(1)), 1);
    }

    /// Sends what is encoded and reads the first `bytes` of `room.back`; the stamps of the clock lie at
    /// `stamps`.
    pub(super) fn send(
        &self,
        room: &mut Room,
        mut encoder: wgpu::CommandEncoder,
        bytes: u64,
        work: &mut PeelWork,
        read: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        let stamps = match &room.clock {
            Some(clock) => clock.resolve(&mut encoder, &room.back, bytes),
            None => 0,
        };
        let device = self.device;
        device.count_batch();
        device.queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        let all = 0..bytes + stamps;
        room.back
            .map_async(wgpu::MapMode::Read, all.clone(), move |result| {
                // Nobody waits any more where the receiver is gone.
                let _ = sender.send(result);
            });
        device.wait()?;
        match receiver.recv_timeout(PATIENCE) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(device.lost(error.to_string())),
            Err(_) => return Err(device.lost("it gives no answer".to_owned())),
        }
        {
            let view = room
                .back
                .get_mapped_range(all)
                .map_err(|error| device.lost(error.to_string()))?;
            read(&view[..bytes as usize]);
            if let Some(clock) = &mut room.clock {
                clock.read(device, &view[bytes as usize..], &mut work.secs);
            }
        }
        room.back.unmap();
        Ok(())
    }
}

/// Balls that one workgroup looks at.
const BALLS_PER_GROUP: u32 = 256;

/// Runs a round; calls `answer` with each ray that is in a slot, and returns how many pairs there are.
pub(super) fn run(
    room: &mut Room,
    call: &Call<'_>,
    work: &mut PeelWork,
    mut answer: impl FnMut(usize, Answer),
) -> Result<u32, GpuError> {
    let slots = call.slots;
    call.device.check()?;
    let mut encoder = begin(room, call)?;
    match &call.program.solve {
        Solve::Tiles(pipeline) => {
            let mut clock = room.clock.take();
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some("tiled"),
                    timestamp_writes: clock.as_mut().and_then(|clock| clock.compute(Stage::Solve)),
                });
                let numbers = [0, 1, 2, 3, 4, 5, 6, 7, 8];
                let groups = slots.groups.len() as u32;
                call.dispatch(&mut pass, pipeline, (room, &numbers), groups);
            }
            room.clock = clock;
        }
        Solve::Sprites(programs) => encoder = sprites::run(room, call, programs, encoder, work)?,
    }
    let hit_bytes = slots.records.len() as u64 * HIT_BYTES;
    encoder.copy_buffer_to_buffer(&room.hits, 0, &room.back, 0, hit_bytes);
    let last_start = 4 * slots.groups.len() as u64;
    encoder.copy_buffer_to_buffer(&room.starts, last_start, &room.back, hit_bytes, 4);
    let mut listed = 0;
    // Stamps lie at multiples of eight bytes.
    call.send(room, encoder, hit_bytes + 8, work, |bytes| {
        let (hits, rest) = bytes.split_at(hit_bytes as usize);
        listed = bytemuck::pod_read_unaligned(&rest[..4]);
        for (record, &ray) in hits.chunks_exact(HIT_BYTES as usize).zip(&slots.rays) {
            if ray != usize::MAX {
                answer(ray, answer_of(&bytemuck::pod_read_unaligned(record)));
            }
        }
    })?;
    work.rounds += 1;
    work.listed += u64::from(listed);
    Ok(listed)
}

/// Sends the rays and has the tiles' lists made.
pub(super) fn begin(room: &mut Room, call: &Call<'_>) -> Result<wgpu::CommandEncoder, GpuError> {
    let (device, slots) = (call.device, call.slots);
    room.fit_tiles(device, slots.tiles.len())?;
    let queue = &device.queue;
    queue.write_buffer(&room.params, 0, bytemuck::cast_slice(&call.params));
    queue.write_buffer(&room.rays, 0, bytemuck::cast_slice(&slots.records));
    queue.write_buffer(&room.groups, 0, bytemuck::cast_slice(&slots.groups));
    queue.write_buffer(&room.tiles, 0, bytemuck::cast_slice(&slots.tiles));
    let mut encoder = call.encoder();
    encoder.clear_buffer(&room.counts, 0, None);
    make_lists(room, call, &mut encoder);
    Ok(encoder)
}

fn make_lists(room: &mut Room, call: &Call<'_>, encoder: &mut wgpu::CommandEncoder) {
    let mut clock = room.clock.take();
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("lists"),
            timestamp_writes: clock.as_mut().and_then(|clock| clock.compute(Stage::Lists)),
        });
        let lists = &call.program.lists;
        let by_balls = call.balls.count.div_ceil(BALLS_PER_GROUP);
        let groups = call.slots.groups.len() as u32;
        call.dispatch(
            &mut pass,
            &lists.count,
            (room, &[0, 5, 9, 10, 11]),
            by_balls,
        );
        call.dispatch(&mut pass, &lists.scan, (room, &[0, 8, 11, 16]), 1);
        call.dispatch(
            &mut pass,
            &lists.fill,
            (room, &[0, 5, 7, 8, 9, 10, 11]),
            by_balls,
        );
        call.dispatch(&mut pass, &lists.sort, (room, &[0, 7, 8]), groups);
    }
    room.clock = clock;
}

fn answer_of(record: &HitRecord) -> Answer {
    let number = |i: usize| f64::from(f32::from_bits(record[i]));
    match record[0] {
        MISS => Answer::Miss,
        HIT => Answer::Hit(Found {
            along: number(1) + number(2),
            outward: DVec3::new(number(4), number(5), number(6)),
            strongest: record[3],
            entering: record[7] != 0,
        }),
        NO_LIST => Answer::NoList,
        _ => Answer::Open,
    }
}
