//! Refinement of one segment (Ray Tracing Gems II §35.4, "Interval refinement").
//!
//! With φ = F − T for a ray outside and T − F inside, the ray begins where φ < 0. A part of the segment
//! over which the upper bound of φ is negative holds no root. Where the bounds of φ′ leave zero out, φ
//! is monotone and its sign at the far end decides.

use crate::accel::cells::layout::LANES;
use crate::intersect::solve::{
    Active, Entry, FirstCrossing, NOISE, Pending, Segment, Solver, Verdict,
};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Parts narrower than this fraction of the segment are not split: f32 cannot tell their ends apart.
const NARROWEST: f32 = 2.5e-7;

/// Intervals waiting for a closer look: each level of refinement leaves at most one behind.
const WAITING: usize = 16;

/// Sixteen points from one end of an interval of length 1 to the other.
const EVEN: [f32; LANES] = {
    let mut points = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        points[k] = k as f32 / 15.0;
        k += 1;
    }
    points
};

/// Rounds of root finding at most; each shortens the bracket to a fifteenth.
const ROUNDS: usize = 6;

/// Blobs between two looks at whether a partial sum already settles all parts.
const BLOBS_PER_LOOK: usize = 8;

/// Where the sixteen parts of an interval of length 1 begin.
const STARTS: [f32; LANES] = {
    let mut starts = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        starts[k] = k as f32 / 16.0;
        k += 1;
    }
    starts
};

/// Interval refinement as a way of solving a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Refinement {
    solver: Solver,
}

/// φ at the far end of an interval, and bounds of φ′ on all of it.
struct Slopes {
    at_end: f32,
    least: f32,
    most: f32,
}

impl Slopes {
    #[inline(always)]
    fn is_monotone(&self) -> bool {
        self.least > 0.0 || self.most < 0.0
    }
}

impl FirstCrossing for Refinement {
    const COLLECTS_FIRST: bool = true;

    #[inline(always)]
    fn new(solver: Solver) -> Self {
        Self { solver }
    }

    #[inline(always)]
    fn stop_at_any(&mut self) {
        self.solver.stop_at_any();
    }

    #[inline(always)]
    fn first_crossing<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        _pending: &mut Pending,
        segment: Segment,
    ) -> Verdict {
        let outside = !self.solver.inside;
        let Segment {
            mut from,
            length,
            entry,
        } = segment;
        let at_start = self.slopes::<S, K>(simd, active, (from, from), outside);
        // While `returning` the search is for the side that the ray is said to start on.
        let mut returning = match entry {
            Entry::Confirmed if at_start.at_end >= 0.0 => return Verdict::Crossing(from),
            Entry::Unconfirmed if at_start.at_end > 0.0 => {
                let part = (length - from) / LANES as f32;
                let slopes = self.slopes::<S, K>(simd, active, (from, from + part), outside);
                if slopes.most >= 0.0 || slopes.at_end >= 0.0 {
                    return Verdict::Unclear;
                }
                // Falls all the way to the stated side.
                from += part;
                false
            }
            Entry::Confirmed | Entry::Unconfirmed => false,
            Entry::Returning => at_start.at_end > 0.0,
        };
        let only_positive = active.weight[..active.count].iter().all(|&w| w >= 0.0);
        let noise = NOISE * self.solver.threshold.max(1.0);
        let mut waiting = [(0.0_f32, 0.0_f32); WAITING];
        waiting[0] = (from, length);
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (from, to) = waiting[depth % WAITING];
            let above = outside != returning;
            let width = f32x16::splat(simd, to - from);
            let starts = f32x16::from_slice(simd, &STARTS);
            let begins = Number::mul_add(starts, width, f32x16::splat(simd, from));
            let ends = begins + width * (1.0 / 16.0);
            let upper = self.upper::<S, K>(simd, active, (begins, ends), above, only_positive);
            let mut candidates = upper.simd_ge(f32x16::splat(simd, 0.0)).to_bitmask() as u32;
            let begins: [f32; LANES] = begins.to_array();
            while candidates != 0 {
                let k = candidates.trailing_zeros() as usize % LANES;
                candidates &= candidates - 1;
                let begin = begins[k];
                let end = if k + 1 < LANES { begins[k + 1] } else { to };
                let slopes = self.slopes::<S, K>(simd, active, (begin, end), above);
                let fine = end - begin <= NARROWEST * length
                    || (slopes.most - slopes.least) * (end - begin) <= noise
                    || depth + 2 > WAITING;
                if slopes.is_monotone() || fine {
                    if slopes.at_end < 0.0 {
                        continue;
                    }
                    if !returning {
                        return Verdict::Crossing(self.root::<S, K>(simd, active, begin, end));
                    }
                    returning = false;
                    waiting[0] = (end, length);
                    depth = usize::from(end < length);
                    break;
                }
                if end < to {
                    waiting[depth % WAITING] = (end, to);
                    depth += 1;
                }
                waiting[depth % WAITING] = (begin, end);
                depth += 1;
                break;
            }
        }
        if returning {
            Verdict::NeverOnSide
        } else {
            Verdict::StaysOnSide
        }
    }
}

impl Refinement {
    /// An upper bound of φ over each of the parts [from, to], sixteen at a time, where φ = F − T
    /// (`above`) or T − F.
    #[inline(always)]
    fn upper<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        (from, to): (f32x16<S>, f32x16<S>),
        above: bool,
        only_positive: bool,
    ) -> f32x16<S> {
        let zero = f32x16::splat(simd, 0.0);
        let threshold = f32x16::splat(simd, self.solver.threshold);
        let mut sum = zero;
        for i in 0..active.count {
            let weight = active.weight[i];
            let (beta, g0) = (-active.beta[i], f32x16::splat(simd, active.g0[i]));
            let begin = from - active.c[i];
            let end = to - active.c[i];
            // The bound of F is an upper one if `above`, else a lower one.
            let g = if (weight > 0.0) == above {
                // g is largest at the point of the part nearest the blob's middle.
                let nearest = begin.max(end.min(zero));
                Number::mul_add(nearest * nearest, f32x16::splat(simd, beta), g0)
            } else {
                let farthest = end.max(-begin);
                Number::mul_add(farthest * farthest, f32x16::splat(simd, beta), g0)
            };
            sum = Number::mul_add(K::of_g(g.max(zero)), f32x16::splat(simd, weight), sum);
            if i % BLOBS_PER_LOOK == BLOBS_PER_LOOK - 1
                && only_positive
                && !above
                && sum.simd_le(threshold).to_bitmask() == 0
            {
                // Lower bounds of a sum that can only grow.
                break;
            }
        }
        if above {
            sum - self.solver.threshold
        } else {
            threshold - sum
        }
    }

    /// φ = F − T (`above`) or T − F over [from, to]: lanes for blobs.
    #[inline(always)]
    fn slopes<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        (from, to): (f32, f32),
        above: bool,
    ) -> Slopes {
        let zero = f32x16::splat(simd, 0.0);
        let (mut value, mut least, mut most) = (zero, zero, zero);
        for at in (0..active.count).step_by(LANES) {
            let [c, beta, g0, weight] = active.lanes(simd, at);
            let (begin, end) = (f32x16::splat(simd, from) - c, f32x16::splat(simd, to) - c);
            let g_end = (g0 - beta * end * end).max(zero);
            value = Number::mul_add(weight, K::of_g(g_end), value);
            let (mut low, mut high) = (zero, zero);
            // Each power of g by itself; a kernel that is one power gets the chapter's bounds.
            for power in 1..K::IN_G.len() {
                if K::IN_G[power] == 0.0 {
                    continue;
                }
                // gⁿ is steepest where βx² = g₀/(2n − 1), and flat at the middle and the border.
                let scale = K::IN_G[power] as f32;
                let steepest = (g0.max(zero) * (1.0 / (2 * power - 1) as f32)
                    / beta.max(f32x16::splat(simd, f32::MIN_POSITIVE)))
                .sqrt();
                let line = (beta, g0);
                let a = slope_of_power(simd, line, begin, power) * scale;
                let b = slope_of_power(simd, line, end, power) * scale;
                let rising = (-steepest).max(begin).min(end);
                let rising = slope_of_power(simd, line, rising, power) * scale;
                let falling = steepest.max(begin).min(end);
                let falling = slope_of_power(simd, line, falling, power) * scale;
                high += a.max(b).max(rising).max(falling);
                low += a.min(b).min(rising).min(falling);
            }
            let (positive, negative) = (weight.max(zero), weight.min(zero));
            most = Number::mul_add(positive, high, Number::mul_add(negative, low, most));
            least = Number::mul_add(positive, low, Number::mul_add(negative, high, least));
        }
        let value = value.reduce_sum() - self.solver.threshold;
        let (least, most) = (least.reduce_sum(), most.reduce_sum());
        if above {
            Slopes {
                at_end: value,
                least,
                most,
            }
        } else {
            Slopes {
                at_end: -value,
                least: -most,
                most: -least,
            }
        }
    }

    /// The root in [from, to], φ being negative at `from` and not at `to`.
    #[inline(always)]
    fn root<S: Simd, K: KernelShape>(&self, simd: S, active: &Active, from: f32, to: f32) -> f32 {
        let (fall, rise) = self.solver.bend::<S, K>(simd, active, from, to);
        let bend = fall.max(rise);
        let (mut left, mut right) = (from, to);
        let mut secant = to;
        for _ in 0..ROUNDS {
            let even = f32x16::from_slice(simd, &EVEN);
            let width = f32x16::splat(simd, right - left);
            let at = Number::mul_add(even, width, f32x16::splat(simd, left));
            let phi = self.solver.sample::<S, K>(simd, active, at);
            let crossed = phi.simd_ge(f32x16::splat(simd, 0.0)).to_bitmask() as u32;
            let (ats, phis): ([f32; LANES], [f32; LANES]) = (at.to_array(), phi.to_array());
            let k = ((crossed & !1).trailing_zeros() as usize).min(LANES - 1);
            let (low, high) = (phis[k - 1].min(0.0), phis[k].max(0.0));
            (left, right) = (ats[k - 1], ats[k]);
            let width = right - left;
            let fraction = if high > low { low / (low - high) } else { 0.0 };
            secant = left + width * fraction;
            if bend * width * width * width <= 8.0 * self.solver.tolerance * (high - low) {
                break;
            }
        }
        secant
    }
}

/// The slope of gⁿ at x from the middle of g = g₀ − βx².
#[inline(always)]
fn slope_of_power<S: Simd>(
    simd: S,
    (beta, g0): (f32x16<S>, f32x16<S>),
    x: f32x16<S>,
    power: usize,
) -> f32x16<S> {
    let pull = beta * x;
    let g = (g0 - pull * x).max(f32x16::splat(simd, 0.0));
    let mut slope = pull * (-2.0 * power as f32);
    for _ in 1..power {
        slope *= g;
    }
    slope
}
