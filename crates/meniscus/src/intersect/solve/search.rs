//! The search of one ray, stretch after stretch: what is known about its side, and which crossings
//! count.

use super::T_TOLERANCE_SPACINGS;
use super::active::Active;
use super::local::LocalRay;
use super::solver::{Entry, FirstCrossing, Pending, Segment, Solver, Verdict};
use super::start::{OwnStart, is_inside, start_margin};
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use fearless_simd::Simd;

/// What is asked of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::intersect) enum Question {
    /// Where the first crossing is.
    First,
    /// Whether there is one.
    Any,
}

/// The state of one ray's search, by one way of solving a segment.
pub(in crate::intersect) struct Search<'a, V = Solver> {
    blobs: &'a Blobs,
    ray: &'a LocalRay,
    question: Question,
    solver: V,
    start: OwnStart,
    start_margin: f64,
    /// Whether the ray is known to have been on the side that it is said to start on.
    pub(in crate::intersect) on_stated_side: bool,
}

impl<'a, V: FirstCrossing> Search<'a, V> {
    /// Before the first stretch; `bounds` is the box around the structure.
    pub(in crate::intersect) fn new(
        blobs: &'a Blobs,
        bounds: Option<Aabb>,
        ray: &'a LocalRay,
        question: Question,
    ) -> Self {
        Self {
            blobs,
            ray,
            question,
            solver: V::new(Solver {
                threshold: blobs.field.threshold,
                inside: ray.inside,
                tolerance: T_TOLERANCE_SPACINGS * blobs.field.spacing,
                rounding: start_margin(bounds),
            }),
            start: OwnStart::new(blobs, bounds, ray),
            start_margin: f64::from(start_margin(bounds)),
            on_stated_side: ray.side_is_proven && !ray.starts_at_t_min,
        }
    }

    /// Whether `near` lies behind the ray's start for sure.
    #[inline(always)]
    pub(in crate::intersect) fn is_past_start(&self, near: f64) -> bool {
        near > self.start_margin
    }

    /// Crossings up to this distance along the ray count only if float64 sees them; negative where
    /// all count.
    #[inline(always)]
    pub(in crate::intersect) fn own_reach(&self) -> f32 {
        self.start.reach as f32
    }

    /// Whether a stretch from `near` on cannot hold the ray's own start.
    #[inline(always)]
    fn is_away_from_start(&self, near: f64) -> bool {
        self.is_past_start(near) || !self.ray.starts_at_t_min
    }

    /// Notes that the field on a stretch stays below `most`; whether that settles the stretch.
    #[inline(always)]
    pub(in crate::intersect) fn stays_below(&mut self, most: f32) -> bool {
        let settled = !self.ray.inside && most < self.blobs.field.threshold;
        self.on_stated_side |= settled;
        settled
    }

    /// The first crossing on the stretch that begins `near` along the ray and is `length` long, as a
    /// distance along the ray; `active` holds the blobs that the stretch meets.
    #[inline(always)]
    pub(in crate::intersect) fn first_on<S: Simd, K: KernelShape>(
        &mut self,
        simd: S,
        active: &Active,
        pending: &mut Pending,
        near: f64,
        length: f32,
    ) -> Option<f64> {
        let entry =
            if self.ray.side_is_proven || (self.on_stated_side && self.is_away_from_start(near)) {
                Entry::Confirmed
            } else if self.is_away_from_start(near) {
                Entry::Returning
            } else {
                Entry::Unconfirmed
            };
        if self.question == Question::Any && near > self.start.reach {
            // That there is a crossing is enough.
            self.solver.stop_at_any();
        }
        let mut segment = Segment {
            from: 0.0,
            length,
            entry,
        };
        let mut stride = self.start.stride;
        loop {
            let crossing = match self
                .solver
                .first_crossing::<S, K>(simd, active, pending, segment)
            {
                Verdict::Crossing(s) => s,
                Verdict::Unclear => segment.from,
                Verdict::StaysOnSide => {
                    self.on_stated_side = true;
                    return None;
                }
                Verdict::NeverOnSide => return None,
            };
            let t = near + f64::from(crossing);
            if self.start.is_sure(self.blobs, self.ray, t) {
                return Some(t);
            }
            segment.from = crossing + stride;
            stride *= 2.0;
            let from = near + f64::from(segment.from);
            self.on_stated_side = is_inside(self.blobs, self.ray, from) == self.ray.inside;
            if !self.on_stated_side
                && let Some(t) = self.start.crossing_before(self.blobs, self.ray, t, from)
            {
                return Some(t);
            }
            if segment.from >= length {
                return None;
            }
            segment.entry = if self.on_stated_side {
                Entry::Confirmed
            } else {
                Entry::Returning
            };
        }
    }
}
