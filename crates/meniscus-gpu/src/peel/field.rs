//! One field of balls on the device, asked about the rays of one eye.

use super::Clipping;
use super::balls::Balls;
use super::programs::Solve;
use super::room::Room;
use super::round::{self, Answer, Call};
use super::shader::tile;
use super::slots::{Eye, Seen, Slots};
use super::times::StageSecs;
use super::view::View;
use crate::device::Device;
use crate::error::GpuError;
use glam::DVec3;
use meniscus::frame::Blobs;
use meniscus::intersect::BlobHit;
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Rays of one round.
const MOST_SLOTS: u32 = 1 << 16;
/// The same where few are asked about.
const FEW_SLOTS: u32 = 1 << 14;

/// Drivers reset cards after some seconds; rounds that take a part of one are halved, down to so many
/// groups.
const LONGEST_ROUND: Duration = Duration::from_millis(400);
const FEWEST_GROUPS: u32 = 64;

/// The eye's own side is left to others where F is this close to the threshold, relative.
const EYE_NOISE: f64 = 1e-4;

/// How a field is put on a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PeelOptions {
    /// Pairs of balls and tiles that there is room for, where it shall be another number and not grow: for
    /// tests.
    pub pairs: Option<u32>,
    /// Balls that a ray may meet at a time, where it shall be another number: for tests.
    pub capacity: Option<u32>,
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PeelWork {
    /// Rays of the eye.
    pub rays: u64,
    /// Rays that have to be answered otherwise.
    pub left: u64,
    /// Rounds that rays were sent in.
    pub rounds: u64,
    /// Layers of sprites that were drawn.
    pub layers: u64,
    /// Balls in the lists of tiles, each as often as it is listed.
    pub listed: u64,
    /// Device time by stage.
    pub secs: StageSecs,
}

impl std::ops::AddAssign for PeelWork {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.left += other.left;
        self.rounds += other.rounds;
        self.layers += other.layers;
        self.listed += other.listed;
        self.secs += other.secs;
    }
}

/// A field of balls on a device.
pub struct PeelField<'d> {
    device: &'d Device,
    /// `None`: there is nothing to hit.
    balls: Option<Balls>,
    options: PeelOptions,
    /// Groups of rays that are sent together at most.
    together: AtomicU32,
}

impl<'d> PeelField<'d> {
    /// Puts the balls of `blobs` on a device.
    ///
    /// # Errors
    /// Where they are no still balls or do not fit, or the device fails.
    pub fn upload(
        device: &'d Device,
        blobs: &Blobs,
        options: PeelOptions,
    ) -> Result<Self, GpuError> {
        let field = &blobs.field;
        let unfit = |what| Err(GpuError::Unfit { what });
        let Shapes::Balls(radii) = &field.shapes else {
            return unfit("ellipsoids");
        };
        if field.motion.is_some() {
            return unfit("particles that move while the shutter is open");
        }
        let Some(clipping) = Clipping::of(blobs.settings.clipping) else {
            return unfit("with engine.clipping=nishita");
        };
        let balls = match field.is_empty() {
            true => None,
            false => Some(Balls::upload(device, blobs, radii, clipping)?),
        };
        device.check()?;
        Ok(Self {
            device,
            balls,
            options,
            together: AtomicU32::new(u32::MAX),
        })
    }

    /// Memory taken on the device by the balls.
    pub fn bytes(&self) -> u64 {
        let bytes = |balls: &Balls| balls.shapes.size() + balls.traits.size();
        self.balls.as_ref().map_or(0, bytes)
    }

    /// First crossings of object-space rays with the field of `blobs`, which is the one that was
    /// uploaded, for those that are rays of `view`'s eye; the indices of all others, and of those that
    /// cannot be decided, are added to `left`.
    ///
    /// # Errors
    /// Where the device fails.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_many(
        &self,
        view: &View,
        blobs: &Blobs,
        rays: &[Ray],
        hits: &mut [Option<BlobHit>],
        left: &mut Vec<usize>,
    ) -> Result<PeelWork, GpuError> {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        hits.fill(None);
        let mut work = PeelWork::default();
        let Some(balls) = &self.balls else {
            return Ok(work);
        };
        let eye = Eye {
            view: *view,
            field_origin: blobs.field.origin,
            bounds: balls.bounds,
            side: side_of_eye(blobs, balls.bounds, view.eye - blobs.field.origin),
        };
        let (before, mut waiting) = (left.len(), Vec::new());
        eye.sort(rays, &mut waiting, left);
        work.rays = rays.len() as u64;
        if !waiting.is_empty() {
            self.answer(balls, &eye, (rays, waiting), hits, left, &mut work)?;
        }
        work.left = (left.len() - before) as u64;
        Ok(work)
    }

    fn answer(
        &self,
        balls: &Balls,
        eye: &Eye,
        (rays, mut waiting): (&[Ray], Vec<Seen>),
        hits: &mut [Option<BlobHit>],
        left: &mut Vec<usize>,
        work: &mut PeelWork,
    ) -> Result<(), GpuError> {
        let side = tile(balls.kind.variant);
        let program = self.device.peel.programs.get(self.device, balls.kind);
        let wanted = if waiting.len() <= FEW_SLOTS as usize {
            FEW_SLOTS
        } else {
            MOST_SLOTS
        };
        let capacity = balls.capacity(self.options);
        let mut room = self
            .device
            .peel
            .borrow(self.device, (balls.kind.variant, wanted, capacity))?;
        let fixed = self.options.pairs;
        if let Some(pairs) = fixed {
            room.grow_pairs(self.device, pairs)?;
        }
        let mut most = room.kind.groups.min(self.together.load(Ordering::Relaxed));
        while !waiting.is_empty() {
            let mut later = Vec::new();
            let slots = Slots::lay_out(eye, &waiting, side, most as usize, &mut later);
            let call = Call {
                device: self.device,
                program: &program,
                balls,
                params: balls.params(eye, &slots, &room),
                slots: &slots,
            };
            let start = Instant::now();
            let mut lacking = false;
            let listed = round::run(&mut room, &call, work, |number, answer| {
                let seen = &waiting[number];
                match answer {
                    Answer::Miss => {}
                    Answer::Hit(hit) => {
                        let t = seen.clipped.parameter(&rays[seen.index], hit.along);
                        hits[seen.index] = Some(BlobHit {
                            t,
                            outward: hit.outward,
                            strongest: hit.strongest,
                            entering: hit.entering,
                        });
                    }
                    Answer::Open => left.push(seen.index),
                    Answer::NoList => {
                        lacking = true;
                        later.push(*seen);
                    }
                }
            })?;
            let sent = slots.groups.len() as u32;
            let is_one_dispatch = matches!(program.solve, Solve::Tiles(_));
            if is_one_dispatch && start.elapsed() > LONGEST_ROUND && sent == most {
                most = (most / 2).max(FEWEST_GROUPS.min(most));
                self.together.fetch_min(most, Ordering::Relaxed);
            }
            if lacking {
                let limit = fixed.unwrap_or(Room::pairs_limit(self.device));
                if room.most_pairs < limit {
                    let more = listed.saturating_add(listed / 4).min(limit);
                    room.grow_pairs(self.device, more)?;
                } else if most > 1 {
                    most = sent.div_ceil(2);
                } else {
                    left.extend(later.drain(..).map(|seen| seen.index));
                }
            }
            waiting = later;
        }
        if fixed.is_none() {
            self.device.peel.give_back(room);
        }
        Ok(())
    }
}

/// On which side the eye lies; unknown where that is not clear enough for f32.
fn side_of_eye(blobs: &Blobs, bounds: Aabb, local: DVec3) -> Side {
    let min = bounds.min.as_dvec3();
    let max = bounds.max.as_dvec3();
    if !(min.cmple(local).all() && local.cmple(max).all()) {
        return Side::Outside;
    }
    let threshold = f64::from(blobs.field.threshold);
    let above = blobs.field.at(0.0).value(local) - threshold;
    if above.abs() <= EYE_NOISE * threshold.max(1.0) {
        Side::Unknown
    } else if above > 0.0 {
        Side::Inside
    } else {
        Side::Outside
    }
}
