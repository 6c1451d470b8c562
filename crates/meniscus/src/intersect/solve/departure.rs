//! A ray that leaves the surface it starts on: how far it is certain to stay on its side.
//!
//! φ is F − T for a ray outside and T − F inside. From value, slope and a bound of +φ″ alone,
//! φ(s) ≤ h + φ′s + K s²/2: where this parabola lies below 0 there is no crossing. It settles most
//! rays that start on a surface without a sample.

use super::active::Active;
use super::solver::{NOISE, Solver};
use crate::accel::cells::layout::LANES;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Relative rounding of a slope, with a margin.
const SLOPE_NOISE: f32 = 1e-5;

/// Kept back of a stretch that is proven, for the rounding of the proof itself.
const KEPT_BACK: f32 = 1e-3;

/// φ at a point of the segment, rounded up but for the rounding of positions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Departure {
    at: f32,
    value: f32,
    slope: f32,
}

impl Departure {
    /// That of a ray at the point `at` of the segment.
    #[inline(always)]
    pub(super) fn new<S: Simd, K: KernelShape>(
        simd: S,
        solver: &Solver,
        active: &Active,
        at: f32,
    ) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        let (mut value, mut slope, mut size) = (zero, zero, zero);
        for first in (0..active.count).step_by(LANES) {
            let [c, beta, g0, weight] = active.lanes(simd, first);
            let away = f32x16::splat(simd, at) - c;
            let pull = away * beta;
            let g = (g0 - pull * away).max(zero);
            let term = weight * K::slope(g) * pull;
            value = Number::mul_add(weight, K::of_g(g), value);
            slope -= term;
            size += term.abs();
        }
        let value = value.reduce_sum() - solver.threshold;
        let slope = 2.0 * slope.reduce_sum();
        let (value, slope) = if solver.inside {
            (-value, -slope)
        } else {
            (value, slope)
        };
        Self {
            at,
            value: value + NOISE * solver.threshold.max(1.0),
            slope: slope + 2.0 * SLOPE_NOISE * size.reduce_sum(),
        }
    }

    /// Whether φ falls, by more than its slope's rounding.
    #[inline(always)]
    pub(super) fn falls(&self) -> bool {
        self.slope < 0.0
    }

    /// Where φ, said to be below 0 at the point, may reach 0 at the earliest, given bounds (−φ″, +φ″) up
    /// to there and positions known to `rounding`; what it is above 0 at the point by rounding does not
    /// count. `None` if it need not fall.
    #[inline(always)]
    pub(super) fn until(&self, (fall, rise): (f32, f32), rounding: f32) -> Option<f32> {
        let bend = fall.max(rise) * rounding;
        let slope = self.slope + bend;
        let value = self.value + (slope.abs() + bend) * rounding;
        let square = slope * slope - 2.0 * rise * value;
        // Less falls below 0 only barely.
        if slope >= 0.0 || square < 0.25 * slope * slope {
            return None;
        }
        if rise <= 0.0 {
            return Some(f32::INFINITY);
        }
        Some(self.at + (1.0 - KEPT_BACK) * (square.sqrt() - slope) / rise)
    }
}
