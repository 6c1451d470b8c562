//! The paper's intersection (§3): the first of the points at which the field is on the other side ends a
//! bracket, in which the secant method finds the crossing.

use super::gather::Active;
use crate::accel::cells::layout::LANES;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

/// Steps of the secant method at most.
const MAX_STEPS: usize = 40;

/// Places tried by [`Search::step_off`].
const OFF_STEPS: usize = 8;

/// What to look for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search {
    pub(super) threshold: f32,
    /// Whether the ray comes from inside.
    pub(super) inside: bool,
    /// Accuracy of a crossing.
    pub(super) tolerance: f32,
}

/// The field at sixteen points.
#[inline(always)]
fn values_at<S: Simd, K: KernelShape>(simd: S, active: &Active, s: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    let n = active.count;
    let (c, beta) = (&active.c[..n], &active.beta[..n]);
    let (g0, weight) = (&active.g0[..n], &active.weight[..n]);
    let mut sum = zero;
    for i in 0..n {
        let d = s - f32x16::splat(simd, c[i]);
        let fall = d * d * -beta[i];
        let g = (fall + f32x16::splat(simd, g0[i])).max(zero);
        sum = Number::mul_add(K::of_g(g), f32x16::splat(simd, weight[i]), sum);
    }
    sum
}

/// The field at one point.
#[inline(always)]
fn value_at<S: Simd, K: KernelShape>(simd: S, active: &Active, s: f32) -> f32 {
    let zero = f32x16::splat(simd, 0.0);
    let s = f32x16::splat(simd, s);
    let mut sum = zero;
    for at in (0..active.count).step_by(LANES) {
        let [c, beta, g0, weight] = active.lanes(simd, at);
        let d = s - c;
        let g = (g0 - beta * d * d).max(zero);
        sum = Number::mul_add(weight, K::of_g(g), sum);
    }
    sum.reduce_sum()
}

impl Search {
    /// Evaluates the field at the points. With `first_only`, points behind one that is known to be
    /// beyond are left out: they count neither as beyond nor as not.
    #[inline(always)]
    pub(super) fn look<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &mut Active,
        first_only: bool,
    ) {
        let mut nearest = f32::MAX;
        for at in (0..active.point_count).step_by(LANES) {
            let s = f32x16::from_slice(simd, &active.points[at..at + LANES]);
            let values = if first_only && s.reduce_min() >= nearest {
                f32x16::splat(simd, f32::NAN)
            } else {
                values_at::<S, K>(simd, active, s)
            };
            values.store_slice(&mut active.values[at..at + LANES]);
            if first_only {
                let beyond = self.side_of(simd, values, true);
                let far = f32x16::splat(simd, f32::MAX);
                nearest = nearest.min(beyond.select(s, far).reduce_min());
            }
        }
    }

    /// Where the field is (or is not) on the side that the ray is looking for.
    #[inline(always)]
    fn side_of<S: Simd>(&self, simd: S, values: f32x16<S>, beyond: bool) -> mask32x16<S> {
        let threshold = f32x16::splat(simd, self.threshold);
        if beyond != self.inside {
            values.simd_gt(threshold)
        } else {
            values.simd_le(threshold)
        }
    }

    /// The nearest point from `from` on that is beyond, or is not.
    #[inline(always)]
    pub(super) fn nearest<S: Simd>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        beyond: bool,
    ) -> Option<f32> {
        let far = f32x16::splat(simd, f32::MAX);
        let from = f32x16::splat(simd, from);
        let mut nearest = far;
        for at in (0..active.point_count).step_by(LANES) {
            let s = f32x16::from_slice(simd, &active.points[at..at + LANES]);
            let values = f32x16::from_slice(simd, &active.values[at..at + LANES]);
            let counts = self.side_of(simd, values, beyond) & s.simd_ge(from);
            nearest = nearest.min(counts.select(s, far));
        }
        let nearest = nearest.reduce_min();
        (nearest < f32::MAX).then_some(nearest)
    }

    /// The last point before `before`.
    #[inline(always)]
    fn last_before<S: Simd>(&self, simd: S, active: &Active, before: f32) -> Option<f32> {
        let none = f32x16::splat(simd, -1.0);
        let before = f32x16::splat(simd, before);
        let mut last = none;
        for at in (0..active.point_count).step_by(LANES) {
            let s = f32x16::from_slice(simd, &active.points[at..at + LANES]);
            last = last.max(s.simd_lt(before).select(s, none));
        }
        let last = last.reduce_max();
        (last >= 0.0).then_some(last)
    }

    /// The first of some places behind `from`, each twice as far as the one before, where the field is
    /// not beyond: how a ray gets away from its own start.
    #[inline(always)]
    pub(super) fn step_off<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        step: f32,
        length: f32,
    ) -> Option<f32> {
        let mut off = step;
        for _ in 0..OFF_STEPS {
            let s = from + off;
            if s >= length {
                return None;
            }
            if (value_at::<S, K>(simd, active, s) > self.threshold) == self.inside {
                return Some(s);
            }
            off *= 2.0;
        }
        self.nearest(simd, active, from + off, false)
    }

    /// The crossing before `beyond`, the first point from `from` on that is on the other side. The point
    /// before it bounds it on the left; there is none where the ray enters the leaf on the other side
    /// already.
    #[inline(always)]
    pub(super) fn crossing<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        beyond: f32,
    ) -> f32 {
        let Some(before) = self.last_before(simd, active, beyond) else {
            return beyond;
        };
        let excess = |s: f32| value_at::<S, K>(simd, active, s) - self.threshold;
        let (mut a, mut b) = (before.max(from), beyond);
        let (mut fa, mut fb) = (excess(a), excess(b));
        if (fa > 0.0) == (fb > 0.0) {
            return b; // both are rounding about T
        }
        // The secant through the bracket's ends, one of which may stay put: then its value is halved
        // (the Illinois rule), or convergence would be linear.
        let mut kept = 0_i8;
        for _ in 0..MAX_STEPS {
            let s = (b - fb * (b - a) / (fb - fa)).clamp(a, b);
            let f = excess(s);
            let step;
            if (f > 0.0) == (fb > 0.0) {
                step = b - s;
                (b, fb) = (s, f);
                if kept == -1 {
                    fa *= 0.5;
                }
                kept = -1;
            } else {
                step = s - a;
                (a, fa) = (s, f);
                if kept == 1 {
                    fb *= 0.5;
                }
                kept = 1;
            }
            if step <= self.tolerance || b - a <= self.tolerance {
                return s;
            }
        }
        b
    }
}
