//! `wyvill`: k(q) = 1 − 22/9 q + 17/9 q² − 4/9 q³ = (5g² + 4g³)/9 with g = 1 − q
//! (Wyvill, McPheeters & Wyvill 1986; Kanamori et al. 2008).

use super::KernelShape;
use crate::math::number::Number;

/// k = (5g² + 4g³)/9; its bounds are 5/9 of `quartic`'s and 4/9 of `sextic`'s.
#[derive(Debug, Clone, Copy)]
pub struct Wyvill;

const SQUARE: f32 = 5.0 / 9.0;
const CUBE: f32 = 4.0 / 9.0;

impl KernelShape for Wyvill {
    const IN_G: &'static [f64] = &[0.0, 0.0, 5.0 / 9.0, 4.0 / 9.0];
    const SLOPE_FACTOR: f32 = 1.0;

    #[inline(always)]
    fn of_g<N: Number>(g: N) -> N {
        g * g * (g * CUBE + SQUARE)
    }

    #[inline(always)]
    fn plus<N: Number>(g: N, sum: N) -> N {
        (g * g).mul_add(g * CUBE + SQUARE, sum)
    }

    #[inline(always)]
    fn slope_in_part<N: Number>(g: N) -> N {
        g * (g * (3.0 * CUBE) + 2.0 * SQUARE)
    }

    #[inline(always)]
    fn curvature<N: Number>(g: N) -> N {
        g * (6.0 * CUBE) + 2.0 * SQUARE
    }

    #[inline(always)]
    fn concave_bound<N: Number>(g: N) -> N {
        g * (g * (6.0 * CUBE) + 4.0 * SQUARE)
    }

    #[inline(always)]
    fn convex_bound<N: Number>(g: N) -> N {
        g * (g * (4.8 * CUBE) + 8.0 * SQUARE)
    }

    fn g_at(value: f64) -> f64 {
        // Monotonic and convex on [0, 1]: Newton from the right end never overshoots.
        let mut g = 1.0_f64;
        for _ in 0..60 {
            let step = (5.0 * g * g + 4.0 * g * g * g - 9.0 * value) / (10.0 * g + 12.0 * g * g);
            g -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        g
    }
}
