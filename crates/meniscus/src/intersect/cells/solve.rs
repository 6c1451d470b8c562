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

/// φ at sixteen equidistant points.
struct Samples<S: Simd> {
    phi: f32x16<S>,
    step: f32,
}

impl Solver {
    #[inline(always)]
    fn sample<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        to: f32,
    ) -> Samples<S> {
        let step = (to - from) * (1.0 / 15.0);
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
        Samples {
            phi: if self.inside { -above } else { above },
            step,
        }
    }

    /// Bounds (−φ″, +φ″) over [from, to], from the blobs whose support meets it, and Σ|w|k there.
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
        let mut pending = [(0.0_f32, 0.0_f32); PENDING];
        pending[0] = (0.0, segment.length);
        let mut depth = 1;
        let mut confirmed = segment.entry == Entry::Confirmed;
        let mut first = true;
        let scale: f32 = self.threshold.max(1.0);
        while depth > 0 {
            depth -= 1;
            let (from, to) = pending[depth];
            let Samples { phi, step } = self.sample::<S, K>(simd, active, from, to);
            let zero = f32x16::splat(simd, 0.0);
            let crossed = phi.simd_ge(zero).to_bitmask() as u32;
            let mut search_from = 0;
            if first && crossed & 1 != 0 && confirmed {
                return Verdict::Crossing(0.0);
            }
            first = false;
            if !confirmed {
                let back = !crossed & 0xffff;
                if back == 0 {
                    continue;
                }
                search_from = back.trailing_zeros();
                confirmed = true;
            }
            let (fall, rise) = self.bend::<S, K>(simd, active, from, to);
            let band = fall * step * step * 0.125;
            let candidates = phi.simd_ge(f32x16::splat(simd, -band)).to_bitmask() as u32;
            // Nodes before the one that shows the stated side do not count.
            let counted = 0xffff << search_from;
            let (candidates, crossed) = (candidates & counted, crossed & counted);
            if candidates == 0 {
                continue;
            }
            let k = candidates.trailing_zeros();
            let left = k.saturating_sub(1).max(search_from);
            let at = |node: u32| {
                if node == 15 {
                    to
                } else {
                    from + step * node as f32
                }
            };
            let right = if crossed >> k & 1 == 1 {
                k
            } else {
                (k + 1).min(15)
            };
            let phis: [f32; 16] = phi.to_array();
            let sure = crossed >> right & 1 == 1;
            // No closer look can tell more than rounding allows.
            let fine = band <= NOISE * scale
                || at(right) <= at(left)
                || step <= 1e-7 * segment.length
                || depth + 2 > PENDING;
            if sure {
                let (low, high) = (phis[left as usize & 15], phis[right as usize & 15]);
                let width = at(right) - at(left);
                let error = fall.max(rise) * width * width * 0.125;
                if error * width <= self.tolerance * (high - low) || fine {
                    let fraction = if high > low { -low / (high - low) } else { 0.0 };
                    return Verdict::Crossing(at(left) + width * fraction.clamp(0.0, 1.0));
                }
                // The crossing lies in here: nothing behind it matters.
                depth = 0;
            } else if right < 15 {
                pending[depth] = (at(right), to);
                depth += 1;
            }
            if fine && !sure {
                continue;
            }
            pending[depth] = (at(left), at(right));
            depth += 1;
        }
        if confirmed {
            Verdict::StaysOnSide
        } else {
            Verdict::NeverOnSide
        }
    }
}
