use super::*;
use crate::field::BlobField;
use crate::math::symmetric::eigen;
use crate::particles::Particles;
use crate::particles::spacing::point_tree;
use crate::scene::generate::Generator;
use crate::scene::{Anisotropy, BlobSettings, Weights};
use glam::DMat3;

/// The estimate straight from its formulas: all pairs, float64, and matrix functions by Lagrange's
/// interpolation on eigenvalues in closed form (Smith 1961) instead of rotations.
fn plainly(positions: &[DVec3], support: f64, i: usize) -> (DVec3, DMat3) {
    let reach = NEIGHBOURHOOD * support;
    let (mut weights, mut mean) = (0.0, DVec3::ZERO);
    let weight_of = |x: DVec3| (1.0 - (x.distance(positions[i]) / reach).powi(3)).max(0.0);
    for &x in positions {
        weights += weight_of(x);
        mean += x * weight_of(x);
    }
    mean /= weights;
    let mut c = DMat3::ZERO;
    for &x in positions {
        let d = x - mean;
        c += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * weight_of(x);
    }
    c *= 1.0 / (weights * FILLED * reach * reach);
    let t = ((weights - FEW[0]) / (FEW[1] - FEW[0])).clamp(0.0, 1.0);
    let counts = t * t * (3.0 - 2.0 * t);
    let center = positions[i] + (mean - positions[i]) * (SMOOTHING * counts);

    let trace = c.x_axis.x + c.y_axis.y + c.z_axis.z;
    let deviator = c - DMat3::IDENTITY * (trace / 3.0);
    let square = deviator * deviator;
    let size = ((square.x_axis.x + square.y_axis.y + square.z_axis.z) / 6.0).sqrt();
    let values = if size < 1e-12 {
        [trace / 3.0; 3]
    } else {
        let angle = (deviator.determinant() / (2.0 * size.powi(3)))
            .clamp(-1.0, 1.0)
            .acos()
            / 3.0;
        let third = std::f64::consts::TAU / 3.0;
        [0.0, third, 2.0 * third].map(|turn| trace / 3.0 + 2.0 * size * (angle + turn).cos())
    };
    let largest = values.iter().copied().fold(0.0, f64::max);
    let function = |sigma: f64| {
        let sigma = sigma.max(largest / LARGEST_RATIO).max(LEAST);
        (1.0 + (sigma - 1.0) * counts).powi(-2) / (support * support)
    };
    // f(C) in Newton's form with divided differences; those of equal values are never reached here.
    let [a, b, d] = values;
    let first = (function(b) - function(a)) / (b - a);
    let second = ((function(d) - function(b)) / (d - b) - first) / (d - a);
    let at = |value: f64| c - DMat3::IDENTITY * value;
    (
        center,
        DMat3::IDENTITY * function(a) + at(a) * first + at(a) * at(b) * second,
    )
}

fn metric([a, b, c, d, e, f]: [f64; 6]) -> DMat3 {
    let rows = DMat3::from_cols_array(&[a, 0.0, 0.0, b, d, 0.0, c, e, f]);
    rows.transpose() * rows
}

#[test]
fn the_same_as_straight_from_the_formulas() {
    for (name, count) in [(Generator::Splash, 3000), (Generator::Fountain, 2000)] {
        let positions = name.generate(count, 1, None).unwrap().particles.positions;
        let points = point_tree(&positions);
        let spacing = crate::particles::spacing::median_spacing_in(&points, &positions).unwrap();
        let support = 2.0 * spacing;
        let estimate = estimate(&positions, &vec![support; positions.len()], &points);
        let (mut worst, mut stretched) = (0.0_f64, 0);
        for i in (0..positions.len()).step_by(7) {
            let (center, expected) = plainly(&positions, support, i);
            let found = metric(estimate.factors[i]);
            let size = |m: DMat3| {
                m.to_cols_array()
                    .iter()
                    .map(|a| a.abs())
                    .fold(0.0, f64::max)
            };
            let off = size(found - expected) / size(expected);
            worst = worst
                .max(off)
                .max(center.distance(estimate.centers[i]) / support);
            stretched += usize::from(size(expected) * support * support > 2.0);
        }
        assert!(worst < 1e-4, "{name:?}: off by {worst}");
        assert!(stretched > 50, "only {stretched} particles are stretched");
    }
}

#[test]
fn a_filled_neighbourhood_a_sheet_and_lone_particles() {
    let grid = |size: [i32; 3]| -> Vec<DVec3> {
        let mut positions = Vec::new();
        for x in 0..size[0] {
            for y in 0..size[1] {
                for z in 0..size[2] {
                    positions.push(DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
                }
            }
        }
        positions
    };
    let of = |positions: &[DVec3], i: usize| {
        let supports = vec![2.0; positions.len()];
        let estimate = estimate(positions, &supports, &point_tree(positions));
        let (values, _) = eigen(metric(estimate.factors[i]));
        let mut radii = values.to_array().map(|value| 1.0 / value.sqrt());
        radii.sort_by(f64::total_cmp);
        (estimate.centers[i], radii)
    };
    let bulk = grid([9, 9, 9]);
    let (center, radii) = of(&bulk, 4 * 81 + 4 * 9 + 4);
    assert!(center.distance(DVec3::splat(4.0)) < 1e-5);
    assert!(
        radii.iter().all(|r| (r / 2.0 - 1.0).abs() < 0.1),
        "{radii:?}"
    );

    let sheet = grid([13, 13, 1]);
    let (_, [thin, a, b]) = of(&sheet, 6 * 13 + 6);
    assert!(
        (a / thin - 4.0).abs() < 1e-3 && (b / thin - 4.0).abs() < 1e-3,
        "{thin} {a} {b}"
    );
    assert!(a > 2.0 && a < 2.6);

    let apart = [DVec3::ZERO, DVec3::X * 10.0];
    let (center, radii) = of(&apart, 1);
    assert_eq!(center, apart[1]);
    assert!(radii.iter().all(|r| (r - 2.0).abs() < 1e-12), "{radii:?}");

    let heap = vec![DVec3::ONE; 40];
    let (center, radii) = of(&heap, 3);
    assert_eq!(center, DVec3::ONE);
    assert!(radii.iter().all(|r| *r > 0.0 && r.is_finite()), "{radii:?}");
}

#[test]
fn the_same_for_any_number_of_threads() {
    let positions = Generator::Splash
        .generate(5000, 1, None)
        .unwrap()
        .particles
        .positions;
    let points = point_tree(&positions);
    let supports = vec![0.02; positions.len()];
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let found = pool
            .unwrap()
            .install(|| estimate(&positions, &supports, &points));
        (found.centers, found.factors)
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn few_particles_and_strays_far_away() {
    // Fewer than there are lanes, in groups that the curve tears apart, sizes far apart.
    for count in [1, 2, 15, 17, 33, 70] {
        let mut positions: Vec<DVec3> = (0..count)
            .map(|i| DVec3::new(f64::from(i % 5), f64::from(i / 5 % 5), f64::from(i / 25)) * 0.3)
            .collect();
        positions.push(DVec3::new(1e9, -1e9, 3.0));
        positions.push(DVec3::splat(1e17));
        let points = point_tree(&positions);
        for support in [0.7, 5.0] {
            let estimate = estimate(&positions, &vec![support; positions.len()], &points);
            for i in 0..positions.len() - 2 {
                let (center, expected) = plainly(&positions[..count as usize], support, i);
                assert!(
                    center.distance(estimate.centers[i]) < 1e-5 * support,
                    "{count} {i}"
                );
                let found = metric(estimate.factors[i]);
                if expected.is_finite() {
                    let size = |m: DMat3| {
                        m.to_cols_array()
                            .map(f64::abs)
                            .into_iter()
                            .fold(0.0, f64::max)
                    };
                    let off = size(found - expected) / size(expected);
                    assert!(off < 1e-4, "{count} {i}: {found} {expected}");
                }
            }
            let stray = &estimate.factors[positions.len() - 1];
            assert_eq!(*stray, [1.0, 0.0, 0.0, 1.0, 0.0, 1.0].map(|a| a / support));
        }
    }
}

#[test]
fn a_sheet_has_the_volume_that_it_has_of_balls() {
    // ∫F over a column through the middle of a sheet, as a part of the particles' own volume there.
    let mut positions = Vec::new();
    for i in 0..21 * 21 {
        positions.push(DVec3::new(f64::from(i % 21), f64::from(i / 21), 0.0));
    }
    let volume = |anisotropy: Anisotropy| {
        let settings = BlobSettings {
            radius: Some(0.5),
            anisotropy,
            weights: Weights::BallVolume,
            ..BlobSettings::default()
        };
        let particles = Particles::from_positions(positions.clone());
        let field = BlobField::from_particles(&particles, &settings)
            .unwrap()
            .field;
        let mut sum = 0.0;
        for (x, y) in [(10.0, 10.0), (10.5, 10.0), (10.5, 10.5), (10.25, 10.5)] {
            for step in -300..300 {
                let z = (f64::from(step) + 0.5) * 0.01;
                sum += field.value(DVec3::new(x, y, z) - field.origin) * 0.01;
            }
        }
        0.25 * sum
    };
    let [balls, ellipsoids] = [Anisotropy::None, Anisotropy::Estimate].map(volume);
    assert!(
        (ellipsoids / balls - 1.0).abs() < 0.02,
        "{balls} {ellipsoids}"
    );
}
