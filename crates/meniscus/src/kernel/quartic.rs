//! `quartic`: k(q) = (1 − q)² (Murakami 1987; POV-Ray blobs; Rouiller 2011).

use super::KernelShape;
use crate::math::number::Number;

/// k = g² with g = 1 − q.
#[derive(Debug, Clone, Copy)]
pub struct Quartic;

impl KernelShape for Quartic {
    const IN_G: &'static [f64] = &[0.0, 0.0, 1.0];
    const SLOPE_FACTOR: f32 = 2.0;

    #[inline(always)]
    fn of_g<N: Number>(g: N) -> N {
        g * g
    }

    #[inline(always)]
    fn plus<N: Number>(g: N, sum: N) -> N {
        g.mul_add(g, sum)
    }

    #[inline(always)]
    fn slope_in_part<N: Number>(g: N) -> N {
        g
    }

    #[inline(always)]
    fn curvature<N: Number>(g: N) -> N {
        g * 0.0 + 2.0
    }

    #[inline(always)]
    fn concave_bound<N: Number>(g: N) -> N {
        g * 4.0
    }

    #[inline(always)]
    fn convex_bound<N: Number>(g: N) -> N {
        g * 8.0
    }

    fn g_at(value: f64) -> f64 {
        value.sqrt()
    }
}
