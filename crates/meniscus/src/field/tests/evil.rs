//! Sets of particles that break careless code.

use super::{build, pool, random, unit, with_columns};
use crate::field::{BlobField, FieldError};
use crate::kernel::Kernel;
use crate::math::ray::Side;
use crate::particles::{Column, Particles};
use crate::scene::surface::{BlobSettings, Weights};
use glam::DVec3;

#[test]
fn no_particle_at_all_is_an_error() {
    let error = BlobField::from_particles(&Particles::default(), &BlobSettings::default());
    assert!(matches!(error, Err(FieldError::Empty { total: 0, .. })));
}

#[test]
fn one_particle_needs_a_radius() {
    let one = Particles::from_positions(vec![DVec3::splat(1e6)]);
    let error = BlobField::from_particles(&one, &BlobSettings::default()).unwrap_err();
    assert_eq!(error, FieldError::NoRadius);
    let settings = BlobSettings {
        radius: Some(1e-3),
        ..BlobSettings::default()
    };
    let field = build(&one, &settings).field;
    assert_eq!(field.origin, DVec3::splat(1e6));
    assert_eq!(field.centers, [[0.0; 3]]);
    assert!(field.spacing > 0.0);
}

#[test]
fn two_particles_have_a_spacing() {
    let two = Particles::from_positions(vec![DVec3::ZERO, DVec3::Y * 3.0]);
    let build = build(&two, &BlobSettings::default());
    assert_eq!(build.report.spacing, Some(3.0));
    assert_eq!(build.report.support_max, 6.0);
    assert_eq!(build.field.weights[0], build.field.weights[1]);
}

#[test]
fn particles_at_one_point_share_their_volume() {
    let heap = Particles::from_positions(vec![DVec3::new(5.0, 6.0, 7.0); 40_000]);
    let settings = BlobSettings {
        support: Some(0.25),
        ..BlobSettings::default()
    };
    let build = build(&heap, &settings);
    assert_eq!(build.report.spacing, None);
    assert!(
        build
            .field
            .weights
            .iter()
            .all(|&w| (f64::from(w) * 40_000.0 - 1.0).abs() < 1e-6)
    );
    assert!(
        (build
            .field
            .value(DVec3::new(5.0, 6.0, 7.0) - build.field.origin)
            - 1.0)
            .abs()
            < 1e-6
    );
}

#[test]
fn collinear_particles_have_equal_weights_in_the_middle() {
    let line: Vec<DVec3> = (0..1000)
        .map(|i| DVec3::new(1.0, 2.0, 3.0) * f64::from(i))
        .collect();
    let build = build(&Particles::from_positions(line), &BlobSettings::default());
    let weights = &build.field.weights[10..990];
    assert!(weights.iter().all(|w| (w - weights[0]).abs() < 1e-6));
}

#[test]
fn radii_a_million_fold_apart_stay_cheap_and_right() {
    let mut next = random(12);
    let mut positions = vec![DVec3::splat(0.5)];
    positions.extend((0..50_000).map(|_| DVec3::new(next(), next(), next())));
    let mut radii = vec![1.0e-6_f64; positions.len()];
    radii[0] = 1.0;
    let particles = with_columns(positions, vec![Column::new("radius", 1, radii)]);
    let field = build(&particles, &unit(Kernel::Sextic, 0.5)).field;
    let mut tested = 0;
    for i in (1..field.len()).step_by(50) {
        let mut blobs = Vec::new();
        field.for_each_blob_at(field.center(i).as_dvec3(), |blob, _, _| blobs.push(blob));
        assert!(blobs.contains(&0) && blobs.contains(&i));
        tested += blobs.len();
    }
    assert!(tested < 2200, "{tested} blobs at 1000 points");
    // Volume: the large one surrounds small ones that count for nothing beside it.
    let volume = build(&particles, &BlobSettings::default()).field;
    assert!(volume.weights.iter().all(|w| w.is_finite() && *w > 0.0));
}

#[test]
fn far_from_the_origin_the_field_keeps_its_precision() {
    let far = DVec3::new(1e6, -1e6, 1e6);
    let near: Vec<DVec3> = pool(8).iter().map(|p| *p * 1e-3).collect();
    let moved: Vec<DVec3> = near.iter().map(|p| *p + far).collect();
    let here = build(
        &Particles::from_positions(near.clone()),
        &BlobSettings::default(),
    );
    let there = build(&Particles::from_positions(moved), &BlobSettings::default());
    assert!(there.report.warnings.iter().all(|w| !w.contains("rounded")));
    for point in near.iter().step_by(7) {
        let a = here.field.value(*point + 1e-4 - here.field.origin);
        let b = there.field.value(*point + far + 1e-4 - there.field.origin);
        // Coordinates of 1e6 carry 1e-10 in f64, which is 1e-7 spacings.
        assert!((a - b).abs() < 1e-5, "{a} and {b}");
    }
}

#[test]
fn a_stray_particle_does_not_cost_the_others_their_precision() {
    let mut positions = pool(10);
    positions.push(DVec3::new(3e9, 0.0, 0.0));
    let build = build(
        &Particles::from_positions(positions),
        &BlobSettings::default(),
    );
    assert!(build.field.origin.length() < 20.0, "{}", build.field.origin);
    assert!(build.report.warnings.iter().any(|w| w.contains("rounded")));
}

#[test]
fn negative_weights_cut_and_a_column_of_nan_leaves_nothing() {
    let particles = with_columns(
        vec![DVec3::ZERO, DVec3::X * 0.3],
        vec![
            Column::new("radius", 1, vec![1.0_f64, 0.5]),
            Column::new("sign", 1, vec![1.0_f64, -2.0]),
            Column::new("nan", 1, vec![f64::NAN; 2]),
        ],
    );
    let by = |name: &str| BlobSettings {
        weights: Weights::Column(name.into()),
        ..unit(Kernel::Quartic, 0.2)
    };
    let field = build(&particles, &by("sign")).field;
    assert_eq!(field.side(DVec3::X * 0.3 - field.origin), Side::Outside);
    assert_eq!(field.side(DVec3::X * -0.5 - field.origin), Side::Inside);
    let error = BlobField::from_particles(&particles, &by("nan")).unwrap_err();
    assert!(error.to_string().contains("2 particles"), "{error}");
}

#[test]
fn a_threshold_above_the_maximum_has_no_inside() {
    let particles = Particles::from_positions(pool(6));
    let settings = BlobSettings {
        threshold: 1e6,
        ..BlobSettings::default()
    };
    let field = build(&particles, &settings).field;
    for i in 0..field.len() {
        assert_eq!(field.side(field.center(i).as_dvec3()), Side::Outside);
    }
}
