//! The conventions: supports, weights, what is dropped and what is said about it.

mod derivatives;
mod evaluation;
mod evil;
mod rates;

use super::{BlobField, FieldBuild, FieldError, MetricOrder, SupportSource};
use crate::kernel::Kernel;
use crate::particles::{Column, Particles};
use crate::primitive::Shapes;
use crate::scene::surface::{BlobSettings, Weights};
use glam::DVec3;

/// A repeatable sequence of numbers in [0, 1).
pub(super) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Points on a jittered lattice of spacing 1, `side` to an edge.
pub(super) fn pool(side: usize) -> Vec<DVec3> {
    let mut next = random(5);
    (0..side.pow(3))
        .map(|i| {
            let cell = [i % side, i / side % side, i / side / side];
            DVec3::from_array(cell.map(|c| c as f64 + 0.3 * next()))
        })
        .collect()
}

pub(super) fn with_columns(positions: Vec<DVec3>, columns: Vec<Column>) -> Particles {
    Particles {
        columns,
        ..Particles::from_positions(positions)
    }
}

pub(super) fn build(particles: &Particles, settings: &BlobSettings) -> FieldBuild {
    BlobField::from_particles(particles, settings).unwrap()
}

fn radii(field: &BlobField) -> &[f32] {
    match &field.shapes {
        Shapes::Balls(radii) => radii,
        Shapes::Ellipsoids(_) => panic!("balls expected"),
    }
}

fn unit(kernel: Kernel, threshold: f64) -> BlobSettings {
    BlobSettings {
        kernel,
        threshold,
        weights: Weights::Unit,
        ..BlobSettings::default()
    }
}

#[test]
fn volume_weights_reach_four_radii() {
    let particles = with_columns(pool(3), vec![Column::new("pscale", 1, vec![0.5_f32; 27])]);
    let FieldBuild { field, report } = build(&particles, &BlobSettings::default());
    assert!(radii(&field).iter().all(|&r| r == 2.0));
    assert_eq!(
        report.support_source,
        SupportSource::Column("pscale".into())
    );
    assert_eq!((report.support_min, report.support_max), (2.0, 2.0));
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let smoother = BlobSettings {
        smoothing: 3.0,
        radius: Some(0.25),
        ..BlobSettings::default()
    };
    assert_eq!(radii(&build(&particles, &smoother).field)[0], 0.75);
}

#[test]
fn with_unit_weights_the_radius_is_the_surface_of_a_lone_particle() {
    for kernel in Kernel::ALL {
        for threshold in [0.05, 0.2, 0.6, 0.95] {
            let particles = Particles::from_positions(vec![DVec3::new(1e3, 2.0, 3.0)]);
            let settings = BlobSettings {
                radius: Some(0.7),
                ..unit(kernel, threshold)
            };
            let field = build(&particles, &settings).field;
            let value = field.value(DVec3::new(1e3 + 0.7, 2.0, 3.0) - field.origin);
            assert!(
                (value - threshold).abs() < 1e-6,
                "{kernel:?} {threshold} {value}"
            );
        }
    }
}

#[test]
fn support_overrides_radii_and_column_weights_do_not_change_it() {
    let particles = with_columns(
        pool(2),
        vec![
            Column::new("radius", 1, vec![0.5_f64; 8]),
            Column::new("mass", 1, vec![-3.0_f64, 1.0, 2.0, 5.0, 1.0, 1.0, 1.0, 1.0]),
        ],
    );
    let settings = BlobSettings {
        support: Some(1.25),
        ..unit(Kernel::Quartic, 3.0)
    };
    let FieldBuild { field, report } = build(&particles, &settings);
    assert!(radii(&field).iter().all(|&r| r == 1.25));
    assert_eq!(report.support_source, SupportSource::Support);
    assert!(field.weights.iter().all(|&w| w == 1.0));

    let by_mass = BlobSettings {
        weights: Weights::Column("mass".into()),
        ..unit(Kernel::Quartic, 0.25)
    };
    let field = build(&particles, &by_mass).field;
    assert_eq!(field.weights[..4], [-3.0, 1.0, 2.0, 5.0]);
    let expected = 0.5 / 0.5_f64.sqrt();
    assert!(radii(&field).iter().all(|&r| r == expected as f32));
    assert!(field.has_negative_weights());
}

#[test]
fn a_file_without_radii_gets_half_its_spacing_and_is_told() {
    let positions: Vec<DVec3> = (0..5).map(|i| DVec3::X * f64::from(i) * 0.5).collect();
    let mut positions = positions;
    positions.push(DVec3::splat(100.0));
    let particles = Particles::from_positions(positions);
    let FieldBuild { field, report } = build(&particles, &BlobSettings::default());
    assert_eq!(report.support_source, SupportSource::Estimate);
    assert_eq!(report.spacing, Some(0.5));
    assert_eq!(field.spacing, 0.5);
    assert!(radii(&field).iter().all(|&r| r == 1.0));
    assert!(
        report.warnings[0].contains("no radius"),
        "{:?}",
        report.warnings
    );
    // Of the particles that the filter keeps, not of all.
    let filtered = BlobSettings {
        filter: Some("x == 0 || x == 2 || y > 5".into()),
        ..BlobSettings::default()
    };
    let FieldBuild { field, report } = build(&particles, &filtered);
    assert_eq!((report.filtered, report.spacing), (3, Some(2.0)));
    assert_eq!(field.rows, [0, 4, 5]);
}

#[test]
fn settings_that_contradict_each_other_are_errors() {
    let particles = Particles::from_positions(pool(2));
    let message = |settings: BlobSettings| {
        BlobField::from_particles(&particles, &settings)
            .unwrap_err()
            .to_string()
    };
    let default = BlobSettings::default;
    for (settings, words) in [
        (
            BlobSettings {
                radius: Some(1.0),
                support: Some(1.0),
                ..default()
            },
            "--radius and --support",
        ),
        (
            BlobSettings {
                radius: Some(1.0),
                ..unit(Kernel::Sextic, 1.0)
            },
            "--support",
        ),
        (unit(Kernel::Wyvill, 2.0), "--support"),
        (
            BlobSettings {
                weights: Weights::Column("mass".into()),
                ..unit(Kernel::Sextic, 1.5)
            },
            "--support",
        ),
        (
            BlobSettings {
                threshold: 0.0,
                ..default()
            },
            "threshold",
        ),
        (
            BlobSettings {
                threshold: f64::NAN,
                ..default()
            },
            "threshold",
        ),
        (
            BlobSettings {
                radius: Some(-1.0),
                ..default()
            },
            "radius",
        ),
        (
            BlobSettings {
                support: Some(0.0),
                ..default()
            },
            "support",
        ),
        (
            BlobSettings {
                support: Some(1e30),
                ..default()
            },
            "support",
        ),
        (
            BlobSettings {
                smoothing: f64::INFINITY,
                ..default()
            },
            "smoothing",
        ),
        (
            BlobSettings {
                weights: Weights::Column("mass".into()),
                ..default()
            },
            "`mass`",
        ),
        (
            BlobSettings {
                attributes: vec!["heat".into()],
                ..default()
            },
            "`heat`",
        ),
        (
            BlobSettings {
                metric: Some("G".into()),
                ..default()
            },
            "`G`",
        ),
        (
            BlobSettings {
                filter: Some("x >".into()),
                ..default()
            },
            "filter",
        ),
        (
            BlobSettings {
                filter: Some("x > 1e9".into()),
                ..default()
            },
            "the filter removed 8",
        ),
        (
            BlobSettings {
                weights: Weights::Column("position".into()),
                ..unit(Kernel::Sextic, 0.5)
            },
            "3 components",
        ),
    ] {
        let message = message(settings.clone());
        assert!(message.contains(words), "{settings:?}: {message}");
    }
    // Support and threshold above 1 go together.
    let high = BlobSettings {
        support: Some(2.0),
        ..unit(Kernel::Sextic, 1.5)
    };
    assert!(BlobField::from_particles(&particles, &high).is_ok());
}

#[test]
fn unusable_particles_are_dropped_with_count_and_row() {
    let nan = f64::NAN;
    let particles = with_columns(
        vec![
            DVec3::ZERO,
            DVec3::X * nan,
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            DVec3::splat(1e30),
        ],
        vec![
            Column::new("radius", 1, vec![1.0_f64, 1.0, 0.0, nan, 0.5, 1.0]),
            Column::new("w", 1, vec![1.0_f64, 1.0, 1.0, 1.0, 0.0, 1.0]),
        ],
    );
    let FieldBuild { field, report } = build(&particles, &BlobSettings::default());
    assert_eq!(field.rows, [0, 4]);
    assert_eq!((report.total, report.filtered, report.dropped), (6, 0, 4));
    assert!(
        report.warnings[0].contains("2 particles"),
        "{:?}",
        report.warnings
    );
    assert!(
        report.warnings[0].contains("row 1"),
        "{:?}",
        report.warnings
    );
    assert!(
        report.warnings[1].contains("row 2"),
        "{:?}",
        report.warnings
    );

    let weighted = BlobSettings {
        weights: Weights::Column("w".into()),
        ..unit(Kernel::Sextic, 0.5)
    };
    assert_eq!(build(&particles, &weighted).field.rows, [0]);
    let none = BlobSettings {
        filter: Some("x != 0 || radius != 1".into()),
        ..weighted
    };
    let error = BlobField::from_particles(&particles, &none).unwrap_err();
    assert!(
        matches!(error, FieldError::Empty { total: 6, .. }),
        "{error}"
    );
}

#[test]
fn metrics_are_read_in_either_order_or_in_full() {
    // M of a ball of radius 2 squeezed to 1 along a slanted axis.
    let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
    let m = |i: usize, j: usize| 0.25 * f64::from(u8::from(i == j)) + 0.75 * axis[i] * axis[j];
    let orders: [(&[(usize, usize)], MetricOrder); 3] = [
        (
            &[(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)],
            MetricOrder::UpperTriangle,
        ),
        (
            &[(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)],
            MetricOrder::Vtk,
        ),
        (
            &[
                (0, 0),
                (0, 1),
                (0, 2),
                (1, 0),
                (1, 1),
                (1, 2),
                (2, 0),
                (2, 1),
                (2, 2),
            ],
            MetricOrder::Full,
        ),
    ];
    // A ball in the same file: in the wrong order its diagonal would hold a zero.
    let ball = |i: usize, j: usize| f64::from(u8::from(i == j));
    for (places, order) in orders {
        let mut data: Vec<f64> = places.iter().map(|&(i, j)| m(i, j)).collect();
        data.extend(places.iter().map(|&(i, j)| ball(i, j)));
        let column = Column::new("metric", places.len(), data);
        let particles = with_columns(vec![DVec3::ZERO, DVec3::splat(9.0)], vec![column]);
        let settings = BlobSettings {
            attributes: vec!["metric".into()],
            ..unit(Kernel::Quartic, 0.2)
        };
        let FieldBuild { field, report } = build(&particles, &settings);
        let column = "metric".to_owned();
        assert_eq!(
            report.support_source,
            SupportSource::Metric { column, order }
        );
        for (direction, radius) in [(axis, 1.0), (axis.any_orthonormal_vector(), 2.0)] {
            let q = 0.36;
            let point = direction * radius * f64::sqrt(q) - field.origin;
            assert!((field.value(point) - Kernel::Quartic.value(q)).abs() < 1e-6);
        }
        assert!((report.support_max - 4.0_f64.cbrt()).abs() < 1e-6);
    }
}

#[test]
fn an_indefinite_metric_is_dropped_and_named() {
    let good = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
    let bad = [1.0, 2.0, 0.0, 1.0, 0.0, 1.0];
    let data = [good, bad, good].concat();
    let particles = with_columns(pool(2)[..3].to_vec(), vec![Column::new("T", 6, data)]);
    let named = BlobSettings {
        metric: Some("T".into()),
        ..BlobSettings::default()
    };
    let FieldBuild { field, report } = build(&particles, &named);
    assert_eq!(field.rows, [0, 2]);
    assert!(
        report.warnings[0].contains("not positive definite"),
        "{:?}",
        report.warnings
    );
    assert!(
        report.warnings[0].contains("row 1"),
        "{:?}",
        report.warnings
    );
    // Unnamed, a column of that name is no metric.
    assert!(matches!(
        build(&particles, &BlobSettings::default()).field.shapes,
        Shapes::Balls(_)
    ));
    let conflict = BlobSettings {
        radius: Some(1.0),
        ..named
    };
    assert!(BlobField::from_particles(&particles, &conflict).is_err());
}
