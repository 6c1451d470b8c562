//! Sixteen particles side by side: sums over their neighbours, and what these make of their shapes.

use super::{FEW, FILLED, LARGEST_RATIO, LEAST, SMOOTHING};
use crate::math::simd::xyz;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

pub(super) const LANES: usize = 16;
/// Numbers that describe a particle's shape: the way to its smoothed centre in parts of r, and the
/// factor of its metric times its support radius.
pub(super) const NUMBERS: usize = 9;

/// A row per number, a column per particle.
pub(super) type Lanes = [f32; LANES];

/// What one particle after the other says, in lanes.
struct Sums<S: Simd> {
    weight: f32x16<S>,
    first: [f32x16<S>; 3],
    /// xx xy xz yy yz zz.
    second: [f32x16<S>; 6],
}

/// The shapes of the particles `at` these places, of which those at `near` are neighbours; `per_reach`
/// is 1/r.
#[inline(always)]
pub(super) fn shapes<S: Simd>(
    simd: S,
    near: [&[f32]; 3],
    at: &[f32x16<S>; 3],
    per_reach: &Lanes,
) -> [Lanes; NUMBERS] {
    settle(simd, sums(simd, near, at, per_reach))
}

/// Σw, Σw·e and Σw·e·eᵀ, e = (neighbour − `at`)·`per_reach`, w = 1 − |e|³.
#[inline(always)]
fn sums<S: Simd>(simd: S, near: [&[f32]; 3], at: &[f32x16<S>; 3], per_reach: &Lanes) -> Sums<S> {
    let [ax, ay, az] = *at;
    let scale = f32x16::from_slice(simd, per_reach);
    let zero = f32x16::splat(simd, 0.0);
    let one = f32x16::splat(simd, 1.0);
    let mut weight = zero;
    let mut first = [zero; 3];
    let mut second = [zero; 6];
    let [x, y, z] = near;
    for ((&x, &y), &z) in x.iter().zip(y).zip(z) {
        let ex = (f32x16::splat(simd, x) - ax) * scale;
        let ey = (f32x16::splat(simd, y) - ay) * scale;
        let ez = (f32x16::splat(simd, z) - az) * scale;
        let square = ex.mul_add(ex, ey.mul_add(ey, ez * ez));
        let w = (one - square * square.sqrt()).max(zero);
        let (wx, wy, wz) = (w * ex, w * ey, w * ez);
        weight += w;
        first[0] += wx;
        first[1] += wy;
        first[2] += wz;
        second[0] = wx.mul_add(ex, second[0]);
        second[1] = wx.mul_add(ey, second[1]);
        second[2] = wx.mul_add(ez, second[2]);
        second[3] = wy.mul_add(ey, second[3]);
        second[4] = wy.mul_add(ez, second[4]);
        second[5] = wz.mul_add(ez, second[5]);
    }
    Sums {
        weight,
        first,
        second,
    }
}

/// The way to the smoothed centre and the factor of the metric.
#[inline(always)]
fn settle<S: Simd>(simd: S, sums: Sums<S>) -> [Lanes; NUMBERS] {
    let splat = |number: f32| f32x16::splat(simd, number);
    let (zero, one) = (splat(0.0), splat(1.0));
    let per_weight = one / sums.weight;
    let mean = xyz(
        #[inline(always)]
        |k| sums.first[k] * per_weight,
    );
    let per_filled = per_weight * splat((1.0 / FILLED) as f32);
    let lift = splat((1.0 / FILLED) as f32);
    let [xx, xy, xz, yy, yz, zz] = sums.second;
    let [mx, my, mz] = mean;
    let covariance = [
        xx * per_filled - mx * mx * lift,
        xy * per_filled - mx * my * lift,
        xz * per_filled - mx * mz * lift,
        yy * per_filled - my * my * lift,
        yz * per_filled - my * mz * lift,
        zz * per_filled - mz * mz * lift,
    ];
    let [few, many] = FEW.map(|count| count as f32);
    let t = ((sums.weight - splat(few)) * splat(1.0 / (many - few)))
        .max(zero)
        .min(one);
    let counts = t * t * (splat(3.0) - splat(2.0) * t);
    let Turning {
        values: sigma,
        axes,
        ..
    } = Turning::eigen(simd, covariance);
    let largest = sigma[0].max(sigma[1]).max(sigma[2]);
    let least = (largest * splat((1.0 / LARGEST_RATIO) as f32)).max(splat(LEAST as f32));
    let inverse = xyz(
        #[inline(always)]
        |k| {
            let sigma = one + (sigma[k].max(least) - one) * counts;
            one / (sigma * sigma)
        },
    );
    // M = Q diag(1/σ²) Qᵀ.
    let metric = |i: usize, j: usize| {
        let term = |k: usize| axes[k][i] * axes[k][j] * inverse[k];
        term(0) + term(1) + term(2)
    };
    let a00 = metric(0, 0).sqrt();
    let per_a00 = one / a00;
    let (a01, a02) = (metric(0, 1) * per_a00, metric(0, 2) * per_a00);
    let a11 = (metric(1, 1) - a01 * a01).sqrt();
    let a12 = (metric(1, 2) - a01 * a02) / a11;
    let a22 = (metric(2, 2) - a02 * a02 - a12 * a12).sqrt();
    let share = counts * splat(SMOOTHING as f32);
    [
        (mx * share).to_array(),
        (my * share).to_array(),
        (mz * share).to_array(),
        a00.to_array(),
        a01.to_array(),
        a02.to_array(),
        a11.to_array(),
        a12.to_array(),
        a22.to_array(),
    ]
}

/// Symmetric matrices on their way to their eigenvalues.
struct Turning<S: Simd> {
    values: [f32x16<S>; 3],
    /// Off the diagonal, by the axis that is not concerned.
    off: [f32x16<S>; 3],
    /// Unit vectors.
    axes: [[f32x16<S>; 3]; 3],
}

impl<S: Simd> Turning<S> {
    /// Eigenvalues of the symmetric matrices xx xy xz yy yz zz, and unit eigenvectors, by Jacobi's
    /// rotations.
    #[inline(always)]
    fn eigen(simd: S, [xx, xy, xz, yy, yz, zz]: [f32x16<S>; 6]) -> Self {
        /// What is left off the diagonal after the fourth is below f32's rounding.
        const SWEEPS: usize = 4;
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let mut turning = Self {
            values: [xx, yy, zz],
            off: [yz, xz, xy],
            axes: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
        };
        let nothing = (xx + yy + zz) * f32x16::splat(simd, 1e-8);
        for _ in 0..SWEEPS {
            turning.turn::<0, 1, 2>(simd, nothing);
            turning.turn::<0, 2, 1>(simd, nothing);
            turning.turn::<1, 2, 0>(simd, nothing);
        }
        turning
    }

    /// Turns axes `P` and `Q` so that nothing is left between them; `R` is the third.
    #[inline(always)]
    fn turn<const P: usize, const Q: usize, const R: usize>(
        &mut self,
        simd: S,
        nothing: f32x16<S>,
    ) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        // Squares of less would be denormal, which takes processors hundreds of cycles.
        let off = self.off[R].abs().simd_gt(nothing).select(self.off[R], zero);
        let twice = off + off;
        let apart = self.values[Q] - self.values[P];
        let root = apart.mul_add(apart, twice * twice).sqrt();
        let least = f32x16::splat(simd, f32::MIN_POSITIVE);
        let tangent = twice * one.copysign(apart) / (apart.abs() + root + least);
        // Beyond 1 where squares are too small for f32.
        let tangent = tangent.max(zero - one).min(one);
        let cosine = one / tangent.mul_add(tangent, one).sqrt();
        let sine = tangent * cosine;
        self.values[P] -= tangent * off;
        self.values[Q] += tangent * off;
        self.off[R] = zero;
        let (pr, qr) = (self.off[Q], self.off[P]);
        self.off[Q] = cosine * pr - sine * qr;
        self.off[P] = sine * pr + cosine * qr;
        let (p, q) = (self.axes[P], self.axes[Q]);
        self.axes[P] = xyz(
            #[inline(always)]
            |k| cosine * p[k] - sine * q[k],
        );
        self.axes[Q] = xyz(
            #[inline(always)]
            |k| sine * p[k] + cosine * q[k],
        );
    }
}
