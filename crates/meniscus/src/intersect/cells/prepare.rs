//! Sixteen rays of the caller, clipped against the cells' box in f64 as `LocalRay` is, in arrays that
//! the compiler turns into lanes.

use crate::accel::cells::Cells;
use crate::accel::cells::layout::LANES;
use crate::accel::cells::traverse::TINY_COMPONENT;
use crate::at_level;
use crate::frame::Blobs;
use crate::intersect::solve::LocalRay;
use crate::math::aabb::Aabb;
use crate::math::ray::{Ray, Side};
use fearless_simd::Simd;
use glam::DVec3;

/// Rays in local coordinates with unit directions, moved to where they can first meet the cells.
#[derive(Debug, Default)]
pub(super) struct Prepared {
    /// Starts of the stretches that are traced, axis by axis.
    pub(super) origin: [[f64; LANES]; 3],
    /// Unit directions, axis by axis.
    pub(super) direction: [[f64; LANES]; 3],
    /// The same in f32, with their inverses for slab tests.
    pub(super) direction_f32: [[f32; LANES]; 3],
    pub(super) inverse: [[f32; LANES]; 3],
    /// Unit-length parameters of the starts on the callers' rays.
    t_start: [f64; LANES],
    /// 1/|direction| of the callers' rays.
    per_unit: [f64; LANES],
    /// Lengths of the stretches.
    pub(super) length: [f32; LANES],
    /// Seconds relative to the frame.
    time_secs: [f64; LANES],
    /// The same within the cells' span, from −1 to 1.
    pub(super) phase: [f32; LANES],
    /// Rays that can hit anything.
    pub(super) traceable: u64,
    /// Lanes whose ray meets the cells' box.
    pub(super) present: u32,
    /// Lanes whose ray starts at the caller's t_min.
    pub(super) starts_at_t_min: u32,
    /// Lanes whose ray starts inside the surface.
    pub(super) inside: u32,
    /// Lanes whose side the field, not the caller, has told.
    pub(super) side_is_proven: u32,
}

impl Prepared {
    /// Prepares up to sixteen rays; `bounds` is the cells' box.
    pub(super) fn fill(&mut self, blobs: &Blobs, cells: &Cells, bounds: &Aabb, rays: &[Ray]) {
        at_level!(blobs.level, simd => simd.vectorize(
            #[inline(always)]
            || self.fill_lanes(blobs, cells, bounds, rays)
        ));
    }

    #[inline(always)]
    fn fill_lanes(&mut self, blobs: &Blobs, cells: &Cells, bounds: &Aabb, rays: &[Ray]) {
        let mut origin = [[0.0_f64; LANES]; 3];
        let mut direction = [[1.0_f64; LANES]; 3];
        let (mut t_min, mut t_max) = ([0.0_f64; LANES], [-1.0_f64; LANES]);
        let mut traceable = 0;
        let (mut times, mut phases) = ([0.0; LANES], [0.0; LANES]);
        if cells.stored().moves() {
            for (phase, ray) in phases.iter_mut().zip(rays) {
                *phase = cells.phase(ray.time);
            }
        }
        for (lane, ray) in rays.iter().take(LANES).enumerate() {
            if !ray.is_traceable() {
                continue;
            }
            traceable += 1;
            for axis in 0..3 {
                origin[axis][lane] = ray.origin[axis] - blobs.field.origin[axis];
                direction[axis][lane] = ray.direction[axis];
            }
            (t_min[lane], t_max[lane]) = (ray.t_min, ray.t_max);
            times[lane] = ray.time;
        }
        let mut per_unit = [0.0_f64; LANES];
        for lane in 0..LANES {
            let [x, y, z] = [direction[0][lane], direction[1][lane], direction[2][lane]];
            let length = (x * x + y * y + z * z).sqrt();
            per_unit[lane] = 1.0 / length;
            t_min[lane] *= length;
            t_max[lane] *= length;
        }
        let (mut enter, mut leave) = (t_min, t_max);
        for axis in 0..3 {
            let (low, high) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
            for lane in 0..LANES {
                let d = direction[axis][lane] * per_unit[lane];
                direction[axis][lane] = d;
                // Along an axis with d = 0 these are infinite: both of one sign outside the box.
                let inverse = 1.0 / d;
                let to_low = (low - origin[axis][lane]) * inverse;
                let to_high = (high - origin[axis][lane]) * inverse;
                let (near, far) = if to_low < to_high {
                    (to_low, to_high)
                } else {
                    (to_high, to_low)
                };
                enter[lane] = if near > enter[lane] {
                    near
                } else {
                    enter[lane]
                };
                leave[lane] = if far < leave[lane] { far } else { leave[lane] };
            }
        }
        let mut length = [-1.0_f32; LANES];
        let (mut direction_f32, mut inverse) = ([[0.0_f32; LANES]; 3], [[1.0_f32; LANES]; 3]);
        for axis in 0..3 {
            for lane in 0..LANES {
                origin[axis][lane] += direction[axis][lane] * enter[lane];
                let d = direction[axis][lane] as f32;
                direction_f32[axis][lane] = d;
                let d = if d.abs() < TINY_COMPONENT {
                    TINY_COMPONENT.copysign(d)
                } else {
                    d
                };
                inverse[axis][lane] = 1.0 / d;
            }
        }
        let (mut present, mut starts_at_t_min) = (0, 0);
        for lane in 0..LANES {
            length[lane] = (leave[lane] - enter[lane]) as f32;
            let meets = enter[lane] <= leave[lane]
                && enter[lane].is_finite()
                && per_unit[lane].is_finite()
                && per_unit[lane] > 0.0;
            present |= u32::from(meets) << lane;
            starts_at_t_min |= u32::from(enter[lane] <= t_min[lane]) << lane;
        }
        (self.origin, self.direction) = (origin, direction);
        (self.direction_f32, self.inverse) = (direction_f32, inverse);
        (self.t_start, self.per_unit, self.length) = (enter, per_unit, length);
        (self.time_secs, self.phase) = (times, phases);
        (self.traceable, self.present) = (traceable, present);
        self.starts_at_t_min = starts_at_t_min & present;
        (self.inside, self.side_is_proven) = (0, 0);
        self.settle_sides(blobs, rays);
    }

    /// On which side the rays start.
    #[inline(always)]
    fn settle_sides(&mut self, blobs: &Blobs, rays: &[Ray]) {
        for (lane, ray) in rays.iter().take(LANES).enumerate() {
            let bit = 1 << lane;
            if self.present & bit == 0 {
                continue;
            }
            let at_t_min = self.starts_at_t_min & bit != 0;
            let inside = match ray.side {
                Side::Inside => true,
                Side::Outside => false,
                // The box holds all surface, so outside it the field lies below the threshold.
                Side::Unknown => {
                    let field = blobs.field.at(ray.time);
                    at_t_min && field.side(self.start(lane)) == Side::Inside
                }
            };
            let proven = ray.side == Side::Unknown || (!at_t_min && !inside);
            self.inside |= u32::from(inside) << lane;
            self.side_is_proven |= u32::from(proven) << lane;
        }
    }

    /// The first and the last of the times of `lanes`, at least one.
    pub(super) fn phases(&self, lanes: u32) -> [f32; 2] {
        let mut ends = [f32::INFINITY, f32::NEG_INFINITY];
        for (lane, &phase) in self.phase.iter().enumerate() {
            if lanes >> lane & 1 == 1 {
                ends = [ends[0].min(phase), ends[1].max(phase)];
            }
        }
        ends
    }

    fn start(&self, lane: usize) -> DVec3 {
        DVec3::new(
            self.origin[0][lane],
            self.origin[1][lane],
            self.origin[2][lane],
        )
    }

    /// The ray of a lane that is present by itself.
    #[inline(always)]
    pub(super) fn local(&self, lane: usize) -> LocalRay {
        let lane = lane % LANES;
        let has = |lanes: u32| lanes >> lane & 1 == 1;
        LocalRay {
            origin: self.start(lane),
            direction: DVec3::new(
                self.direction[0][lane],
                self.direction[1][lane],
                self.direction[2][lane],
            ),
            t_start: self.t_start[lane],
            length: self.length[lane],
            starts_at_t_min: has(self.starts_at_t_min),
            per_unit: self.per_unit[lane],
            inside: has(self.inside),
            time_secs: self.time_secs[lane],
            side_is_proven: has(self.side_is_proven),
        }
    }

    /// The caller's parameter of a point `along` the stretch of a lane.
    pub(super) fn parameter(&self, ray: &Ray, lane: usize, along: f64) -> f64 {
        ((self.t_start[lane] + along) * self.per_unit[lane]).clamp(ray.t_min, ray.t_max)
    }

    /// The lanes whose times are no farther than `apart` from that of `leader`.
    #[inline(always)]
    pub(super) fn near_in_time(&self, leader: usize, apart: f32) -> u32 {
        let mut mask = 0;
        for (lane, phase) in self.phase.iter().enumerate() {
            mask |= u32::from((phase - self.phase[leader]).abs() <= apart) << lane;
        }
        mask
    }

    /// Of `lanes` those that point about the same way as `leader`, from about the same place: no
    /// farther than `reach` and `turn` in every coordinate.
    #[inline(always)]
    pub(super) fn alike(&self, lanes: u32, leader: usize, reach: f64, turn: f64) -> u32 {
        let mut alike = [true; LANES];
        for axis in 0..3 {
            let (o, d) = (self.origin[axis][leader], self.direction[axis][leader]);
            let negative = self.inverse[axis][leader] < 0.0;
            for lane in 0..LANES {
                let near = (self.origin[axis][lane] - o).abs() <= reach;
                let parallel = (self.direction[axis][lane] - d).abs() <= turn;
                let same_sign = (self.inverse[axis][lane] < 0.0) == negative;
                alike[lane] &= near & parallel & same_sign;
            }
        }
        let mut mask = 0;
        for (lane, alike) in alike.iter().enumerate() {
            mask |= u32::from(*alike) << lane;
        }
        mask & lanes
    }
}
