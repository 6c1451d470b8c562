//! Samples under way on the device: their buffers, and the rounds in which they ask and are told.

use super::Field;
use super::picture::PICTURE_BYTES;
use super::programs::{Common, STAGE_BUFFERS};
use crate::batch::{MET_BLOB_BYTES, PARAMS_BYTES};
use crate::device::Device;
use crate::error::GpuError;
use crate::program::{Program, Question};
use crate::readback::{self, Clock, TIME_BYTES};
use crate::shader::WORKGROUP;
use crate::stage::dispatch;
use crate::uploaded::CAPACITIES;
use glam::DVec3;
use meniscus::render::{StagedHit, StagedSample};
use meniscus::shade::RayCounts;
use std::sync::Arc;

/// Bytes of a sample's state, its two questions, its two answers, what it saw, a ray, its owner, its hit:
/// the structs of `shaders/shade/asking.wgsl` and `shaders/intersect/clip.wgsl`.
const STATE_BYTES: u64 = 112;
const QUESTION_BYTES: u64 = 64;
const ANSWER_BYTES: u64 = 80;
const SEEN_BYTES: u64 = 48;
const RAY_BYTES: u64 = 64;
const OWNER_BYTES: u64 = 12;
const HIT_BYTES: u64 = 32;
/// Of `shaders/shade/varying.wgsl`.
const LOOK_BYTES: u64 = 48;
/// Of `shaders/math/differential.wgsl`, of a sample and of each branch that waits, and of
/// `shaders/math/level_set.wgsl`.
const DIFFERENTIAL_BYTES: u64 = 112;
const LEVEL_SET_BYTES: u64 = 80;
/// Bytes of a branch of `whitted` (`shaders/shade/integrator/whitted.wgsl`), and most that wait per sample.
const BRANCH_BYTES: u64 = 96;
const MOST_BRANCHES: u64 = 8;
/// Counters, in words: rays on their way (2), samples that go on, rays by purpose (6).
const COUNTERS: usize = 9;
const COUNTER_BYTES: u64 = 4 * COUNTERS as u64;
const GOING_ON: usize = 2;
const PLACE_BYTES: u64 = 64;
/// Places in the tree's parameters, in bytes and words: number of rays, room.
const PARAMS_RAYS: u64 = 20;
const PARAMS_CAPACITY: usize = 7;

/// A card's samples under way at most, and those of a driver that runs on the processor.
const MOST_SAMPLES: u64 = 1 << 18;
const MOST_ON_SOFTWARE: u64 = 1 << 14;

/// One of a sample's two questions about one field.
struct Asked {
    question: Question,
    /// `FieldPlace`.
    place: wgpu::Buffer,
    group: wgpu::BindGroup,
    params: wgpu::Buffer,
    trace: wgpu::BindGroup,
    program: Arc<Program>,
}

/// Buffers for samples under way.
pub(crate) struct Wave {
    picture: wgpu::Buffer,
    seen: wgpu::Buffer,
    counters: wgpu::Buffer,
    back: wgpu::Buffer,
    clock: Option<Clock>,
    group: wgpu::BindGroup,
    /// By field: about first surfaces, and about lights.
    asked: Vec<[Asked; 2]>,
    /// Of the fields where highlights are widened: the stage that takes derivatives, and its buffers.
    derivatives: Vec<(wgpu::ComputePipeline, wgpu::BindGroup)>,
    /// The same of those whose looks follow attributes.
    blends: Vec<(wgpu::ComputePipeline, wgpu::BindGroup)>,
    capacity: u64,
}

/// What a wave has to hold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    /// Samples.
    pub(crate) capacity: u64,
    /// Whether light may pass clear surfaces on its way.
    pub(crate) light_walks: bool,
    /// Branches of each sample that wait; those of samples with more are the processor's.
    pub(crate) branches: u64,
    /// Whether looks follow attributes.
    pub(crate) varies: bool,
    /// Whether highlights are widened.
    pub(crate) antialiases: bool,
}

/// Branches that wait in a tree as deep as this.
pub(crate) fn branches(depth: u32) -> u64 {
    u64::from(depth).min(MOST_BRANCHES)
}

/// Samples that a device has room for at a time; `None` where it binds too few buffers.
pub(crate) fn capacity(device: &Device, branches: u64, antialiases: bool) -> Option<u64> {
    if device.limits.max_storage_buffers_per_shader_stage < STAGE_BUFFERS {
        return None;
    }
    let largest = device.largest_binding();
    let differentials = u64::from(antialiases) * (1 + branches) * DIFFERENTIAL_BYTES;
    let per_sample = (MET_BLOB_BYTES * u64::from(CAPACITIES[0]))
        .max(branches * BRANCH_BYTES)
        .max(differentials);
    let most = if device.is_software() {
        MOST_ON_SOFTWARE
    } else {
        MOST_SAMPLES
    };
    Some((largest / per_sample).min(most) / u64::from(WORKGROUP) * u64::from(WORKGROUP))
}

impl Wave {
    pub(crate) fn new(
        device: &Device,
        common: &Common,
        words: &wgpu::Buffer,
        fields: &[Field<'_>],
        shape: Shape,
    ) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Usage;
        let Shape {
            capacity,
            light_walks,
            branches,
            varies,
            antialiases,
        } = shape;
        let looks = if varies { 2 * capacity } else { 1 };
        let [differentials, level_sets] = match antialiases {
            true => [capacity * (1 + branches), capacity],
            false => [1; 2],
        };
        let met = capacity * u64::from(CAPACITIES[0]);
        let per_sample = STATE_BYTES
            + 2 * (QUESTION_BYTES + ANSWER_BYTES + SEEN_BYTES)
            + RAY_BYTES
            + OWNER_BYTES
            + HIT_BYTES
            + branches * BRANCH_BYTES;
        let bytes = capacity * per_sample + met * (MET_BLOB_BYTES + 4) + looks * LOOK_BYTES;
        let bytes = bytes + differentials * DIFFERENTIAL_BYTES + level_sets * LEVEL_SET_BYTES;
        let buffer = |label, size, usage| {
            device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        device.within_memory(bytes, || {
            let storage = |label, size| buffer(label, size, Usage::STORAGE);
            let uniform = |label, size| buffer(label, size, Usage::UNIFORM | Usage::COPY_DST);
            let read = |label, size| buffer(label, size, Usage::STORAGE | Usage::COPY_SRC);
            let picture = uniform("picture", PICTURE_BYTES);
            let states = storage("states", capacity * STATE_BYTES);
            let questions = storage("questions", 2 * capacity * QUESTION_BYTES);
            let answers = storage("answers", 2 * capacity * ANSWER_BYTES);
            let seen = read("seen", capacity * SEEN_BYTES);
            let counters = buffer(
                "counters",
                COUNTER_BYTES,
                Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
            );
            let rays = storage("rays", capacity * RAY_BYTES);
            let owners = storage("owners", capacity * OWNER_BYTES);
            let hits = storage("hits", capacity * HIT_BYTES);
            let branches = storage("branches", (capacity * branches).max(1) * BRANCH_BYTES);
            let lists = [MET_BLOB_BYTES, 4].map(|bytes| storage("met blobs", met * bytes));
            let back = buffer(
                "back",
                capacity * SEEN_BYTES + COUNTER_BYTES + 4 + TIME_BYTES,
                Usage::MAP_READ | Usage::COPY_DST,
            );
            let looks = storage("looks", looks * LOOK_BYTES);
            let differentials = storage("differentials", differentials * DIFFERENTIAL_BYTES);
            let level_sets = storage("level sets", level_sets * LEVEL_SET_BYTES);
            let bound = |place: &wgpu::Buffer, [rays, owners, hits]: [&wgpu::Buffer; 3]| {
                let buffers = [
                    &picture, words, &states, &questions, &answers, &seen, &counters, place, rays,
                    owners, hits, &branches,
                ];
                common.bindings.group(&device.device, buffers)
            };
            let mut blends = Vec::new();
            let mut derivatives = Vec::new();
            let ask = |field: &Field<'_>, (kind, question)| {
                let uploaded = field.uploaded;
                let place = uniform("place", PLACE_BYTES);
                let record = place_record(field, kind);
                (device.queue).write_buffer(&place, 0, bytemuck::cast_slice(&record));
                let params = uniform("params", PARAMS_BYTES);
                let mut numbers = uploaded.params();
                numbers[PARAMS_CAPACITY] = CAPACITIES[0];
                (device.queue).write_buffer(&params, 0, bytemuck::cast_slice(&numbers));
                let program = uploaded.program(device);
                let buffers = [&params, &rays, &hits, &lists[0], &lists[1]];
                Asked {
                    question,
                    group: bound(&place, [&rays, &owners, &hits]),
                    place,
                    trace: uploaded.bound(device, &program, buffers),
                    params,
                    program,
                }
            };
            let asked = fields.iter().map(|field| {
                // Light that passes clear surfaces has to know which.
                let for_lights = match light_walks {
                    true => Question::First,
                    false => Question::Any,
                };
                let asked = [(0, Question::First), (1, for_lights)].map(|asked| ask(field, asked));
                let [Asked { place, params, .. }, _] = &asked;
                if let Some(program) = &field.derivatives {
                    let own = [
                        &picture,
                        words,
                        &questions,
                        &answers,
                        place,
                        &differentials,
                        &level_sets,
                        params,
                    ];
                    let group = program.group(device, field.uploaded, own);
                    derivatives.push((program.pipeline.clone(), group));
                }
                if let Some(blend) = &field.blend {
                    let shared = [
                        &picture, words, &states, &questions, &answers, place, &looks, params,
                    ];
                    let group = blend.group(device, field.uploaded, shared);
                    blends.push((blend.pipeline().clone(), group));
                }
                asked
            });
            Self {
                asked: asked.collect(),
                derivatives,
                blends,
                group: bound(
                    &uniform("place", PLACE_BYTES),
                    [&looks, &differentials, &level_sets],
                ),
                clock: Clock::new(device),
                picture,
                seen,
                counters,
                back,
                capacity,
            }
        })
    }

    /// Starts samples: the eye's rays.
    pub(crate) fn begin(&self, device: &Device, common: &Common, picture: &[u32]) {
        device
            .queue
            .write_buffer(&self.picture, 0, bytemuck::cast_slice(picture));
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.clear_buffer(&self.counters, 0, None);
        let times = self.clock.as_ref().map(Clock::beginning);
        let groups = self.groups();
        self.stage(device, &mut encoder, &common.begin, groups, times);
        device.queue.submit([encoder.finish()]);
    }

    fn groups(&self) -> u32 {
        (self.capacity as u32).div_ceil(WORKGROUP)
    }

    fn stage(
        &self,
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::ComputePipeline,
        groups: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("stage"),
            timestamp_writes,
        });
        dispatch(device, &mut pass, pipeline, &self.group, groups);
    }

    /// Has all questions answered that `asks` (for first surfaces, for lights) may hold, for `count`
    /// samples, and lets the integrator go on.
    pub(crate) fn round(
        &self,
        device: &Device,
        common: &Common,
        integrator: &wgpu::ComputePipeline,
        asks: [bool; 2],
        count: u32,
    ) {
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let groups = count.div_ceil(WORKGROUP);
        encoder.clear_buffer(&self.counters, 4 * GOING_ON as u64, Some(4));
        self.stage(device, &mut encoder, &common.solids, groups, None);
        for asked in &self.asked {
            for (kind, asked) in (0..).zip(asked) {
                if !asks[kind] {
                    continue;
                }
                let counter = 4 * kind as u64;
                encoder.clear_buffer(&self.counters, counter, Some(4));
                let pass = |encoder: &mut wgpu::CommandEncoder, pipeline, group| {
                    let mut pass =
                        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                    dispatch(device, &mut pass, pipeline, group, groups);
                };
                pass(&mut encoder, &common.clip, &asked.group);
                encoder.copy_buffer_to_buffer(
                    &self.counters,
                    counter,
                    &asked.params,
                    PARAMS_RAYS,
                    4,
                );
                let trace = asked.program.pipeline(device, asked.question);
                pass(&mut encoder, trace, &asked.trace);
                pass(&mut encoder, &common.merge, &asked.group);
            }
        }
        // What they look at are first surfaces.
        let derivatives = self.derivatives.iter().filter(|_| asks[0]);
        for (pipeline, group) in derivatives.chain(&self.blends) {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            dispatch(device, &mut pass, pipeline, group, groups);
        }
        self.stage(device, &mut encoder, integrator, groups, None);
        device.count_batch();
        device.queue.submit([encoder.finish()]);
    }

    /// How many samples go on after the last round.
    pub(crate) fn going_on(&self, device: &Device) -> Result<u32, GpuError> {
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(&self.counters, 4 * GOING_ON as u64, &self.back, 0, 4);
        device.queue.submit([encoder.finish()]);
        readback::read(device, &self.back, 4, |view| {
            bytemuck::pod_read_unaligned(view)
        })
    }

    /// What the samples saw; returns the device's own time in seconds, 0 where it keeps none.
    pub(crate) fn finish(
        &self,
        device: &Device,
        common: &Common,
        count: u32,
        samples: &mut Vec<StagedSample>,
        rays: &mut RayCounts,
    ) -> Result<f64, GpuError> {
        let mut encoder = device
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        if let Some(clock) = &self.clock {
            // A pass that does nothing ends when all before it has ended.
            self.stage(device, &mut encoder, &common.solids, 0, Some(clock.end()));
        }
        let seen_bytes = u64::from(count) * SEEN_BYTES;
        encoder.copy_buffer_to_buffer(&self.counters, 0, &self.back, 0, COUNTER_BYTES);
        // Times lie at multiples of 8.
        let times_at = COUNTER_BYTES + 4;
        let seen_at = times_at + TIME_BYTES;
        if let Some(clock) = &self.clock {
            clock.copy_to(&mut encoder, &self.back, times_at);
        }
        encoder.copy_buffer_to_buffer(&self.seen, 0, &self.back, seen_at, seen_bytes);
        device.queue.submit([encoder.finish()]);
        readback::read(device, &self.back, seen_at + seen_bytes, |view| {
            let (head, records) = view.split_at(seen_at as usize);
            let counters: [u32; COUNTERS] =
                bytemuck::pod_read_unaligned(&head[..COUNTER_BYTES as usize]);
            let [
                _,
                _,
                _,
                primary,
                shadow,
                reflection,
                refraction,
                ambient_occlusion,
                diffuse,
            ] = counters.map(u64::from);
            *rays += RayCounts {
                primary,
                shadow,
                reflection,
                refraction,
                ambient_occlusion,
                diffuse,
            };
            samples.clear();
            samples.extend(
                records
                    .chunks_exact(SEEN_BYTES as usize)
                    .map(|record| sample_of(&bytemuck::pod_read_unaligned(record))),
            );
            self.clock
                .as_ref()
                .map_or(0.0, |_| Clock::seconds(device, &head[times_at as usize..]))
        })
    }
}

/// `Seen` in `shaders/shade/asking.wgsl`.
fn sample_of(record: &[u32; 12]) -> StagedSample {
    let vector =
        |at: usize| glam::Vec3::from_array([0, 1, 2].map(|axis| f32::from_bits(record[at + axis])));
    let index = |index: u32| (index != u32::MAX).then_some(index);
    let (outcome, entering) = (record[3] & 3, record[3] & 4 != 0);
    match outcome {
        0 => StagedSample::InDoubt,
        outcome => StagedSample::Seen {
            radiance: vector(0),
            is_covered: outcome > 1,
            hit: (outcome == 3).then(|| StagedHit {
                position: vector(4),
                normal: vector(8),
                surface: record[7],
                blob: index(record[11]),
                entering,
            }),
        },
    }
}

/// `FieldPlace` in `shaders/intersect/clip.wgsl`.
fn place_record(field: &Field<'_>, kind: u32) -> [u32; 16] {
    let uploaded = field.uploaded;
    let high = field.offset.as_vec3();
    let low: DVec3 = field.offset - high.as_dvec3();
    let bounds = uploaded.bounds();
    let [open, close] = uploaded.shutter_secs();
    let rows = [
        (high, field.surface),
        (low.as_vec3(), kind),
        (bounds.min, (open as f32).to_bits()),
        (bounds.max, (close as f32).to_bits()),
    ];
    let mut record = [0; 16];
    for (row, (v, w)) in record.chunks_exact_mut(4).zip(rows) {
        row[..3].copy_from_slice(&v.to_array().map(f32::to_bits));
        row[3] = w;
    }
    record
}
