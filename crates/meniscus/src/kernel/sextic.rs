//! `sextic`: k(q) = (1 − q)³ (the shape of SPH's poly6; Ray Tracing Gems II, ch. 35).

use super::KernelShape;
use crate::math::number::Number;

/// k = g³ with g = 1 − q.
#[derive(Debug, Clone, Copy)]
pub struct Sextic;

impl KernelShape for Sextic {
    const IN_G: &'static [f64] = &[0.0, 0.0, 0.0, 1.0];

    #[inline(always)]
    fn of_g<N: Number>(g: N) -> N {
        g * g * g
    }

    #[inline(always)]
    fn slope<N: Number>(g: N) -> N {
        g * g * 3.0
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
