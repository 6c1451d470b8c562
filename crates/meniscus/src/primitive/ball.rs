//! The ball: A = I/R.

use super::{AlongLine, Primitive, Shapes, dot};
use crate::math::number::Number;
use crate::math::simd::xyz;

/// A ball; its one packed column is 1/R.
#[derive(Debug, Clone, Copy)]
pub struct Ball;

impl Primitive for Ball {
    const COLUMNS: usize = 1;
    const BETA_TURNS: bool = false;
    const DIAGONAL: &'static [usize] = &[0];

    #[inline(always)]
    fn transform<N: Number>(columns: &[N], d: [N; 3]) -> [N; 3] {
        [d[0] * columns[0], d[1] * columns[0], d[2] * columns[0]]
    }

    #[inline(always)]
    fn transform_transposed<N: Number>(columns: &[N], y: [N; 3]) -> [N; 3] {
        Self::transform(columns, y)
    }

    #[inline(always)]
    fn along<N: Number>(columns: &[N], w: [N; 3], d: [N; 3]) -> AlongLine<N> {
        let beta = columns[0] * columns[0];
        let c = dot(w, d);
        // The perpendicular vector: |w|² − c² would cancel.
        let e = xyz(
            #[inline(always)]
            |k| c.neg_mul_add(d[k], w[k]),
        );
        let g0 = (beta * dot(e, e)) * -1.0 + 1.0;
        AlongLine { c, beta, g0 }
    }

    fn pack(shapes: &Shapes, i: usize, columns: &mut [f32]) {
        let Shapes::Balls(radii) = shapes else {
            panic!("balls expected");
        };
        columns[0] = 1.0 / radii[i];
    }
}
