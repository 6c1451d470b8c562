//! One field on the device: uploaded, and asked about rays.

use crate::batch::HitRecord;
use crate::build::{BuiltTree, Fitted, can_build, read_words};
use crate::chunks::Chunks;
use crate::device::Device;
use crate::error::GpuError;
use crate::pack::pack;
use crate::program::Question;
use crate::uploaded::{Around, BATCH, CAPACITIES, Placed, RAY_BUFFERS, Sent, Uploaded};
use glam::DVec3;
use meniscus::accel::Accel;
use meniscus::accel::particles::ParticleTree;
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, ClippedRay, Scratch};
use meniscus::math::ray::Ray;

/// `HitRecord::status`.
pub(crate) const HIT: u32 = 1;
pub(crate) const IN_DOUBT: u32 = 2;
pub(crate) const NO_ROOM: u32 = 3;

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
    options: TracerOptions,
    /// `None`: there is nothing to hit.
    uploaded: Option<Uploaded>,
    /// What the tree is built from, where the device builds it.
    built: Option<BuiltTree>,
    /// Time of the device for build and refit of the tree.
    build_secs: f64,
}

/// What [`FieldTracer::update`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TreeUpdate {
    /// The device's tree holds the blobs where they are now.
    Refitted,
    /// The device has built a new tree in the same buffers.
    Rebuilt,
    /// Everything was sent anew.
    Sent,
}

impl<'d> FieldTracer<'d> {
    /// Puts the field of `blobs` and its tree on a device. The device builds the tree where `blobs` says so
    /// ([`Accel::Elsewhere`]) and it can; the processor does where `blobs` has another structure.
    ///
    /// # Errors
    /// Where it does not fit, or the device fails.
    pub fn upload(
        device: &'d Device,
        blobs: &Blobs,
        options: TracerOptions,
    ) -> Result<Self, GpuError> {
        let built_here = || {
            let tree = ParticleTree::build(&blobs.field, blobs.settings.builder);
            Self::send(device, blobs, &tree, options)
        };
        let tracer = match &blobs.accel {
            Accel::Elsewhere if can_build(device, &blobs.field) => {
                match Self::build(device, blobs, options) {
                    // The tree alone takes less than what it is built from.
                    Err(GpuError::TooLarge { .. }) => built_here()?,
                    built => built?,
                }
            }
            Accel::Particles(tree) | Accel::Interval(tree) => {
                Self::send(device, blobs, tree, options)?
            }
            Accel::Elsewhere | Accel::Cells(_) | Accel::Metaballs(_) | Accel::Sweep(_) => {
                built_here()?
            }
        };
        device.check()?;
        Ok(tracer)
    }

    fn new(device: &'d Device, options: TracerOptions) -> Self {
        Self {
            device,
            options,
            uploaded: None,
            built: None,
            build_secs: 0.0,
        }
    }

    /// Sends a tree.
    fn send(
        device: &'d Device,
        blobs: &Blobs,
        tree: &ParticleTree,
        options: TracerOptions,
    ) -> Result<Self, GpuError> {
        let mut tracer = Self::new(device, options);
        let Some(bounds) = tree.bounds.filter(|_| !tree.nodes.is_empty()) else {
            return Ok(tracer);
        };
        let Some(packed) = pack(&blobs.field, tree) else {
            let message = "its words cannot be numbered in 32 bits".to_owned();
            return Err(device.too_large(0, message));
        };
        let chunks = Chunks::new(device, packed.words.len(), RAY_BUFFERS, options)?;
        chunks.write(device, &packed.words)?;
        let placed = Placed {
            chunks,
            leaves_at: packed.leaves_at,
            stack: packed.stack,
        };
        let around = Around {
            bounds,
            typical_support: tree.typical_support,
        };
        tracer.uploaded = Some(Uploaded::new(device, blobs, placed, around, options));
        Ok(tracer)
    }

    /// Lets the device build the tree.
    fn build(device: &'d Device, blobs: &Blobs, options: TracerOptions) -> Result<Self, GpuError> {
        let mut tracer = Self::new(device, options);
        if blobs.field.is_empty() {
            return Ok(tracer);
        }
        let (mut tree, placed) = BuiltTree::new(device, &blobs.field, options)?;
        let fitted = tree.build(device, &blobs.field, &placed)?;
        let uploaded = Uploaded::new(device, blobs, placed, around(&fitted), options);
        tracer.uploaded = Some(uploaded);
        tracer.built = Some(tree);
        tracer.build_secs = fitted.device_secs;
        Ok(tracer)
    }

    /// Takes the next field of a moving set. A tree that the device built is refitted where the same blobs
    /// have moved a little, else built anew in the same buffers.
    ///
    /// # Errors
    /// Where it does not fit, or the device fails.
    pub fn update(&mut self, blobs: &Blobs) -> Result<TreeUpdate, GpuError> {
        if let (Some(tree), Some(uploaded), Accel::Elsewhere) =
            (&mut self.built, &mut self.uploaded, &blobs.accel)
            && tree.suits(&blobs.field)
        {
            let (fitted, is_new) = tree.refit(self.device, &blobs.field, uploaded.placed())?;
            uploaded.set(blobs, around(&fitted));
            self.build_secs = fitted.device_secs;
            return Ok(match is_new {
                false => TreeUpdate::Refitted,
                true => TreeUpdate::Rebuilt,
            });
        }
        // Room for the next before it is made.
        self.uploaded = None;
        self.built = None;
        *self = Self::upload(self.device, blobs, self.options)?;
        Ok(TreeUpdate::Sent)
    }

    /// Time of the device for the last build or refit of the tree, in seconds by its own clock; 0 where
    /// the processor built it or the device keeps no time.
    pub fn build_secs(&self) -> f64 {
        self.build_secs
    }

    /// The tree as it stands in the device's buffers, in words, and the word of the first leaf: for tests.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn words(&self) -> Result<(Vec<[u32; 4]>, usize), GpuError> {
        match &self.uploaded {
            None => Ok((Vec::new(), 0)),
            Some(uploaded) => {
                let placed = uploaded.placed();
                let words = read_words(self.device, &placed.chunks)?;
                Ok((words, placed.leaves_at as usize))
            }
        }
    }

    /// Memory taken on the device.
    pub fn bytes(&self) -> u64 {
        let tree = self.uploaded.as_ref();
        let tree = tree.map_or(0, |uploaded| uploaded.placed().chunks.bytes());
        tree + self.built.as_ref().map_or(0, BuiltTree::bytes)
    }

    /// The device.
    pub(crate) fn device(&self) -> &'d Device {
        self.device
    }

    /// The field's buffers, where there is anything to hit.
    pub(crate) fn uploaded(&self) -> Option<&Uploaded> {
        self.uploaded.as_ref()
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
                |sent, records| match records[0][0] {
                    HIT => answer(sent, Some(&records[0])),
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

fn around(fitted: &Fitted) -> Around {
    Around {
        bounds: fitted.bounds,
        typical_support: fitted.typical_support,
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
