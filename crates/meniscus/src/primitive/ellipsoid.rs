//! The ellipsoid: q(x) = dᵀMd = |Ad|² with A the upper-triangular Cholesky factor of the metric M
//! (Ray Tracing Gems II, §35.2).

use super::{AlongLine, Primitive, Shapes, dot};
use crate::math::number::Number;
use crate::math::simd::xyz;
use glam::{DMat3, DVec3};

/// The factor A of one ellipsoid, row by row: a00 a01 a02 a11 a12 a22.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(transparent)]
pub struct Ellipsoid(pub [f32; 6]);

/// A metric that is not symmetric positive definite (or not finite).
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the metric is not symmetric positive definite")]
pub struct MetricError;

impl Ellipsoid {
    /// A ball of support radius `radius`.
    pub fn ball(radius: f64) -> Self {
        let a = (1.0 / radius) as f32;
        Self([a, 0.0, 0.0, a, 0.0, a])
    }

    /// From the metric M of q(d) = dᵀMd.
    ///
    /// # Errors
    /// When M is not positive definite or not finite, or its factor does not fit into f32.
    pub fn from_metric(metric: DMat3) -> Result<Self, MetricError> {
        let factor = Self::factor_of(metric)?.map(|a| a as f32);
        let usable = factor.iter().all(|a| a.is_finite())
            && [0, 3, 5].iter().all(|&i| factor[i] > f32::MIN_POSITIVE);
        usable.then_some(Self(factor)).ok_or(MetricError)
    }

    /// The factor of the metric M in float64, in the order of [`Ellipsoid`]; reads M's upper triangle.
    ///
    /// # Errors
    /// When M is not positive definite or not finite.
    pub fn factor_of(metric: DMat3) -> Result<[f64; 6], MetricError> {
        // M = AᵀA with A upper triangular.
        let m = |row: usize, column: usize| metric.col(column)[row];
        let root = |square: f64| {
            (square > 0.0 && square.is_finite())
                .then(|| square.sqrt())
                .ok_or(MetricError)
        };
        let a00 = root(m(0, 0))?;
        let a01 = m(0, 1) / a00;
        let a02 = m(0, 2) / a00;
        let a11 = root(m(1, 1) - a01 * a01)?;
        let a12 = (m(1, 2) - a01 * a02) / a11;
        let a22 = root(m(2, 2) - a02 * a02 - a12 * a12)?;
        let factor = [a00, a01, a02, a11, a12, a22];
        let finite = factor.iter().all(|a| a.is_finite());
        finite.then_some(factor).ok_or(MetricError)
    }

    /// The factor, as of [`Ellipsoid::factor_of`], of the ellipsoid whose surface these three conjugate
    /// radii span: the image of the unit ball under the matrix of these columns. At right angles they
    /// are its axes.
    ///
    /// # Errors
    /// When they lie in a plane or are not finite.
    pub fn factor_of_radii(radii: DMat3) -> Result<[f64; 6], MetricError> {
        // L⁻¹ = QA with A upper triangular, so AᵀA = (LLᵀ)⁻¹.
        let inverse = radii.inverse();
        let length = |column: DVec3| {
            let length = column.length();
            (length > 0.0 && length.is_finite())
                .then_some(length)
                .ok_or(MetricError)
        };
        let a00 = length(inverse.x_axis)?;
        let first = inverse.x_axis / a00;
        let a01 = first.dot(inverse.y_axis);
        let rest = inverse.y_axis - first * a01;
        let a11 = length(rest)?;
        let second = rest / a11;
        let (a02, a12) = (first.dot(inverse.z_axis), second.dot(inverse.z_axis));
        let a22 = length(inverse.z_axis - first * a02 - second * a12)?;
        let factor = [a00, a01, a02, a11, a12, a22];
        let finite = factor.iter().all(|a| a.is_finite());
        finite.then_some(factor).ok_or(MetricError)
    }

    /// The factor as a matrix.
    pub fn matrix(&self) -> DMat3 {
        let [a00, a01, a02, a11, a12, a22] = self.0.map(f64::from);
        DMat3::from_cols(
            DVec3::new(a00, 0.0, 0.0),
            DVec3::new(a01, a11, 0.0),
            DVec3::new(a02, a12, a22),
        )
    }

    /// A·d in float64.
    pub fn transform_f64(&self, d: DVec3) -> DVec3 {
        self.matrix() * d
    }

    /// Aᵀ·y in float64.
    pub fn transform_transposed_f64(&self, y: DVec3) -> DVec3 {
        self.matrix().transpose() * y
    }

    /// det A, in 1/length³.
    pub fn determinant(&self) -> f64 {
        f64::from(self.0[0]) * f64::from(self.0[3]) * f64::from(self.0[5])
    }

    /// Half extents of the axis-aligned box around q ≤ 1: the lengths of the rows of A⁻¹.
    pub fn half_extents(&self) -> [f32; 3] {
        let [a00, a01, a02, a11, a12, a22] = self.0.map(f64::from);
        // A⁻¹, upper triangular as A is.
        let (b00, b11, b22) = (a00.recip(), a11.recip(), a22.recip());
        let (b01, b12) = (-a01 * b00 * b11, -a12 * b11 * b22);
        let b02 = -(a01 * b12 + a02 * b22) * b00;
        let squares = [
            b00 * b00 + b01 * b01 + b02 * b02,
            b11 * b11 + b12 * b12,
            b22 * b22,
        ];
        squares.map(|square| (square.sqrt() * (1.0 + 1e-6)) as f32)
    }
}

impl Primitive for Ellipsoid {
    const COLUMNS: usize = 6;
    const BETA_TURNS: bool = true;
    const DIAGONAL: &'static [usize] = &[0, 3, 5];

    #[inline(always)]
    fn transform<N: Number>(a: &[N], d: [N; 3]) -> [N; 3] {
        [
            a[0] * d[0] + a[1] * d[1] + a[2] * d[2],
            a[3] * d[1] + a[4] * d[2],
            a[5] * d[2],
        ]
    }

    #[inline(always)]
    fn transform_transposed<N: Number>(a: &[N], y: [N; 3]) -> [N; 3] {
        [
            a[0] * y[0],
            a[1] * y[0] + a[3] * y[1],
            a[2] * y[0] + a[4] * y[1] + a[5] * y[2],
        ]
    }

    #[inline(always)]
    fn along<N: Number>(a: &[N], w: [N; 3], d: [N; 3]) -> AlongLine<N> {
        let y = Self::transform(a, w);
        let v = Self::transform(a, d);
        let beta = dot(v, v);
        let c = dot(y, v) / beta;
        let e = xyz(
            #[inline(always)]
            |k| y[k] - c * v[k],
        );
        let g0 = dot(e, e) * -1.0 + 1.0;
        AlongLine { c, beta, g0 }
    }

    fn pack(shapes: &Shapes, i: usize, columns: &mut [f32]) {
        let Shapes::Ellipsoids(factors) = shapes else {
            panic!("ellipsoids expected");
        };
        columns.copy_from_slice(&factors[i].0);
    }
}
