//! Shapes that make no ellipsoid, and settings that contradict each other.

use super::*;

#[test]
fn crushed_and_indefinite_ones_are_lengthened_and_named() {
    // Crushed to a disc; inside out, which is no matter; as it was.
    let gradients = [
        DMat3::from_diagonal(DVec3::new(2.0, 1.0, 0.0)),
        DMat3::from_diagonal(DVec3::new(1.0, -0.5, 1.0)),
        DMat3::IDENTITY,
    ];
    let column = Column::new("F", 9, numbers(&gradients, |m| row_by_row(*m)));
    let unit = BlobSettings {
        support: Some(1.0),
        ..settings()
    };
    let built = of(vec![column], &unit).unwrap();
    let expected = [
        DMat3::from_diagonal(DVec3::new(2.0, 1.0, 0.2)),
        DMat3::from_diagonal(DVec3::new(1.0, 0.5, 1.0)),
        DMat3::IDENTITY,
    ];
    assert!(error(&built.field, &expected, &mut Random(2)) < 3e-6);
    let warnings = &built.report.warnings;
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[1].contains("axes of 1 ellipsoids"), "{warnings:?}");
    assert!(warnings[1].contains("row 0"), "{warnings:?}");

    let displacements = vec![0.2, 0.2, -0.01, 0.0, 0.0, 0.0, 0.1, 0.1, 0.1, 0.0, 0.0, 0.0];
    let column = Column::new("anisou", 6, displacements);
    let thermal = BlobSettings {
        anisotropy: Anisotropy::Thermal,
        ..settings()
    };
    let built = of(vec![column], &thermal).unwrap();
    let radius = radius_of_probability(0.5) * 0.2_f64.sqrt() / KERNEL_Q.sqrt();
    let flat = DMat3::from_diagonal(DVec3::new(radius, radius, 0.1 * radius));
    let round = DMat3::IDENTITY * (radius * 0.5_f64.sqrt());
    assert!(error(&built.field, &[flat, round], &mut Random(2)) < 3e-6);
    assert!(built.report.warnings[1].contains("row 0"));
}

#[test]
fn what_makes_no_ellipsoid_is_dropped_and_named() {
    let good = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let mut nan = good;
    nan[5] = f64::NAN;
    let mut infinite = good;
    infinite[0] = f64::INFINITY;
    let flat = [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let bad = [nan, infinite, [0.0; 9], [1e-320; 9], [1e300; 9]];
    let cut = |list: &[[f64; 9]], n: usize| {
        list.iter()
            .flat_map(|v| v[..n].to_vec())
            .collect::<Vec<_>>()
    };
    let with_radii = |name: &str, n: usize, bad: &[[f64; 9]]| {
        let list: Vec<[f64; 9]> = [&[good], bad].concat();
        let radii = vec![1.0; 3 * list.len()];
        vec![
            Column::new(name, n, cut(&list, n)),
            Column::new("radii", 3, radii),
        ]
    };
    let alone = |name: &str, n: usize, bad: &[[f64; 9]]| {
        vec![Column::new(name, n, cut(&[&[good], bad].concat(), n))]
    };
    let default = BlobSettings {
        support: Some(1.0),
        ..settings()
    };
    let thermal = BlobSettings {
        anisotropy: Anisotropy::Thermal,
        ..settings()
    };
    let named = |what: &str| {
        let mut settings = settings();
        match what {
            "metric" => settings.metric = Some("c".into()),
            "radii" => settings.radii = Some("c".into()),
            "axes" => settings.axes = Some("c".into()),
            _ => settings.orientation = Some("c".into()),
        }
        settings
    };
    let all = [&bad[..], &[flat]].concat();
    let radii: Vec<[f64; 9]> = [[-1.0, 1.0], [f64::NAN, 1.0], [0.0, 1.0], [1e300, 1.0]]
        .map(|[a, b]| [a, b, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        .to_vec();
    let identity = [1.0; 9];
    let radii_columns = vec![Column::new(
        "c",
        3,
        cut(&[&[identity], &radii[..]].concat(), 3),
    )];
    let cases = [
        (alone("F", 9, &bad), default, bad.len()),
        (alone("c", 9, &bad), named("metric"), bad.len()),
        (alone("c", 9, &all), named("axes"), all.len()),
        (with_radii("c", 9, &all[..4]), named("axes"), 4),
        (
            with_radii("c", 4, &[[0.0; 9], infinite]),
            named("orientation"),
            2,
        ),
        (radii_columns, named("radii"), radii.len()),
        (
            alone(
                "anisou",
                6,
                &[[-1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0; 9]],
            ),
            thermal,
            2,
        ),
    ];
    for (columns, settings, count) in cases {
        let name = columns[0].name.clone();
        let built = of(columns, &settings).unwrap();
        assert_eq!(built.field.rows, [0], "{name} {settings:?}");
        assert_eq!(built.report.dropped, count, "{name}");
        let warning = &built.report.warnings[0];
        assert!(warning.contains("row 1"), "{name}: {warning}");
    }
}

#[test]
fn settings_that_contradict_each_other() {
    let column = || vec![Column::new("F", 9, vec![1.0; 9])];
    let name = || Some("F".to_owned());
    let cases = [
        (
            BlobSettings {
                metric: name(),
                axes: name(),
                ..settings()
            },
            "--metric and --axes",
        ),
        (
            BlobSettings {
                deformation: name(),
                radii: name(),
                ..settings()
            },
            "--deformation",
        ),
        (
            BlobSettings {
                axes: name(),
                radius: Some(1.0),
                ..settings()
            },
            "--radius",
        ),
        (
            BlobSettings {
                deformation: name(),
                anisotropy: Anisotropy::Estimate,
                ..settings()
            },
            "--anisotropy estimate",
        ),
        (
            BlobSettings {
                orientation: name(),
                ..settings()
            },
            "9 components",
        ),
        (
            BlobSettings {
                orientation: Some("F.0,F.1,F.2,F.3".into()),
                ..settings()
            },
            "--radii",
        ),
        (
            BlobSettings {
                radii: Some("F,F".into()),
                ..settings()
            },
            "18 components",
        ),
        (
            BlobSettings {
                axes: Some("F.0,G".into()),
                ..settings()
            },
            "`G`",
        ),
        (
            BlobSettings {
                anisotropy: Anisotropy::Thermal,
                ..settings()
            },
            "anisou",
        ),
        (
            BlobSettings {
                probability: 1.0,
                ..settings()
            },
            "probability",
        ),
    ];
    for (settings, expected) in cases {
        let error = of(column(), &settings).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
