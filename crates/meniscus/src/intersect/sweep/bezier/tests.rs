use super::{Active, Bezier, MAX_COEFFICIENTS, Piece, binomial, expand, first_rise, kernel_of};
use crate::intersect::Counters;
use crate::kernel::{KernelShape, Octic, Quartic, Sextic, Wyvill};

/// −Π (u − rootᵢ)·sign, of the degree that many roots give.
fn with_roots(roots: &[f64], sign: f64) -> Bezier {
    let mut scaled = [0.0; MAX_COEFFICIENTS];
    scaled[0] = sign;
    for (degree, &root) in roots.iter().enumerate() {
        let mut product = [0.0; MAX_COEFFICIENTS];
        for i in 0..=degree {
            product[i] += scaled[i] * -root;
            product[i + 1] += scaled[i] * (1.0 - root);
        }
        scaled = product;
    }
    let degree = roots.len();
    let mut c = [0.0; MAX_COEFFICIENTS];
    for i in 0..=degree {
        c[i] = scaled[i] / binomial(degree, i);
    }
    Bezier { c, degree }
}

fn rise(curve: &Bezier) -> Option<f64> {
    let mut counters = Counters::default();
    first_rise(curve, 1e-15, &mut Vec::<Piece>::new(), &mut counters)
}

#[test]
fn finds_the_first_of_many_roots() {
    // With this sign the curve starts below zero whatever the number of roots.
    let cases: [&[f64]; 5] = [
        &[0.3],
        &[0.25, 0.5],
        &[0.1, 0.2, 0.3, 0.9],
        &[0.123, 0.124, 0.125, 0.7, 0.8, 0.95],
        &[0.45, 0.450_01, 0.6, 0.61, 0.62, 0.63, 0.9, 0.99],
    ];
    for roots in cases {
        let sign = if roots.len() % 2 == 0 { -1.0 } else { 1.0 };
        let found = rise(&with_roots(roots, sign)).unwrap();
        assert!((found - roots[0]).abs() < 1e-9, "{roots:?}: {found}");
    }
}

#[test]
fn a_touch_is_no_rise_and_does_not_hide_the_next_root() {
    assert_eq!(rise(&with_roots(&[0.5, 0.5], -1.0)), None);
    assert_eq!(rise(&with_roots(&[0.25, 0.25, 0.75, 0.75], -1.0)), None);
    let found = rise(&with_roots(&[0.375, 0.375, 0.625], 1.0)).unwrap();
    assert!((found - 0.625).abs() < 1e-9, "{found}");
    let triple = rise(&with_roots(&[0.375, 0.375, 0.375], 1.0)).unwrap();
    assert!((triple - 0.375).abs() < 1e-4, "{triple}");
}

#[test]
fn roots_at_the_ends_and_outside() {
    assert!(rise(&with_roots(&[0.0], 1.0)).unwrap() < 1e-15);
    assert_eq!(rise(&with_roots(&[1.0], 1.0)), None);
    assert_eq!(rise(&with_roots(&[1.5, -0.5], 1.0)), None);
    assert_eq!(rise(&with_roots(&[-0.5], 1.0)), Some(0.0));
}

#[test]
fn splitting_keeps_the_curve() {
    let curve = with_roots(&[0.2, 0.3, 0.7, 0.9, 0.95, 1.3], 1.0);
    let (left, right) = curve.split(0.37);
    for i in 0..=10 {
        let v = f64::from(i) / 10.0;
        let direct = curve.value_and_slope(0.37 * v).0;
        assert!((left.value_and_slope(v).0 - direct).abs() < 1e-14);
        let direct = curve.value_and_slope(0.37 + 0.63 * v).0;
        assert!((right.value_and_slope(v).0 - direct).abs() < 1e-14);
    }
}

#[test]
fn the_expansion_is_the_sum_of_the_kernels() {
    fn check<K: KernelShape>() {
        let blob = |g0, beta, center, weight| Active {
            index: 0,
            weight,
            g0,
            beta,
            center,
        };
        let active = [
            blob(0.9, 0.25, 10.0, 1.0),
            blob(0.4, 0.01, 12.0, -0.7),
            blob(1.0, 1.0, 10.2, 2.5),
        ];
        let (from, to) = (9.7, 10.9);
        let curve = expand::<K>(0.3, &active, (from, to));
        for i in 0..=20 {
            let u = f64::from(i) / 20.0;
            let s = from + u * (to - from);
            let sum: f64 = active
                .iter()
                .map(|b| b.weight * kernel_of::<K>(b.g(s).max(0.0)))
                .sum();
            let (value, _) = curve.value_and_slope(u);
            assert!((value - (sum - 0.3)).abs() < 1e-13, "{value} {sum}");
        }
    }
    check::<Quartic>();
    check::<Sextic>();
    check::<Octic>();
    check::<Wyvill>();
}
