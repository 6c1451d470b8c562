//! One field on the device: uploaded, and asked about rays.

use crate::batch::HitRecord;
use crate::device::Device;
use crate::error::GpuError;
use crate::pack::pack;
use crate::program::Question;
use crate::uploaded::{BATCH, CAPACITIES, Sent, Uploaded};
use glam::DVec3;
use meniscus::accel::Accel;
use meniscus::accel::particles::ParticleTree;
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, ClippedRay, Scratch};
use meniscus::math::ray::Ray;

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

fn hit_of(ray: &Ray, clipped: &ClippedRay, record: &HitRecord) -> BlobHit {
    let number = |i: usize| f64::from(f32::from_bits(record[i]));
    BlobHit {
        t: clipped.parameter(ray, number(1) + number(2)),
        outward: DVec3::new(number(4), number(5), number(6)),
        strongest: record[3],
        entering: record[7] != 0,
    }
}
