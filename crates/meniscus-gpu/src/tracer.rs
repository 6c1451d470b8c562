//! One field on the device: uploaded, and asked about rays.

use crate::batch::{Batch, Call, HitRecord, MET_BLOB_BYTES, ParamsRecord, RayRecord, Room};
use crate::device::Device;
use crate::error::GpuError;
use crate::pack::{Packed, Word, pack};
use crate::program::Question;
use crate::shader::{ShaderKind, WORKGROUP};
use glam::DVec3;
use meniscus::accel::Accel;
use meniscus::accel::particles::ParticleTree;
use meniscus::frame::Blobs;
use meniscus::intersect::particles::LONGEST_STRETCH;
use meniscus::intersect::{BlobHit, ClippedRay, Scratch, Tolerances};
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Rays that are sent together.
const BATCH: usize = 1 << 15;

/// No fewer are sent together, however long they take.
const LEAST_BATCH: usize = 1 << 10;

/// Drivers reset cards after some seconds; batches that take a part of one are halved.
const LONGEST_BATCH: Duration = Duration::from_millis(400);

/// Blobs that a stretch of a ray may meet: at first, and for rays that need more.
const CAPACITIES: [u32; 2] = [96, 512];

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

/// `HitRecord::status`.
const HIT: u32 = 1;
const IN_DOUBT: u32 = 2;
const NO_ROOM: u32 = 3;

/// How a field is put on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TracerOptions {
    /// Largest buffer, where it shall be smaller than what the adapter allows: for tests.
    pub largest_chunk_bytes: Option<u64>,
    /// Blobs that a stretch may meet at first, where it shall be another number: for tests.
    pub capacity: Option<u32>,
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TraceWork {
    /// Rays asked about.
    pub rays: u64,
    /// Rays that met more blobs at once than the first try has room for.
    pub crowded: u64,
    /// Rays that the CPU answered.
    pub on_cpu: u64,
    /// Time of the device by its own clock, in seconds; 0 where it keeps none.
    pub device_secs: f64,
}

impl std::ops::AddAssign for TraceWork {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.crowded += other.crowded;
        self.on_cpu += other.on_cpu;
        self.device_secs += other.device_secs;
    }
}

/// A field on a device.
pub struct FieldTracer<'d> {
    device: &'d Device,
    /// `None`: there is nothing to hit.
    uploaded: Option<Uploaded>,
    bytes: u64,
}

struct Uploaded {
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
struct Sent {
    /// Index of the caller's ray.
    index: usize,
    clipped: ClippedRay,
}

impl<'d> FieldTracer<'d> {
    /// Puts the field of `blobs` and its tree on a device; builds the tree where `blobs` has another
    /// structure.
    ///
    /// # Errors
    /// Where it does not fit, or the device fails.
    pub fn upload(
        device: &'d Device,
        blobs: &Blobs,
        options: TracerOptions,
    ) -> Result<Self, GpuError> {
        let built;
        let tree = match &blobs.accel {
            Accel::Particles(tree) | Accel::Interval(tree) => tree,
            Accel::Cells(_) | Accel::Metaballs(_) | Accel::Sweep(_) => {
                built = ParticleTree::build(&blobs.field, blobs.settings.builder);
                &built
            }
        };
        let Some(bounds) = tree.bounds.filter(|_| !tree.nodes.is_empty()) else {
            return Ok(Self {
                device,
                uploaded: None,
                bytes: 0,
            });
        };
        let Some(packed) = pack(&blobs.field, tree) else {
            let message = "its words cannot be numbered in 32 bits".to_owned();
            return Err(device.too_large(0, message));
        };
        let bytes = size_of_val(&packed.words[..]) as u64;
        let uploaded = Uploaded::new(device, blobs, (tree, bounds), &packed, options)?;
        device.check()?;
        Ok(Self {
            device,
            uploaded: Some(uploaded),
            bytes,
        })
    }

    /// Memory taken on the device.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Rays that are sent together.
    pub fn together(&self) -> usize {
        BATCH
    }

    /// First crossings of object-space rays with the field of `blobs`, which is the one that was
    /// uploaded.
    ///
    /// # Errors
    /// Where the device fails.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_many(
        &self,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        scratch: &mut Scratch,
    ) -> Result<TraceWork, GpuError> {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        hits.fill(None);
        self.ask(Question::First, rays, |sent, record| {
            hits[sent.index] = match record {
                Some(record) => Some(hit_of(&rays[sent.index], &sent.clipped, record)),
                None => blobs.closest(&rays[sent.index], scratch),
            };
        })
    }

    /// Whether object-space rays cross the surface at all.
    ///
    /// # Errors
    /// Where the device fails.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn occluded_many(
        &self,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<TraceWork, GpuError> {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        hits.fill(false);
        self.ask(Question::Any, rays, |sent, record| {
            hits[sent.index] = record.is_some() || blobs.occluded(&rays[sent.index], scratch);
        })
    }

    /// Calls `answer` with the rays that hit, and without a record with those that the CPU has to trace.
    fn ask(
        &self,
        question: Question,
        rays: &[Ray],
        mut answer: impl FnMut(&Sent, Option<&HitRecord>),
    ) -> Result<TraceWork, GpuError> {
        let mut work = TraceWork {
            rays: rays.len() as u64,
            ..TraceWork::default()
        };
        let Some(uploaded) = &self.uploaded else {
            return Ok(work);
        };
        let mut waiting: Vec<Sent> = Vec::with_capacity(rays.len());
        for (index, ray) in rays.iter().enumerate() {
            let clipped = ray.is_traceable().then(|| uploaded.clip(ray)).flatten();
            waiting.extend(clipped.map(|clipped| Sent { index, clipped }));
        }
        let mut crowded = Vec::new();
        let mut in_doubt = Vec::new();
        for room in 0..CAPACITIES.len() {
            let lent = uploaded.send(
                self.device,
                question,
                room,
                rays,
                &waiting,
                |sent, record| match record[0] {
                    HIT => answer(sent, Some(record)),
                    IN_DOUBT => in_doubt.push(*sent),
                    NO_ROOM => crowded.push(*sent),
                    _ => {}
                },
            )?;
            work.device_secs += lent;
            if room == 0 {
                work.crowded = crowded.len() as u64;
            }
            waiting = std::mem::take(&mut crowded);
            if waiting.is_empty() {
                break;
            }
        }
        in_doubt.append(&mut waiting);
        work.on_cpu = in_doubt.len() as u64;
        for sent in &in_doubt {
            answer(sent, None);
        }
        Ok(work)
    }
}

impl Uploaded {
    fn new(
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

    fn clip(&self, ray: &Ray) -> Option<ClippedRay> {
        ClippedRay::new(self.field_origin, self.bounds, ray)
    }

    /// Sends rays batch by batch; returns the device's own time in seconds.
    fn send(
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

fn hit_of(ray: &Ray, clipped: &ClippedRay, record: &HitRecord) -> BlobHit {
    let number = |i: usize| f64::from(f32::from_bits(record[i]));
    BlobHit {
        t: clipped.parameter(ray, number(1) + number(2)),
        outward: DVec3::new(number(4), number(5), number(6)),
        strongest: record[3],
        entering: record[7] != 0,
    }
}
