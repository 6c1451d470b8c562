//! One field of balls on the device, asked about the rays of one eye.

use super::Clipping;
use super::room::{Own, Room, stored};
use super::round::{self, Answer, Call};
use super::shader::{PeelKind, tile};
use super::slots::{Eye, Seen, Slots, two_floats};
use super::times::StageSecs;
use super::view::View;
use crate::device::Device;
use crate::error::GpuError;
use glam::DVec3;
use meniscus::frame::Blobs;
use meniscus::intersect::particles::LONGEST_STRETCH;
use meniscus::intersect::{BlobHit, Tolerances};
use meniscus::math::aabb::Aabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;
use meniscus::scene::PeelVariant;

/// Rays of one round.
const MOST_SLOTS: u32 = 1 << 16;
/// The same where few are asked about.
const FEW_SLOTS: u32 = 1 << 14;

/// Balls that a stretch of a ray may meet.
const MET_CAPACITY: u32 = 96;
/// Balls that a pixel's list has room for.
const LIST_CAPACITY: u32 = 64;
/// The same in the paper (§4.2).
const PAPER_CAPACITY: u32 = 14;

/// Balls are too small for f32 below this part of a stretch, or this many times what rounding moves them.
const FINEST_PART: f32 = 1.0 / 64.0;
const MARGIN_PARTS: f32 = 8.0;

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
}

/// Balls in buffers, and what their rays are asked with.
pub(super) struct Balls {
    pub(super) shapes: wgpu::Buffer,
    pub(super) traits: wgpu::Buffer,
    pub(super) count: u32,
    bounds: Aabb,
    kind: PeelKind,
    /// Threshold, tolerance, rounding, distance of the start, length of a stretch.
    lengths: [f32; 5],
    fine_beta: f32,
    /// Whether a ball alone is solid where it reaches the threshold.
    pub(super) has_kernel_spheres: bool,
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
        let mut most = room.kind.groups;
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
            if lacking {
                let limit = fixed.unwrap_or(Room::pairs_limit(self.device));
                if room.most_pairs < limit {
                    let more = listed.saturating_add(listed / 4).min(limit);
                    room.grow_pairs(self.device, more)?;
                } else if most > 1 {
                    most = (slots.groups.len() as u32).div_ceil(2);
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

impl Balls {
    fn upload(
        device: &Device,
        blobs: &Blobs,
        radii: &[f32],
        clipping: Clipping,
    ) -> Result<Self, GpuError> {
        let field = &blobs.field;
        let shapes: Vec<[f32; 4]> = (field.centers.iter().zip(radii))
            .map(|(&[x, y, z], radius)| [x, y, z, radius.recip()])
            .collect();
        let threshold = f64::from(field.threshold);
        let traits: Vec<[f32; 2]> = field
            .weights
            .iter()
            .map(|&weight| {
                let q = field.kernel.q_at(threshold / f64::from(weight));
                [weight, q.map_or(2.0, |q| (1.0 - q) as f32)]
            })
            .collect();
        let limits = &device.limits;
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let bytes = size_of_val(&shapes[..]) as u64;
        if bytes > largest {
            let message = format!("it binds {largest} bytes at most");
            return Err(device.too_large(bytes, message));
        }
        let bounds = field.bounds();
        let tolerances = Tolerances::of(blobs, bounds);
        let mut sorted = radii.to_vec();
        let (_, &mut median, _) = sorted.select_nth_unstable_by(radii.len() / 2, f32::total_cmp);
        let longest = LONGEST_STRETCH * median;
        let finest = (FINEST_PART * longest).max(MARGIN_PARTS * tolerances.rounding);
        Ok(Self {
            shapes: stored(device, bytemuck::cast_slice(&shapes))?,
            traits: stored(device, bytemuck::cast_slice(&traits))?,
            count: shapes.len() as u32,
            bounds,
            kind: PeelKind {
                kernel: field.kernel,
                variant: blobs.settings.peel,
                clipping,
            },
            lengths: [
                field.threshold,
                tolerances.crossing,
                tolerances.rounding,
                tolerances.near_start,
                longest,
            ],
            fine_beta: (finest * finest).recip(),
            has_kernel_spheres: !field.has_negative_weights(),
        })
    }

    fn capacity(&self, options: PeelOptions) -> u32 {
        let usual = match (self.kind.variant, self.kind.clipping) {
            (PeelVariant::Tiles, _) => MET_CAPACITY,
            (PeelVariant::Sprites, Clipping::Own) => LIST_CAPACITY,
            (PeelVariant::Sprites, Clipping::Kanamori) => PAPER_CAPACITY,
        };
        options.capacity.unwrap_or(usual)
    }
}

/// Room for images' depths beyond the longest ray: 1 stands for nothing.
const REACH_MARGIN: f32 = 1.01;

impl Balls {
    /// What shaders know of a round (`Params` in `shaders/peel/field.wgsl`).
    fn params(&self, eye: &Eye, slots: &Slots, room: &Room) -> [u32; 40] {
        let side = f64::from(tile(self.kind.variant));
        // Film positions from the middle of the grid, where f32 is finest.
        let first = slots.grid_at.map(|at| f64::from(at) * side);
        let middle = [0, 1].map(|axis| first[axis] + 0.5 * side * f64::from(slots.grid_size[axis]));
        let map = eye.view.film_from_direction;
        let depth = map.row(2);
        let per_depth = depth.length().recip();
        let row = |axis: usize| (map.row(axis) - depth * middle[axis]) * per_depth;
        let (eye_high, eye_low) = two_floats(eye.view.eye - eye.field_origin);
        let reach = REACH_MARGIN * self.bounds.size().length();
        let (across, atlas) = match &room.own {
            Own::Tiles { .. } => (1, 1),
            Own::Sprites(layers) => (layers.across, layers.side),
        };
        let mut params = [0; 40];
        params[..5].copy_from_slice(&self.lengths.map(f32::to_bits));
        params[5..12].copy_from_slice(&[
            slots.records.len() as u32,
            slots.groups.len() as u32,
            room.kind.capacity,
            self.count,
            room.most_pairs,
            self.fine_beta.to_bits(),
            reach.to_bits(),
        ]);
        let bits = |v: DVec3| v.as_vec3().to_array().map(f32::to_bits);
        params[12..15].copy_from_slice(&bits(row(0)));
        params[16..19].copy_from_slice(&bits(row(1)));
        params[20..23].copy_from_slice(&bits(depth * per_depth));
        params[24..27].copy_from_slice(&eye_high);
        params[28..31].copy_from_slice(&eye_low);
        let at = [0, 1].map(|axis| ((first[axis] - middle[axis]) as f32).to_bits());
        params[32..34].copy_from_slice(&at);
        params[34..36].copy_from_slice(&slots.grid_size);
        params[36] = (slots.jitter as f32).to_bits();
        params[37] = across;
        params[38..40].copy_from_slice(&[atlas; 2]);
        params
    }
}
