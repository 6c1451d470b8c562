//! Derivatives in space and time against dual numbers.

use super::evaluation::fields;
use super::random;
use crate::field::{BlobField, Motion};
use crate::math::dual::Dual;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use glam::{DMat3, DVec3};

/// F in dual numbers by x, y, z and time, from the formulas that the engines are compiled against.
fn dual_value(field: &BlobField, local: DVec3, secs: f64) -> Dual<4> {
    let point = Dual::<4>::variables([local.x, local.y, local.z, secs]);
    let time = point[3];
    (0..field.len()).fold(Dual::constant(0.0), |sum, i| {
        let d = [0, 1, 2].map(|k| {
            let mut center = Dual::constant(f64::from(field.centers[i][k]));
            if let Some(motion) = &field.motion {
                let [velocity, half] = motion.rates(i);
                center = center
                    + time * Dual::constant(velocity[k])
                    + time * time * Dual::constant(half[k]);
            }
            point[k] - center
        });
        let d = match &field.motion {
            Some(motion) if motion.turns() => turned(&motion.velocity_gradients[i], time, d),
            Some(_) | None => d,
        };
        let y = match &field.shapes {
            Shapes::Balls(radii) => {
                Ball::transform(&[Dual::constant(1.0 / f64::from(radii[i]))], d)
            }
            Shapes::Ellipsoids(factors) => {
                Ellipsoid::transform(&factors[i].0.map(|a| Dual::constant(f64::from(a))), d)
            }
        };
        let q = y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
        if q.value >= 1.0 {
            return sum;
        }
        let g = q * -1.0 + 1.0;
        let coefficients = field.kernel.coefficients_in_g().iter().rev();
        let k = coefficients.fold(Dual::constant(0.0), |sum, &c| sum * g + Dual::constant(c));
        sum + k * Dual::constant(f64::from(field.weights[i]))
    })
}

/// d − tLd + ½t²LLd.
fn turned(gradient: &[f32; 9], time: Dual<4>, d: [Dual<4>; 3]) -> [Dual<4>; 3] {
    let moved = |d: [Dual<4>; 3]| {
        [0, 3, 6].map(|row| {
            let term = |k: usize| d[k] * Dual::constant(f64::from(gradient[row + k])) * time;
            term(0) + term(1) + term(2)
        })
    };
    let once = moved(d);
    let twice = moved(once);
    [0, 1, 2].map(|k| d[k] + once[k] * -1.0 + twice[k] * 0.5)
}

fn random_rows<const N: usize>(
    count: usize,
    size: f64,
    next: &mut impl FnMut() -> f64,
) -> Vec<[f32; N]> {
    let mut row = || [0; N].map(|_| ((next() - 0.5) * size) as f32);
    (0..count).map(|_| row()).collect()
}

/// The same blobs, thrown in all directions while the shutter is open from −0.5 to 0.5 seconds;
/// ellipsoids turn and stretch.
fn thrown(field: BlobField) -> BlobField {
    let mut next = random(21);
    let count = field.len();
    let have_axes = matches!(field.shapes, Shapes::Ellipsoids(_));
    BlobField {
        motion: Some(Motion {
            velocities: random_rows(count, 0.4, &mut next),
            half_accelerations: random_rows(count, 0.6, &mut next),
            velocity_gradients: random_rows(if have_axes { count } else { 0 }, 1.0, &mut next),
            shutter: [-0.5, 0.5],
        }),
        search: Default::default(),
        ..field
    }
}

fn size(m: DMat3) -> f64 {
    m.to_cols_array()
        .into_iter()
        .fold(0.0, |s: f64, e| s.max(e.abs()))
}

fn assert_derivatives(field: &BlobField, secs: f64) {
    let at = field.at(secs);
    for i in (0..field.len()).step_by(7) {
        let half = DVec3::from_array(field.shapes.half_extents(i).map(f64::from));
        let point = at.center(i) + half * DVec3::new(0.3, -0.2, 0.1);
        let expected = dual_value(field, point, secs);
        assert!((at.value(point) - expected.value).abs() < 1e-12);
        let [x, y, z, rate] = expected.gradient;
        let gradient = DVec3::new(x, y, z);
        let found = at.level_set(point);
        for gradient_found in [found.gradient, at.gradient(point)] {
            let error = (gradient_found - gradient).length();
            assert!(
                error <= 1e-7 * gradient.length() + 1e-12,
                "{error} of {gradient}"
            );
        }
        let column = |k: usize| DVec3::from_slice(&expected.hessian[k][..3]);
        let hessian = DMat3::from_cols(column(0), column(1), column(2));
        let error = size(found.hessian - hessian);
        assert!(
            error <= 1e-6 * size(hessian) + 1e-12,
            "{error} of {}",
            size(hessian)
        );
        // Terms of several blobs cancel: the bounds are relative to what a single speed could do.
        let error = (found.rate - rate).abs();
        assert!(
            error <= 1e-6 * gradient.length() + 1e-11,
            "{error} of {rate}"
        );
        let error = (found.gradient_rate - column(3)).length();
        assert!(
            error <= 1e-6 * size(hessian) + 1e-11,
            "{error} of {}",
            column(3)
        );
        assert_eq!(at.hessian(point), found.hessian);
    }
}

#[test]
fn derivatives_are_those_of_the_value_in_space() {
    for field in fields() {
        assert_derivatives(&field, 0.0);
        let found = field.at(0.0).level_set(field.center(0).as_dvec3());
        assert_eq!((found.rate, found.gradient_rate), (0.0, DVec3::ZERO));
    }
}

#[test]
fn derivatives_are_those_of_the_value_in_space_and_time() {
    for field in fields().into_iter().map(thrown) {
        for secs in [-0.5, 0.0, 0.3] {
            assert_derivatives(&field, secs);
        }
    }
}

#[test]
fn boxes_hold_supports_that_move_turn_and_stretch() {
    let mut next = random(22);
    let mut seen = 0;
    for field in fields().into_iter().map(thrown) {
        for i in 0..field.len() {
            let all = field.support_box(i);
            let [open, close] = field.motion_boxes(i).ends;
            for _ in 0..20 {
                let phase = next();
                let at = field.at(phase - 0.5);
                // A point of the support's border: y is a unit vector.
                let y = DVec3::from_array([0; 3].map(|_| next() - 0.5)).normalize();
                let axes = DVec3::AXES.map(|axis| at.transform(i, axis));
                let from_y = DMat3::from_cols(axes[0], axes[1], axes[2]).inverse();
                let border = at.center(i) + from_y * y;
                for axis in 0..3 {
                    let between =
                        |a: f32, b: f32| f64::from(a) * (1.0 - phase) + f64::from(b) * phase;
                    let low = between(open.min[axis], close.min[axis]);
                    let high = between(open.max[axis], close.max[axis]);
                    let margin = 1e-6 * (1.0 + border[axis].abs());
                    let found = border[axis];
                    assert!(low - margin <= found && found <= high + margin);
                    assert!(f64::from(all.min[axis]) - margin <= found);
                    assert!(found <= f64::from(all.max[axis]) + margin);
                }
                seen += 1;
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
