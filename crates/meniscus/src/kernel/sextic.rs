//! `sextic`: k(q) = (1 − q)³ (the shape of SPH's poly6; Ray Tracing Gems II, ch. 35).

use super::KernelShape;
use crate::math::number::Number;

/// k = g³ with g = 1 − q.
#[derive(Debug, Clone, Copy)]
pub struct Sextic;

impl KernelShape for Sextic {
    const IN_G: &'static [f64] = &[0.0, 0.0, 0.0, 1.0];
    const SLOPE_FACTOR: f32 = 3.0;

    #[inline(always)]
    fn of_g<N: Number>(g: N) -> N {
        g * g * g
    }

    #[inline(always)]
    fn plus<N: Number>(g: N, sum: N) -> N {
        (g * g).mul_add(g, sum)
    }

    #[inline(always)]
    fn slope_in_part<N: Number>(g: N) -> N {
        g * g
    }

    #[inline(always)]
    fn curvature<N: Number>(g: N) -> N {
        g * 6.0
    }

    #[inline(always)]
    fn concave_bound<N: Number>(g: N) -> N {
        g * g * 6.0
    }

    #[inline(always)]
    fn convex_bound<N: Number>(g: N) -> N {
        g * g * 4.8
    }

    fn g_at(value: f64) -> f64 {
        value.cbrt()
    }
}
