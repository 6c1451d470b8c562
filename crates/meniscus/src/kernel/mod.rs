//! Radial kernels k(q) of finite support: 1 at the centre, 0 for q ≥ 1.
//!
//! q is the squared distance over the squared support (a metric form for ellipsoids). The formulas
//! are written in g = 1 − q, which along a ray is a parabola. To add a kernel: one file beside these,
//! one line in [`Kernel`], one in [`Kernel::ALL`], one in `with_kernel!`.

mod octic;
mod quartic;
mod sextic;
mod wyvill;

pub use octic::Octic;
pub use quartic::Quartic;
pub use sextic::Sextic;
pub use wyvill::Wyvill;

use crate::math::number::Number;
use serde::{Deserialize, Serialize};

/// The formula of one kernel, as the engines are compiled against it. `g = 1 − q`, never negative:
/// callers clamp.
pub trait KernelShape: Copy + Send + Sync + 'static {
    /// Coefficients of k as a polynomial in g, lowest power first.
    const IN_G: &'static [f64];

    /// What [`Self::slope_in_part`] leaves out of dk/dg, so that a sum of slopes takes it once.
    const SLOPE_FACTOR: f32;

    /// k(g).
    fn of_g<N: Number>(g: N) -> N;
    /// k(g) + `sum`, in as few operations as there are.
    fn plus<N: Number>(g: N, sum: N) -> N;
    /// dk/dg over [`Self::SLOPE_FACTOR`].
    fn slope_in_part<N: Number>(g: N) -> N;
    /// dk/dg.
    #[inline(always)]
    fn slope<N: Number>(g: N) -> N {
        Self::slope_in_part(g) * Self::SLOPE_FACTOR
    }
    /// d²k/dg².
    fn curvature<N: Number>(g: N) -> N;
    /// c(g₀) with −k″(s) ≤ β·c(g₀) along g(s) = g₀ − β(s − c)².
    fn concave_bound<N: Number>(g: N) -> N;
    /// c(g₀) with +k″(s) ≤ β·c(g₀) along g(s) = g₀ − β(s − c)².
    fn convex_bound<N: Number>(g: N) -> N;
    /// The g in [0, 1] with k(g) = `value`, for `value` in [0, 1].
    fn g_at(value: f64) -> f64;
}

/// A kernel by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kernel {
    /// (1 − q)².
    Quartic,
    /// (1 − q)³.
    #[default]
    Sextic,
    /// (1 − q)⁴.
    Octic,
    /// 1 − 22/9 q + 17/9 q² − 4/9 q³.
    Wyvill,
}

/// Runs `$body` with `$shape` bound to the [`KernelShape`] of `$kernel`: the one place that turns a
/// kernel's name into compiled code.
#[macro_export]
macro_rules! with_kernel {
    ($kernel:expr, $shape:ident => $body:expr) => {
        match $kernel {
            $crate::kernel::Kernel::Quartic => {
                type $shape = $crate::kernel::Quartic;
                $body
            }
            $crate::kernel::Kernel::Sextic => {
                type $shape = $crate::kernel::Sextic;
                $body
            }
            $crate::kernel::Kernel::Octic => {
                type $shape = $crate::kernel::Octic;
                $body
            }
            $crate::kernel::Kernel::Wyvill => {
                type $shape = $crate::kernel::Wyvill;
                $body
            }
        }
    };
}

impl Kernel {
    /// Every kernel.
    pub const ALL: [Self; 4] = [Self::Quartic, Self::Sextic, Self::Octic, Self::Wyvill];

    /// The name in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quartic => "quartic",
            Self::Sextic => "sextic",
            Self::Octic => "octic",
            Self::Wyvill => "wyvill",
        }
    }

    /// The kernel of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kernel| kernel.name() == name)
    }

    /// k as a polynomial in g = 1 − q, lowest power first.
    pub fn coefficients_in_g(self) -> &'static [f64] {
        with_kernel!(self, K => K::IN_G)
    }

    /// k(q) in float64; 0 for q ≥ 1.
    pub fn value(self, q: f64) -> f64 {
        let g = (1.0 - q).max(0.0);
        polynomial(self.coefficients_in_g(), g, |_| 1.0)
    }

    /// dk/dq in float64; 0 for q ≥ 1.
    pub fn derivative(self, q: f64) -> f64 {
        let g = (1.0 - q).max(0.0);
        -polynomial(&self.coefficients_in_g()[1..], g, |power| power + 1.0)
    }

    /// d²k/dq² in float64; 0 for q ≥ 1.
    pub fn second_derivative(self, q: f64) -> f64 {
        if q >= 1.0 {
            return 0.0;
        }
        let coefficients = &self.coefficients_in_g()[2..];
        polynomial(coefficients, 1.0 - q, |power| (power + 1.0) * (power + 2.0))
    }

    /// k⁻¹: the q with k(q) = `value`; `None` unless 0 < `value` < 1.
    pub fn q_at(self, value: f64) -> Option<f64> {
        (value > 0.0 && value < 1.0).then(|| 1.0 - with_kernel!(self, K => K::g_at(value)))
    }
}

/// Σ factor(i)·cᵢ·gⁱ. In the coefficients' own float64: the formulas for lanes hold theirs in f32.
fn polynomial(coefficients: &[f64], g: f64, factor: impl Fn(f64) -> f64) -> f64 {
    coefficients
        .iter()
        .enumerate()
        .rfold(0.0, |sum, (i, c)| sum * g + factor(i as f64) * c)
}

#[cfg(test)]
mod tests;
