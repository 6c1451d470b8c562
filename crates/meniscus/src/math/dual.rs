//! Dual numbers: a formula written over [`Number`] once yields its exact derivatives too. They are what
//! hand-written derivatives are tested against.
//!
//! A [`Dual`] carries a value, its gradient and its Hessian in `N` variables (truncated Taylor
//! arithmetic to second order; Fike & Alonso 2011 call the mixed part hyper-dual).

use super::number::Number;
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// A number with its first and second derivatives by `N` variables, in float64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives, symmetric.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Dual<N> {
    /// A number that depends on no variable.
    pub fn constant(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
        }
    }

    /// Variable `index` at `value`.
    ///
    /// # Panics
    /// If there is no such variable.
    pub fn variable(index: usize, value: f64) -> Self {
        let mut variable = Self::constant(value);
        variable.gradient[index] = 1.0;
        variable
    }

    /// All variables at a point.
    pub fn variables(point: [f64; N]) -> [Self; N] {
        from_fn(|i| Self::variable(i, point[i]))
    }

    /// f(self) for a function with this value, slope and curvature there.
    #[must_use]
    pub fn chain(self, value: f64, slope: f64, curvature: f64) -> Self {
        let g = self.gradient;
        Self {
            value,
            gradient: g.map(|d| slope * d),
            hessian: from_fn(|i| from_fn(|j| slope * self.hessian[i][j] + curvature * g[i] * g[j])),
        }
    }

    fn combine(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            value: f(self.value, other.value),
            gradient: from_fn(|i| f(self.gradient[i], other.gradient[i])),
            hessian: from_fn(|i| from_fn(|j| f(self.hessian[i][j], other.hessian[i][j]))),
        }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.combine(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.combine(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self, &other);
        Self {
            value: a.value * b.value,
            gradient: from_fn(|i| a.gradient[i] * b.value + a.value * b.gradient[i]),
            hessian: from_fn(|i| {
                from_fn(|j| {
                    a.hessian[i][j] * b.value
                        + a.gradient[i] * b.gradient[j]
                        + a.gradient[j] * b.gradient[i]
                        + a.value * b.hessian[i][j]
                })
            }),
        }
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let r = 1.0 / other.value;
        self * other.chain(r, -r * r, 2.0 * r * r * r)
    }
}

impl<const N: usize> Mul<f32> for Dual<N> {
    type Output = Self;
    fn mul(self, factor: f32) -> Self {
        let factor = f64::from(factor);
        self.chain(self.value * factor, factor, 0.0)
    }
}

impl<const N: usize> Add<f32> for Dual<N> {
    type Output = Self;
    fn add(self, summand: f32) -> Self {
        self.chain(self.value + f64::from(summand), 1.0, 0.0)
    }
}

impl<const N: usize> Number for Dual<N> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_function_has_its_derivatives() {
        // f = (x²y + 3)/(y − 2x)
        let (x, y) = (0.7, 3.1);
        let [dx, dy] = Dual::variables([x, y]);
        let f = (dx * dx * dy + 3.0) / (dy - dx * 2.0);
        let at = |x: f64, y: f64| (x * x * y + 3.0) / (y - 2.0 * x);
        assert!((f.value - at(x, y)).abs() < 1e-15);
        let h = 1e-4;
        let first = [
            (at(x + h, y) - at(x - h, y)) / (2.0 * h),
            (at(x, y + h) - at(x, y - h)) / (2.0 * h),
        ];
        let mixed = (at(x + h, y + h) - at(x + h, y - h) - at(x - h, y + h) + at(x - h, y - h))
            / (4.0 * h * h);
        let second = [
            (at(x + h, y) - 2.0 * at(x, y) + at(x - h, y)) / (h * h),
            (at(x, y + h) - 2.0 * at(x, y) + at(x, y - h)) / (h * h),
        ];
        for i in 0..2 {
            assert!((f.gradient[i] - first[i]).abs() < 1e-6);
            assert!((f.hessian[i][i] - second[i]).abs() < 1e-5);
            assert!((f.hessian[i][1 - i] - mixed).abs() < 1e-5);
        }
    }

    #[test]
    fn a_cube_has_the_derivatives_of_a_cube() {
        let x = Dual::<1>::variable(0, 2.0);
        let cube = x * x * x;
        assert_eq!(
            (cube.value, cube.gradient[0], cube.hessian[0][0]),
            (8.0, 12.0, 12.0)
        );
        assert_eq!(cube, x.chain(8.0, 12.0, 12.0));
    }
}
