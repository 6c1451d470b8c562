//! The field along a segment: φ at sixteen points, bounds of it and of how it bends, and the one case in
//! closed form.

use super::active::Active;
use super::solver::{Solver, Verdict};
use crate::accel::cells::layout::LANES;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// `sum` plus the field of one blob at sixteen points.
#[inline(always)]
fn add_blob<S: Simd, K: KernelShape>(
    simd: S,
    at: f32x16<S>,
    [c, beta, g0, weight]: [f32; 4],
    sum: f32x16<S>,
) -> f32x16<S> {
    let away = at - c;
    let fall = away * -beta;
    let g = Number::mul_add(fall, away, f32x16::splat(simd, g0)).max(f32x16::splat(simd, 0.0));
    Number::mul_add(K::of_g(g), f32x16::splat(simd, weight), sum)
}

impl Solver {
    /// φ at sixteen points.
    #[inline(always)]
    pub(in crate::intersect) fn sample<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        at: f32x16<S>,
    ) -> f32x16<S> {
        let zero = f32x16::splat(simd, 0.0);
        // Two sums, so that one addition need not wait for the other; a blob of weight 0 follows the
        // last one.
        let (mut even, mut odd) = (zero, zero);
        let count = active.count.next_multiple_of(2);
        let (c, beta) = (
            active.c[..count].chunks_exact(2),
            active.beta[..count].chunks_exact(2),
        );
        let (g0, weight) = (
            active.g0[..count].chunks_exact(2),
            active.weight[..count].chunks_exact(2),
        );
        for (((c, beta), g0), weight) in c.zip(beta).zip(g0).zip(weight) {
            even = add_blob::<S, K>(simd, at, [c[0], beta[0], g0[0], weight[0]], even);
            odd = add_blob::<S, K>(simd, at, [c[1], beta[1], g0[1], weight[1]], odd);
        }
        let above = even + odd - self.threshold;
        if self.inside { -above } else { above }
    }

    /// Whether the blobs, each where it is strongest on [from, to], do not reach the threshold together.
    #[inline(always)]
    pub(super) fn stays_below<S: Simd, K: KernelShape>(
        &self,
        simd: S,
        active: &Active,
        from: f32,
        to: f32,
    ) -> bool {
        if self.inside {
            return false;
        }
        let zero = f32x16::splat(simd, 0.0);
        let (from, to) = (f32x16::splat(simd, from), f32x16::splat(simd, to));
        let mut upper = zero;
        for at in (0..active.count).step_by(LANES) {
            let [c, beta, g0, weight] = active.lanes(simd, at);
            let away = c.max(from).min(to) - c;
            let most = Number::neg_mul_add(beta * away, away, g0).max(zero);
            upper = Number::mul_add(weight.max(zero), K::of_g(most), upper);
        }
        upper.reduce_sum() < self.threshold
    }

    /// Bounds (−φ″, +φ″) over [from, to], from the blobs whose support meets it.
    #[inline(always)]
    pub(in crate::intersect) fn bend<S: Simd, K: KernelShape>(
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

    /// The first crossing of a ray from outside with the only blob that it meets, in closed form.
    #[inline(always)]
    pub(in crate::intersect) fn lone_blob<K: KernelShape>(
        &self,
        active: &Active,
        length: f32,
    ) -> Verdict {
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
