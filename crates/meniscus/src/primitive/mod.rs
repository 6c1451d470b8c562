//! Blob primitives: the distance form q(x) that a kernel is applied to.
//!
//! q(x) = |A(x − p)|² with A = 1/R for a ball and an upper-triangular factor for an ellipsoid.
//! The gather and solve stages are generic over [`Primitive`], so no layout is ball-only.

mod ball;
mod ellipsoid;

pub use ball::Ball;
pub use ellipsoid::{Ellipsoid, MetricError};

use crate::math::number::Number;

/// One blob's shape in packed f32 form. `d` is always the vector from the centre to the point.
pub trait Primitive: Copy + Send + Sync + 'static {
    /// f32 columns that describe the shape: 1 for a ball, 6 for an ellipsoid.
    const COLUMNS: usize;

    /// Whether β along a line depends on the line's direction.
    const BETA_TURNS: bool;

    /// The columns on A's diagonal.
    const DIAGONAL: &'static [usize];

    /// A·d.
    fn transform<N: Number>(columns: &[N], d: [N; 3]) -> [N; 3];

    /// Aᵀ·y, which takes a gradient in the unit ball's space back.
    fn transform_transposed<N: Number>(columns: &[N], y: [N; 3]) -> [N; 3];

    /// The blob along a line of unit direction `d`, with `w` the vector from the line's origin to
    /// the centre: g(s) = g₀ − β(s − c)².
    fn along<N: Number>(columns: &[N], w: [N; 3], d: [N; 3]) -> AlongLine<N>;

    /// Writes blob `i`'s columns of `shapes`.
    ///
    /// # Panics
    /// If `shapes` is not of this kind or `i` is out of range.
    fn pack(shapes: &Shapes, i: usize, columns: &mut [f32]);
}

/// One blob along a line: 1 − q(s) = g₀ − β(s − c)².
#[derive(Debug, Clone, Copy)]
pub struct AlongLine<N> {
    /// Parameter of the point nearest the centre (in the metric).
    pub c: N,
    /// Falloff, 1/length².
    pub beta: N,
    /// 1 − q at `c`; not positive: the line misses the support.
    pub g0: N,
}

/// x·x + y·y + z·z.
#[inline(always)]
pub fn dot<N: Number>(a: [N; 3], b: [N; 3]) -> N {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// The shapes of all blobs of a field: one kind per field (a ball is an ellipsoid with A = I/R).
#[derive(Debug, Clone, PartialEq)]
pub enum Shapes {
    /// Support radii R.
    Balls(Vec<f32>),
    /// Upper-triangular factors A, one per blob, with the support's axis-aligned half extents.
    Ellipsoids(Vec<Ellipsoid>),
}

impl Shapes {
    /// Number of blobs.
    pub fn len(&self) -> usize {
        match self {
            Self::Balls(radii) => radii.len(),
            Self::Ellipsoids(factors) => factors.len(),
        }
    }

    /// Whether there is no blob.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Half extents of blob `i`'s support box along x, y and z.
    pub fn half_extents(&self, i: usize) -> [f32; 3] {
        match self {
            Self::Balls(radii) => [radii[i]; 3],
            Self::Ellipsoids(factors) => factors[i].half_extents(),
        }
    }

    /// q at `d = x − p` for blob `i`, in float64 on the packed f32 numbers.
    pub fn q(&self, i: usize, d: glam::DVec3) -> f64 {
        self.transform(i, d).length_squared()
    }

    /// A·d for blob `i`, in float64 on the packed f32 numbers.
    pub fn transform(&self, i: usize, d: glam::DVec3) -> glam::DVec3 {
        match self {
            Self::Balls(radii) => d / f64::from(radii[i]),
            Self::Ellipsoids(factors) => factors[i].transform_f64(d),
        }
    }

    /// Aᵀ·y for blob `i`, in float64.
    pub fn transform_transposed(&self, i: usize, y: glam::DVec3) -> glam::DVec3 {
        match self {
            Self::Balls(radii) => y / f64::from(radii[i]),
            Self::Ellipsoids(factors) => factors[i].transform_transposed_f64(y),
        }
    }

    /// ∛(1/det A): the radius of the ball whose support has the same volume.
    pub fn mean_radius(&self, i: usize) -> f64 {
        match self {
            Self::Balls(radii) => f64::from(radii[i]),
            Self::Ellipsoids(factors) => factors[i].determinant().powf(-1.0 / 3.0),
        }
    }
}

#[cfg(test)]
mod derivative_tests;
