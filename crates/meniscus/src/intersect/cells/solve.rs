//! The first change of side along a segment: sixteen samples at a time, with a proven bound on what
//! the field can do between them.
//!
//! With φ = F − T for a ray outside and T − F inside, the chord of φ over an interval of length ds
//! lies at most K ds²/8 below φ when K ≥ −φ″. An interval whose ends both lie below −K ds²/8 holds
//! no crossing.

use super::gather::Active;
use crate::accel::cells::layout::LANES;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Intervals waiting for a closer look; each level of refinement leaves at most one behind.
const PENDING: usize = 40;

/// Relative rounding of a sum of kernels in f32: below this φ has no sign.
const NOISE: f32 = 4e-7;

const NODE_INDEX: [f32; LANES] = [
    0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0,
];

/// How the ray came to the start of the segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Entry {
    /// On the side that the solver assumes; if the field says otherwise here, the surface lies at
    /// this seam between two leaves.
    Confirmed,
    /// At the ray's own start, where rounding may show the other side.
    Unconfirmed,
    /// The same, and float64 has shown the other side: the ray has yet to return.
    Returning,
}

/// What to search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub(super) length: f32,
    pub(super) entry: Entry,
}

/// What a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Verdict {
    /// The surface, at this distance from the segment's start.
    Crossing(f32),
    /// No crossing; the ray was seen on its side.
    StaysOnSide,
    /// The samples begin on the other side and stay there: whether the ray crosses at its very
    /// start or was said to be where it is not takes float64 to tell.
    Unclear,
    /// No crossing: the whole segment lies on the other side (by rounding, or a wrong statement).
    NeverOnSide,
}

/// The equation and its accuracy.
#[derive(Debug, Clone, Copy)]
pub(super) struct Solver {
    pub(super) threshold: f32,
    /// Whether the ray travels inside.
    pub(super) inside: bool,
    /// Wanted accuracy of the crossing, as a length.
    pub(super) tolerance: f32,
}

impl Solver {
    /// φ at the sixteen points from + i·step.
    #[inline(always)]
    fn sample<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        step: f32,
    ) -> f32x16<S> {
        let index = f32x16::from_slice(simd, &NODE_INDEX);
        let at = Number::mul_add(index, f32x16::splat(simd, step), f32x16::splat(simd, from));
        let zero = f32x16::splat(simd, 0.0);
        let mut sum = zero;
        let count = active.count;
        let (c, beta) = (&active.c[..count], &active.beta[..count]);
        let (g0, weight) = (&active.g0[..count], &active.weight[..count]);
        for i in 0..count {
            let away = at - c[i];
            let fall = away * -beta[i];
            let g = Number::mul_add(fall, away, f32x16::splat(simd, g0[i])).max(zero);
            sum = Number::mul_add(K::of_g(g), f32x16::splat(simd, weight[i]), sum);
        }
        let above = sum - self.threshold;
        if self.inside { -above } else { above }
    }

    /// Bounds (−φ″, +φ″) over [from, to], from the blobs whose support meets it.
    #[inline(always)]
    fn bend<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        to: f32,
    ) -> (f32, f32) {
        let zero = f32x16::splat(simd, 0.0);
        let (from, to) = (f32x16::splat(simd, from), f32x16::splat(simd, to));
        let (mut down, mut up) = (zero, zero);
        for at in (0..active.count).step_by(LANES) {
            let [c, beta, g0, weight] = active.lanes(simd, at);
            let away = c.max(from).min(to) - c;
            let meets = (g0 - beta * away * away).simd_gt(zero);
            let g = g0.max(zero);
            let concave = beta * K::concave_bound(g);
            let convex = beta * K::convex_bound(g);
            let positive = meets.select(weight.max(zero), zero);
            let negative = meets.select((-weight).max(zero), zero);
            down = Number::mul_add(positive, concave, Number::mul_add(negative, convex, down));
            up = Number::mul_add(positive, convex, Number::mul_add(negative, concave, up));
        }
        let (down, up) = (down.reduce_sum(), up.reduce_sum());
        if self.inside { (up, down) } else { (down, up) }
    }

    /// The first crossing on the segment.
    #[inline(always)]
    pub(super) fn first_crossing<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        segment: Segment,
    ) -> Verdict {
        // While `returning` the search is for the side that the ray is said to start on: φ is
        // negated, and what is found is where the search proper begins.
        let mut returning = segment.entry != Entry::Confirmed;
        let mut start = (0.0, segment.length);
        if !self.inside && !returning && active.count <= LANES {
            if active.count == 1 {
                return self.lone_blob::<K>(active, segment.length);
            }
            // Outside all supports the field is 0.
            start = active.span(simd, segment.length);
        }
        let mut pending = [start; PENDING];
        let mut depth = 1;
        let mut at_start = true;
        let scale = self.threshold.max(1.0);
        let zero = f32x16::splat(simd, 0.0);
        while depth > 0 {
            depth -= 1;
            let (from, to) = pending[depth];
            let step = (to - from) * (1.0 / 15.0);
            let mut phi = self.sample::<S, K>(simd, active, from, step);
            if returning {
                phi = -phi;
            }
            if at_start {
                at_start = false;
                let beyond = phi.simd_ge(zero).to_bitmask() & 1 != 0;
                if beyond && !returning {
                    return Verdict::Crossing(from);
                }
                if beyond {
                    (phi, returning) = (-phi, false);
                } else if returning
                    && segment.entry == Entry::Unconfirmed
                    && phi.simd_ge(zero).to_bitmask() & 2 == 0
                {
                    return Verdict::Unclear;
                }
            }
            let (mut fall, mut rise) = self.bend::<S, K>(simd, active, from, to);
            if returning {
                (fall, rise) = (rise, fall);
            }
            let band = fall * step * step * 0.125;
            let candidates = phi.simd_ge(f32x16::splat(simd, -band)).to_bitmask() as u32;
            if candidates == 0 {
                continue;
            }
            // The first node is on the near side by construction, whatever rounding says.
            let crossed = phi.simd_ge(zero).to_bitmask() as u32 & !1;
            let k = candidates.trailing_zeros();
            let left = k.saturating_sub(1);
            let right = if crossed >> k & 1 == 1 {
                k
            } else {
                (k + 1).min(15)
            };
            let at = |node: u32| {
                if node == 15 {
                    to
                } else {
                    from + step * node as f32
                }
            };
            let (at_left, at_right) = (at(left), at(right));
            let width = at_right - at_left;
            let sure = crossed >> right & 1 == 1;
            // No closer look can tell more than rounding allows.
            let fine = band <= NOISE * scale
                || width <= 0.0
                || step <= 1e-7 * segment.length
                || depth + 2 > PENDING;
            if sure {
                let phis: [f32; 16] = phi.to_array();
                let low = phis[left as usize & 15].min(0.0);
                let high = phis[right as usize & 15];
                let bend = fall.max(rise);
                if returning {
                    // Steep enough to cross only once.
                    if fine || high - low > 0.5 * bend * width * width {
                        returning = false;
                        pending[0] = (at_right, segment.length);
                        depth = usize::from(at_right < segment.length);
                        continue;
                    }
                } else if fine
                    || bend * width * width * width <= 8.0 * self.tolerance * (high - low)
                {
                    let fraction = if high > low { low / (low - high) } else { 0.0 };
                    return Verdict::Crossing(at_left + width * fraction.clamp(0.0, 1.0));
                }
            }
            // Kept even where a crossing is sure: rounding may hide it from the closer look.
            if right < 15 && at_right > from {
                pending[depth] = (at_right, to);
                depth += 1;
            }
            if fine && !sure {
                continue;
            }
            pending[depth] = (at_left, at_right);
            depth += 1;
        }
        if returning {
            Verdict::NeverOnSide
        } else {
            Verdict::StaysOnSide
        }
    }

    /// The first crossing of a ray from outside with the only blob that it meets, in closed form.
    #[inline(always)]
    fn lone_blob<K: KernelShape>(&self, active: &Active, length: f32) -> Verdict {
        let level = self.threshold / active.weight[0];
        if level <= 0.0 || level >= 1.0 {
            return Verdict::StaysOnSide;
        }
        let square = (active.g0[0] - K::g_at(f64::from(level)) as f32) / active.beta[0];
        if square < 0.0 {
            return Verdict::StaysOnSide;
        }
        let half = square.sqrt();
        let (enter, leave) = (active.c[0] - half, active.c[0] + half);
        if enter > length || leave < 0.0 {
            return Verdict::StaysOnSide;
        }
        Verdict::Crossing(enter.max(0.0))
    }
}
