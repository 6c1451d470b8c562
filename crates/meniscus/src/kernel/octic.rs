//! `octic`: k(q) = (1 − q)⁴ (Gourmel et al. 2010, §2.1 with α = 4).

use super::KernelShape;
use crate::math::number::Number;

/// k = g⁴ with g = 1 − q.
#[derive(Debug, Clone, Copy)]
pub struct Octic;

impl KernelShape for Octic {
    const IN_G: &'static [f64] = &[0.0, 0.0, 0.0, 0.0, 1.0];
    const SLOPE_FACTOR: f32 = 4.0;

    #[inline(always)]
    fn of_g<N: Number>(g: N) -> N {
        let g2 = g * g;
        g2 * g2
    }

    #[inline(always)]
    fn plus<N: Number>(g: N, sum: N) -> N {
        let g2 = g * g;
        g2.mul_add(g2, sum)
    }

    #[inline(always)]
    fn slope_in_part<N: Number>(g: N) -> N {
        g * g * g
    }

    #[inline(always)]
    fn curvature<N: Number>(g: N) -> N {
        g * g * 12.0
    }

    #[inline(always)]
    fn concave_bound<N: Number>(g: N) -> N {
        g * g * g * 8.0
    }

    #[inline(always)]
    fn convex_bound<N: Number>(g: N) -> N {
        g * g * g * 5.23
    }

    fn g_at(value: f64) -> f64 {
        value.sqrt().sqrt()
    }
}
