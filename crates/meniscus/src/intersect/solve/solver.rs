//! The first change of side along a segment: sixteen samples at a time, with a proven bound on what
//! the field can do between them.
//!
//! With φ = F − T for a ray outside and T − F inside, the chord of φ over an interval of length ds
//! lies at most K ds²/8 below φ when K ≥ −φ″. An interval whose ends both lie below −K ds²/8 holds
//! no crossing.

use super::active::Active;
use super::departure::Departure;
use crate::accel::cells::layout::LANES;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Intervals waiting for a closer look; each level of refinement leaves at most one behind.
const PENDING: usize = 40;

/// Relative rounding of a sum of kernels in f32: below this φ has no sign.
pub(in crate::intersect) const NOISE: f32 = 4e-7;

/// Where the samples lie on an interval of which nothing is known: evenly, k/15 of the way.
const EVEN: [f32; LANES] = {
    let mut offsets = [0.0; LANES];
    let mut k = 0;
    while k < LANES {
        offsets[k] = k as f32 / 15.0;
        k += 1;
    }
    offsets
};

/// Where they lie about the likely crossing, which is at 0; the ends of the interval are at ∓1.
const AIMED: [f32; LANES] = [
    -1.0, -0.3, -0.1, -0.03, -0.01, -3e-3, -1e-3, -2e-4, 2e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3,
    1.0,
];

/// The wider of the two gaps beside each sample of a pattern.
const fn gaps(offsets: &[f32; LANES]) -> [f32; LANES] {
    let mut gaps = [0.0; LANES];
    let mut k = 0;
    while k + 1 < LANES {
        let gap = offsets[k + 1] - offsets[k];
        if gap > gaps[k] {
            gaps[k] = gap;
        }
        gaps[k + 1] = gap;
        k += 1;
    }
    gaps
}

const EVEN_GAPS: [f32; LANES] = gaps(&EVEN);
const AIMED_GAPS: [f32; LANES] = gaps(&AIMED);

/// How the ray came to the start of the segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::intersect) enum Entry {
    /// On the side that the solver assumes; if the field says otherwise here, the surface lies at
    /// this seam between two leaves.
    Confirmed,
    /// At the ray's own start, where rounding may show the other side.
    Unconfirmed,
    /// The same, and float64 has shown the other side: the ray has yet to return.
    Returning,
}

/// What to look at.
#[derive(Debug, Clone, Copy)]
pub(in crate::intersect) struct Segment {
    /// Where the search begins.
    pub(in crate::intersect) from: f32,
    /// Where it ends.
    pub(in crate::intersect) length: f32,
    pub(in crate::intersect) entry: Entry,
}

/// A stretch of the segment that may hold the crossing.
#[derive(Debug, Clone, Copy)]
struct Interval {
    from: f32,
    to: f32,
    /// Where a crossing is to be expected, when both ends are known to lie on different sides, with
    /// the bounds (−φ″, +φ″) that held for a longer interval.
    aim: Option<(f32, (f32, f32))>,
}

/// Intervals put off until those before them are done.
#[derive(Debug)]
pub(in crate::intersect) struct Pending([Interval; PENDING]);

impl Default for Pending {
    fn default() -> Self {
        Self(
            [Interval {
                from: 0.0,
                to: 0.0,
                aim: None,
            }; PENDING],
        )
    }
}

/// What a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::intersect) enum Verdict {
    /// The surface, at this distance from the segment's start.
    Crossing(f32),
    /// No crossing; the ray was seen on its side.
    StaysOnSide,
    /// The samples begin on the other side, and the ray does not clearly return from there: whether
    /// it crosses at its very start or was said to be where it is not takes float64 to tell.
    Unclear,
    /// No crossing: the whole segment lies on the other side (by rounding, or a wrong statement).
    NeverOnSide,
}

/// The equation and its accuracy.
#[derive(Debug, Clone, Copy)]
pub(in crate::intersect) struct Solver {
    pub(in crate::intersect) threshold: f32,
    /// Whether the ray travels inside.
    pub(in crate::intersect) inside: bool,
    /// Wanted accuracy of the crossing, as a length.
    pub(in crate::intersect) tolerance: f32,
    /// How far rounding may move a blob along the ray.
    pub(in crate::intersect) rounding: f32,
}

/// A way of solving one segment.
pub(in crate::intersect) trait FirstCrossing {
    /// Of a walk behind the frontier: whether all blobs that may count are collected before anything is
    /// solved.
    const COLLECTS_FIRST: bool;

    /// For the equation of `solver`.
    fn new(solver: Solver) -> Self;

    /// From now on any place will do as a crossing's.
    fn stop_at_any(&mut self);

    /// The first crossing on the segment; `active` holds the blobs that it meets.
    fn first_crossing<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        pending: &mut Pending,
        segment: Segment,
    ) -> Verdict;
}

impl FirstCrossing for Solver {
    const COLLECTS_FIRST: bool = false;

    #[inline(always)]
    fn new(solver: Solver) -> Self {
        solver
    }

    #[inline(always)]
    fn stop_at_any(&mut self) {
        self.tolerance = f32::INFINITY;
    }

    #[inline(always)]
    fn first_crossing<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        pending: &mut Pending,
        segment: Segment,
    ) -> Verdict {
        let pending = &mut pending.0;
        // While `returning` the search is for the side that the ray is said to start on: φ is
        // negated, and what is found is where the search proper begins.
        let mut returning = segment.entry != Entry::Confirmed;
        // Seen from outside: where φ has not reached 0 by then it never will.
        let end = if self.inside {
            segment.length
        } else {
            let last_approach = active.last_approach(simd) + self.rounding;
            segment.length.min(last_approach.max(segment.from))
        };
        let mut start = (segment.from, segment.length);
        let mut falls_at_start = false;
        match segment.entry {
            Entry::Returning => {}
            Entry::Unconfirmed => {
                if end <= segment.from {
                    return Verdict::StaysOnSide;
                }
                let departure = Departure::new::<S, K>(simd, self, active, segment.from);
                falls_at_start = departure.falls();
                if falls_at_start {
                    let bends = self.bend::<S, K>(simd, active, segment.from, end);
                    if let Some(safe) = departure.until(bends, self.rounding) {
                        let safe = safe.max(segment.from);
                        if safe >= end || self.stays_below::<S, K>(simd, active, safe, end) {
                            return Verdict::StaysOnSide;
                        }
                        start = (safe, end);
                        returning = false;
                    }
                }
            }
            Entry::Confirmed => {
                start.1 = end;
                if !self.inside && segment.from == 0.0 && active.count <= LANES {
                    if active.count == 1 {
                        return self.lone_blob::<K>(active, segment.length);
                    }
                    // Outside all supports the field is 0.
                    start = active.span(simd, end);
                }
            }
        }
        pending[0] = Interval {
            from: start.0,
            to: start.1,
            aim: None,
        };
        let mut depth = 1;
        let mut at_start = true;
        let scale = self.threshold.max(1.0);
        let zero = f32x16::splat(simd, 0.0);
        while depth > 0 {
            depth -= 1;
            let Interval { from, to, aim } = pending[depth];
            let length = to - from;
            let (at, gap) = match aim {
                None => {
                    let offsets = f32x16::from_slice(simd, &EVEN);
                    let start = f32x16::splat(simd, from);
                    let at = Number::mul_add(offsets, f32x16::splat(simd, length), start);
                    (at, f32x16::from_slice(simd, &EVEN_GAPS) * length)
                }
                Some((aim, _)) => {
                    let offsets = f32x16::from_slice(simd, &AIMED);
                    let before = f32x16::splat(simd, aim - from);
                    let behind = f32x16::splat(simd, to - aim);
                    let unit = offsets.simd_lt(zero).select(before, behind);
                    let at = Number::mul_add(offsets, unit, f32x16::splat(simd, aim));
                    (
                        at,
                        f32x16::from_slice(simd, &AIMED_GAPS) * before.max(behind),
                    )
                }
            };
            let mut phi = self.sample::<S, K>(simd, active, at);
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
                    && (phi.simd_ge(zero).to_bitmask() & 2 == 0 || !falls_at_start)
                {
                    return Verdict::Unclear;
                }
            }
            let (fall, rise) = match aim {
                Some((_, bends)) => bends,
                None => {
                    let (fall, rise) = self.bend::<S, K>(simd, active, from, to);
                    if returning {
                        (rise, fall)
                    } else {
                        (fall, rise)
                    }
                }
            };
            let band = gap * gap * (0.125 * fall);
            let candidates = (phi + band).simd_ge(zero).to_bitmask() as u32;
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
            let (ats, phis): ([f32; 16], [f32; 16]) = (at.to_array(), phi.to_array());
            let (left, right) = (left as usize & 15, right as usize & 15);
            let at_left = if left == 0 { from } else { ats[left] };
            let at_right = if right == 15 { to } else { ats[right] };
            let width = at_right - at_left;
            let sure = crossed >> right & 1 == 1;
            // No closer look can tell more than rounding allows.
            let fine = 0.125 * fall * width * width <= NOISE * scale
                || width <= 1e-7 * segment.length
                || depth + 2 > PENDING;
            let mut aim = None;
            if sure {
                let low = phis[left].min(0.0);
                let high = phis[right];
                let bend = fall.max(rise);
                if returning {
                    // Steep enough to cross only once.
                    if fine || high - low > 0.5 * bend * width * width {
                        returning = false;
                        pending[0] = Interval {
                            from: at_right,
                            to: segment.length,
                            aim: None,
                        };
                        depth = usize::from(at_right < segment.length);
                        continue;
                    }
                } else {
                    let fraction = if high > low { low / (low - high) } else { 0.0 };
                    let secant = |least: f32| at_left + width * fraction.clamp(least, 1.0 - least);
                    if fine || bend * width * width * width <= 8.0 * self.tolerance * (high - low) {
                        return Verdict::Crossing(secant(0.0));
                    }
                    // Not at the very ends, where samples would fall into each other's rounding.
                    aim = Some((secant(0.1), (fall, rise)));
                }
            }
            // Kept even where a crossing is sure: rounding may hide it from the closer look.
            if right < 15 && at_right > from {
                pending[depth] = Interval {
                    from: at_right,
                    to,
                    aim: None,
                };
                depth += 1;
            }
            if fine && !sure {
                continue;
            }
            pending[depth] = Interval {
                from: at_left,
                to: at_right,
                aim,
            };
            depth += 1;
        }
        if returning {
            Verdict::NeverOnSide
        } else {
            Verdict::StaysOnSide
        }
    }
}
