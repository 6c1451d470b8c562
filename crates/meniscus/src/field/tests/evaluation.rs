//! Values, derivatives and weights against the plain definitions.

use super::{build, pool, random, unit, with_columns};
use crate::field::{BlobField, Contribution};
use crate::kernel::Kernel;
use crate::math::ray::Side;
use crate::particles::{Column, Particles};
use crate::scene::surface::{BlobSettings, Weights};
use glam::{DMat3, DVec3};

/// The metric of particle i, as 1/R² or as a column of six.
type Metric = DMat3;

fn ball(radius: f64) -> Metric {
    DMat3::from_diagonal(DVec3::splat(1.0 / (radius * radius)))
}

/// wᵢ by the formula of the conventions.
fn volume_weights(positions: &[DVec3], metrics: &[Metric], kernel: Kernel) -> Vec<f64> {
    let det_a = |j: usize| metrics[j].determinant().sqrt();
    (0..positions.len())
        .map(|i| {
            let sum: f64 = (0..positions.len())
                .map(|j| {
                    let d = positions[i] - positions[j];
                    kernel.value(d.dot(metrics[j] * d)) * det_a(j) / det_a(i)
                })
                .sum();
            1.0 / sum
        })
        .collect()
}

fn assert_close(found: &[f32], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        let error = (f64::from(*found) - expected).abs() / expected;
        assert!(error < 1e-6, "weight {i}: {found} for {expected}");
    }
}

#[test]
fn volume_weights_follow_the_definition_for_balls() {
    let mut next = random(3);
    let positions = pool(9);
    for spread in [0.0, 1.0, 20.0] {
        let radii: Vec<f64> = positions
            .iter()
            .map(|_| 0.5 * (-spread * next()).exp2())
            .collect();
        let metrics: Vec<Metric> = radii.iter().map(|r| ball(4.0 * r)).collect();
        let particles = with_columns(positions.clone(), vec![Column::new("radius", 1, radii)]);
        for kernel in Kernel::ALL {
            let settings = BlobSettings {
                kernel,
                ..BlobSettings::default()
            };
            let field = build(&particles, &settings).field;
            assert_close(
                &field.weights,
                &volume_weights(&positions, &metrics, kernel),
            );
        }
    }
}

#[test]
fn volume_weights_follow_the_definition_for_ellipsoids() {
    let (particles, metrics) = ellipsoids(700);
    let settings = BlobSettings {
        kernel: Kernel::Wyvill,
        ..BlobSettings::default()
    };
    let field = build(&particles, &settings).field;
    let expected = volume_weights(&particles.positions, &metrics, Kernel::Wyvill);
    assert_close(&field.weights, &expected);
}

/// Slanted ellipsoids, up to 10:1.
fn ellipsoids(count: usize) -> (Particles, Vec<Metric>) {
    let mut next = random(9);
    let mut vector = || DVec3::new(next(), next(), next());
    let mut positions = Vec::new();
    let mut metrics = Vec::new();
    for _ in 0..count {
        positions.push(vector() * 6.0);
        let axis = (vector() - 0.5).normalize();
        let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        metrics.push(DMat3::IDENTITY * (0.3 + vector().x) + outer * (30.0 * vector().x));
    }
    let six = |m: &DMat3| {
        [
            m.x_axis.x, m.x_axis.y, m.x_axis.z, m.y_axis.y, m.y_axis.z, m.z_axis.z,
        ]
    };
    let data: Vec<f64> = metrics.iter().flat_map(six).collect();
    let particles = with_columns(positions, vec![Column::new("metric", 6, data)]);
    (particles, metrics)
}

#[test]
fn a_lone_particle_weighs_one_and_the_bulk_has_field_one() {
    let one = Particles::from_positions(vec![DVec3::splat(7.0)]);
    let settings = BlobSettings {
        radius: Some(0.5),
        ..BlobSettings::default()
    };
    assert_eq!(build(&one, &settings).field.weights, [1.0]);

    let field = build(&Particles::from_positions(pool(12)), &settings).field;
    let mut next = random(2);
    for _ in 0..200 {
        let point = DVec3::splat(4.0) + DVec3::new(next(), next(), next()) * 4.0 - field.origin;
        assert!(
            (field.value(point) - 1.0).abs() < 0.1,
            "{}",
            field.value(point)
        );
    }
}

#[test]
fn weights_do_not_depend_on_the_number_of_threads() {
    let (mut particles, _) = ellipsoids(3000);
    let with = |particles: &Particles, threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| build(particles, &BlobSettings::default()).field)
    };
    assert!(with(&particles, 1) == with(&particles, 5));
    particles.columns.clear();
    assert!(with(&particles, 1) == with(&particles, 5));
}

/// F by summing over every blob.
fn value_of_all(field: &BlobField, local: DVec3) -> f64 {
    (0..field.len())
        .map(|i| {
            let q = field.shapes.q(i, local - field.center(i).as_dvec3());
            f64::from(field.weights[i]) * field.kernel.value(q)
        })
        .sum()
}

pub(super) fn fields() -> Vec<BlobField> {
    let mut next = random(8);
    let signs: Vec<f64> = (0..512).map(|_| next() - 0.3).collect();
    let radii: Vec<f64> = (0..512).map(|_| (-12.0 * next()).exp2()).collect();
    let signed = with_columns(
        pool(8),
        vec![Column::new("s", 1, signs), Column::new("radius", 1, radii)],
    );
    let (anisotropic, _) = ellipsoids(400);
    Kernel::ALL
        .into_iter()
        .flat_map(|kernel| {
            let weights = Weights::Column("s".into());
            let signs = BlobSettings {
                weights,
                ..unit(kernel, 0.4)
            };
            let volume = BlobSettings {
                kernel,
                ..BlobSettings::default()
            };
            [
                build(&signed, &signs).field,
                build(&anisotropic, &volume).field,
            ]
        })
        .collect()
}

#[test]
fn values_and_sides_are_those_of_the_sum_over_all_blobs() {
    let mut inside = 0;
    for field in fields() {
        let mut next = random(4);
        let bounds = field.bounds();
        for i in 0..300 {
            let at = DVec3::new(next(), next(), next());
            // Anywhere in the bounds, and near a blob.
            let point = if i % 2 == 0 {
                bounds.min.as_dvec3() + bounds.size().as_dvec3() * at
            } else {
                let half = DVec3::from_array(field.shapes.half_extents(i).map(f64::from));
                field.center(i).as_dvec3() + half * (at - 0.5)
            };
            let expected = value_of_all(&field, point);
            let value = field.value(point);
            assert!((value - expected).abs() < 1e-12, "{value} for {expected}");
            let side = field.side(point);
            assert_eq!(side == Side::Inside, value > f64::from(field.threshold));
            inside += usize::from(side == Side::Inside);
        }
        assert_eq!(field.value(bounds.max.as_dvec3() + 1.0), 0.0);
        assert_eq!(field.side(bounds.max.as_dvec3() + 1.0), Side::Outside);
    }
    assert!(inside > 100);
}

#[test]
fn contributions_sum_to_the_value_and_the_strongest_leads_them() {
    let mut parts = Vec::new();
    for field in fields() {
        for i in (0..field.len()).step_by(17) {
            let point = field.center(i).as_dvec3() + 0.01;
            field.contributions(point, &mut parts);
            let sum: f64 = parts.iter().map(|part| part.weight).sum();
            assert!((sum - field.value(point)).abs() < 1e-12);
            let largest = parts
                .iter()
                .map(|part| part.weight.abs())
                .fold(0.0, f64::max);
            match field.strongest(point) {
                None => assert!(parts.is_empty()),
                Some(blob) => {
                    let part = parts.iter().find(|part| part.blob == blob).unwrap();
                    assert_eq!(part.weight.abs(), largest);
                }
            }
        }
        assert_eq!(field.strongest(DVec3::splat(1e9)), None);
    }
}

#[test]
fn attributes_are_blended_by_field_weight() {
    let nan = f64::NAN;
    let particles = with_columns(
        vec![DVec3::ZERO, DVec3::X, DVec3::X * 0.5],
        vec![
            Column::new("heat", 1, vec![10.0_f64, 20.0, nan]),
            Column::new(
                "velocity",
                3,
                vec![1.0_f32, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0],
            ),
            Column::new("w", 1, vec![1.0_f64, -1.0, 0.5]),
        ],
    );
    let attributes = vec!["heat".into(), "velocity".into(), "|velocity|".into()];
    let settings = BlobSettings {
        support: Some(2.0),
        attributes,
        ..unit(Kernel::Quartic, 0.5)
    };
    let field = build(&particles, &settings).field;
    let point = DVec3::new(0.25, 0.0, 0.0) - field.origin;
    let k = |x: f64| Kernel::Quartic.value((x - 0.25) * (x - 0.25) / 4.0);
    let (a, b, c) = (k(0.0), k(1.0), k(0.5));
    // What is not finite takes no part.
    let heat = (10.0 * a + 20.0 * b) / (a + b);
    assert!((field.attribute(0, point)[0] - heat).abs() < 1e-6);
    let velocity = [a, 2.0 * b, 4.0 * c].map(|v| v / (a + b + c));
    for (found, expected) in field.attribute(1, point).iter().zip(velocity) {
        assert!((found - expected).abs() < 1e-6);
    }
    let speed = (a + 2.0 * b + 4.0 * c) / (a + b + c);
    assert!((field.attribute(2, point)[0] - speed).abs() < 1e-6);
    assert_eq!(field.attribute(0, DVec3::splat(50.0)), [0.0]);
}

#[test]
fn blends_with_negative_weights_overshoot_and_survive_cancellation() {
    let particles = with_columns(
        vec![DVec3::ZERO, DVec3::X],
        vec![
            Column::new("heat", 1, vec![10.0_f64, 20.0]),
            Column::new("w", 1, vec![1.0_f64, -1.0]),
        ],
    );
    let settings = BlobSettings {
        support: Some(2.0),
        attributes: vec!["heat".into()],
        weights: Weights::Column("w".into()),
        ..unit(Kernel::Quartic, 0.5)
    };
    let field = build(&particles, &settings).field;
    let blend = |weights: [f64; 2]| {
        let parts = [0, 1].map(|blob| Contribution {
            blob,
            weight: weights[blob as usize],
        });
        let mut blend = [0.0];
        field.blend(0, &parts, &mut blend);
        blend[0]
    };
    assert_eq!(blend([3.0, 1.0]), 12.5);
    assert_eq!(blend([3.0, -1.0]), 5.0);
    assert_eq!(blend([1.0, -1.0]), 15.0);
    assert_eq!(blend([0.0, 0.0]), 0.0);
    let middle = DVec3::X * 0.5 - field.origin;
    assert!((field.attribute(0, middle)[0] - 15.0).abs() < 1e-6);
}
