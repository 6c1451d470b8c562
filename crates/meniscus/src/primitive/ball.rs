//! The ball: A = I/R.

use super::Primitive;
use crate::math::number::Number;

/// A ball; its one packed column is 1/R.
#[derive(Debug, Clone, Copy)]
pub struct Ball;

impl Primitive for Ball {
    const COLUMNS: usize = 1;

    #[inline(always)]
    fn transform<N: Number>(columns: &[N], d: [N; 3]) -> [N; 3] {
        [d[0] * columns[0], d[1] * columns[0], d[2] * columns[0]]
    }

    #[inline(always)]
    fn transform_transposed<N: Number>(columns: &[N], y: [N; 3]) -> [N; 3] {
        Self::transform(columns, y)
    }
}
