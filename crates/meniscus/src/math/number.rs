//! The arithmetic that leaf math (kernels, primitive distances) is written in, once.
//!
//! A formula generic over [`Number`] runs on f32, f64, SIMD lanes and dual numbers alike.

use fearless_simd::SimdFloat;
use std::ops::{Add, Div, Mul, Sub};

/// A field of numbers with constants taken from f32.
///
/// Constants multiply from the right (`x * 2.0`) so that SIMD lanes, which cannot be made from a
/// constant without their level token, fit as well.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f32, Output = Self>
    + Add<f32, Output = Self>
{
    /// `self·factor + summand`, fused where the machine does that at no cost.
    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        self * factor + summand
    }

    /// `summand − self·factor`, fused likewise.
    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        summand - self * factor
    }
}

impl Number for f32 {}

/// f64 with the operator set of [`Number`].
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct F64(pub f64);

macro_rules! f64_operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for F64 {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self(self.0 $operator other.0)
            }
        }
        impl $trait<f32> for F64 {
            type Output = Self;
            fn $method(self, other: f32) -> Self {
                Self(self.0 $operator f64::from(other))
            }
        }
    };
}
f64_operator!(Add, add, +);
f64_operator!(Sub, sub, -);
f64_operator!(Mul, mul, *);
f64_operator!(Div, div, /);
impl Number for F64 {}

impl<S: fearless_simd::Simd> Number for fearless_simd::f32x8<S> {
    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        SimdFloat::mul_add(self, factor, summand)
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        SimdFloat::mul_add(-self, factor, summand)
    }
}

impl<S: fearless_simd::Simd> Number for fearless_simd::f32x16<S> {
    #[inline(always)]
    fn mul_add(self, factor: Self, summand: Self) -> Self {
        SimdFloat::mul_add(self, factor, summand)
    }

    #[inline(always)]
    fn neg_mul_add(self, factor: Self, summand: Self) -> Self {
        SimdFloat::mul_add(-self, factor, summand)
    }
}
