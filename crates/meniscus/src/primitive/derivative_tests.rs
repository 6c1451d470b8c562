//! Derivatives against dual numbers; curvature bounds against dense samples along lines.

use super::Ellipsoid;
use crate::kernel::{Kernel, KernelShape};
use crate::math::dual::Dual;
use crate::math::number::F64;
use crate::with_kernel;
use glam::{DMat3, DQuat, DVec3};

#[test]
fn slope_and_curvature_are_the_derivatives_of_the_formula() {
    for kernel in Kernel::ALL {
        for i in 0..=200 {
            let at = f64::from(i) / 200.0;
            let (formula, slope, curvature) = with_kernel!(kernel, K => (
                K::of_g(Dual::<1>::variable(0, at)),
                K::slope(F64(at)).0,
                K::curvature(F64(at)).0,
            ));
            assert!(
                (formula.gradient[0] - slope).abs() < 1e-6,
                "{kernel:?} slope at {at}"
            );
            assert!(
                (formula.hessian[0][0] - curvature).abs() < 2e-6,
                "{kernel:?} curvature at {at}"
            );
            // The formulas for lanes hold their constants in f32.
            let q = 1.0 - at;
            assert!((kernel.derivative(q) + slope).abs() < 2e-7);
            let sum = with_kernel!(kernel, K => K::plus(F64(at), F64(0.25)).0);
            assert!((sum - 0.25 - kernel.value(q)).abs() < 1e-7);
            let expected = if at > 0.0 { curvature } else { 0.0 };
            assert!((kernel.second_derivative(q) - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn coefficients_are_those_of_the_formula() {
    for kernel in Kernel::ALL {
        for i in 0..=100 {
            let g = f64::from(i) / 100.0;
            let terms = kernel.coefficients_in_g().iter().rev();
            let polynomial = terms.fold(0.0, |sum, coefficient| sum * g + coefficient);
            assert!(
                (polynomial - kernel.value(1.0 - g)).abs() < 1e-6,
                "{kernel:?} at {g}"
            );
        }
    }
}

/// Largest −k″(s) and +k″(s) along g(s) = g₀ − βs², in units of β, over the support.
fn extremes(kernel: Kernel, g0: f64) -> (f64, f64) {
    let samples = 4000;
    (0..samples).fold((f64::MIN, f64::MIN), |(concave, convex), i| {
        // β = 1; g falls to 0 at s = √g₀.
        let s = g0.sqrt() * f64::from(i) / f64::from(samples);
        let line = Dual::<1>::variable(0, s);
        let g = line * line * -1.0 + Dual::constant(g0);
        let second = with_kernel!(kernel, K => K::of_g(g)).hessian[0][0];
        (concave.max(-second), convex.max(second))
    })
}

#[test]
fn curvature_bounds_hold_along_every_chord_and_are_tight() {
    for kernel in Kernel::ALL {
        for i in 1..=100 {
            let g0 = f64::from(i) / 100.0;
            let (concave, convex) = extremes(kernel, g0);
            let (concave_bound, convex_bound) = with_kernel!(kernel, K => (
                K::concave_bound(F64(g0)).0,
                K::convex_bound(F64(g0)).0,
            ));
            assert!(
                concave <= concave_bound * (1.0 + 1e-6),
                "{kernel:?} {g0} {concave}"
            );
            assert!(
                convex <= convex_bound * (1.0 + 1e-6),
                "{kernel:?} {g0} {convex}"
            );
            assert!(concave > 0.99 * concave_bound, "{kernel:?} {g0} {concave}");
            assert!(convex > 0.6 * convex_bound, "{kernel:?} {g0} {convex}");
        }
    }
}

#[test]
fn curvature_bounds_hold_on_lines_past_thin_ellipsoids() {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.8));
    let stretch = DMat3::from_diagonal(DVec3::new(1.0, 1e-2, 1e-4));
    let ellipsoid = Ellipsoid::from_metric(turn * stretch * turn.transpose()).unwrap();
    for kernel in Kernel::ALL {
        for i in 0..300 {
            // Lines of many directions that pass the centre at many distances, tangent ones too.
            let angle = f64::from(i);
            let d = DVec3::new(angle.cos(), (1.7 * angle).sin(), (0.6 * angle).cos()).normalize();
            let v = ellipsoid.transform_f64(d);
            let beta = v.length_squared();
            let passing = f64::from(i % 30) / 30.0;
            let side = v.normalize().any_orthonormal_vector() * passing.sqrt();
            let g0 = 1.0 - side.length_squared();
            let bounds = with_kernel!(kernel, K => [
                beta * K::concave_bound(F64(g0)).0,
                beta * K::convex_bound(F64(g0)).0,
            ]);
            for j in -200..=200 {
                let s = Dual::<1>::variable(0, f64::from(j) / 200.0 / beta.sqrt());
                let [x, y, z] =
                    [0, 1, 2].map(|k| s * Dual::constant(v[k]) + Dual::constant(side[k]));
                let q = x * x + y * y + z * z;
                if q.value >= 1.0 {
                    continue;
                }
                let g = q * -1.0 + 1.0;
                let second = with_kernel!(kernel, K => K::of_g(g)).hessian[0][0];
                let slack = 1.0 + 1e-5;
                assert!(-second <= bounds[0] * slack, "{kernel:?} line {i} at {j}");
                assert!(second <= bounds[1] * slack, "{kernel:?} line {i} at {j}");
            }
        }
    }
}
