mod refused;

use super::ellipsoid::radius_of_probability;
use crate::field::{BlobField, FieldBuild, FieldError, SupportSource};
use crate::particles::{Column, Particles};
use crate::primitive::Shapes;
use crate::scene::{Anisotropy, BlobSettings, Weights};
use glam::{DMat3, DQuat, DVec3};

/// Numbers between −1 and 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn turn(&mut self) -> DQuat {
        DQuat::from_xyzw(self.next(), self.next(), self.next(), self.next()).normalize()
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

const KERNEL_Q: f64 = 0.5527864045000421;

fn settings() -> BlobSettings {
    // A lone particle's surface is its radius: quartic, T = 0.2, so k⁻¹(T) = 1 − √0.2.
    BlobSettings::molecule()
}

fn of(columns: Vec<Column>, settings: &BlobSettings) -> Result<FieldBuild, FieldError> {
    let count = columns[0].rows();
    let places = (0..count).map(|i| DVec3::X * (100.0 * i as f64)).collect();
    let particles = Particles {
        columns,
        ..Particles::from_positions(places)
    };
    BlobField::from_particles(&particles, settings)
}

/// The largest relative error of q = 1 on the surfaces that the vectors `radii` of each blob span.
fn error(field: &BlobField, radii: &[DMat3], random: &mut Random) -> f64 {
    assert_eq!(field.len(), radii.len());
    let mut worst = 0.0_f64;
    for (i, radii) in radii.iter().enumerate() {
        for _ in 0..20 {
            let unit = random.vector().normalize();
            worst = worst.max((field.shapes.q(i, *radii * unit).sqrt() - 1.0).abs());
        }
    }
    worst
}

fn numbers(list: &[DMat3], of: impl Fn(&DMat3) -> Vec<f64>) -> Vec<f64> {
    list.iter().flat_map(of).collect()
}

fn row_by_row(m: DMat3) -> Vec<f64> {
    m.transpose().to_cols_array().to_vec()
}

/// Ellipsoids by their turns, radii and the images of the unit ball, axis ratios to 8.
fn ellipsoids(count: usize) -> Vec<(DQuat, DVec3, DMat3)> {
    let mut random = Random(7);
    let one = |_| {
        let turn = random.turn();
        let radii = DVec3::ONE + random.vector() * 0.77;
        (
            turn,
            radii,
            DMat3::from_quat(turn) * DMat3::from_diagonal(radii),
        )
    };
    (0..count).map(one).collect()
}

#[test]
fn every_source_says_the_same_shape() {
    let shapes = ellipsoids(60);
    let images: Vec<DMat3> = shapes.iter().map(|shape| shape.2).collect();
    // The ellipsoid that is seen, and the support that makes it.
    let supports: Vec<DMat3> = images
        .iter()
        .map(|m| *m * KERNEL_Q.sqrt().recip())
        .collect();
    let metric = |m: &DMat3| {
        let inverse = m.inverse();
        inverse.transpose() * inverse
    };
    let radii: Vec<f64> = shapes.iter().flat_map(|shape| shape.1.to_array()).collect();
    let turns = |places: [usize; 4]| -> Vec<f64> {
        let each = |shape: &(DQuat, DVec3, DMat3)| places.map(|place| shape.0.to_array()[place]);
        shapes.iter().flat_map(each).collect()
    };
    let directions: Vec<DMat3> = shapes.iter().map(|s| DMat3::from_quat(s.0)).collect();
    let columns = |m: &DMat3| m.to_cols_array().to_vec();
    let six = |m: DMat3, places: [(usize, usize); 6]| -> Vec<f64> {
        places.map(|(i, j)| m.col(j)[i]).to_vec()
    };
    let upper = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let crystal = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
    let sphere = radius_of_probability(0.5);
    let thermal = |m: &DMat3| six(*m * m.transpose() * sphere.powi(-2), crystal);
    let axis = |k: usize| {
        Column::new(["axis1", "axis2", "axis3"][k], 3, {
            numbers(&directions, |m| m.col(k).to_array().to_vec())
        })
    };
    let radii_column = || Column::new("radii", 3, radii.clone());
    let gradient = numbers(&images, |m| row_by_row(*m));
    let scalars: Vec<Column> = (0..9)
        .map(|k| {
            let each: Vec<f64> = gradient.iter().skip(k).step_by(9).copied().collect();
            Column::new(format!("F{}{}", k / 3, k % 3), 1, each)
        })
        .collect();
    let one = Some(1.0);
    let auto = settings();
    let f32s = |values: Vec<f64>| values.iter().map(|&v| v as f32).collect::<Vec<f32>>();
    let cases: Vec<(&str, Vec<Column>, BlobSettings)> = vec![
        (
            "six",
            vec![Column::new(
                "metric",
                6,
                numbers(&supports, |m| six(metric(m), upper)),
            )],
            auto.clone(),
        ),
        (
            "nine",
            vec![Column::new(
                "G9",
                9,
                numbers(&supports, |m| columns(&metric(m))),
            )],
            BlobSettings {
                metric: Some("G9".into()),
                ..auto.clone()
            },
        ),
        (
            "axes",
            vec![Column::new("axes", 9, numbers(&images, columns))],
            auto.clone(),
        ),
        (
            "axes + radii",
            vec![
                radii_column(),
                Column::new(
                    "principal_axes",
                    9,
                    numbers(&directions, |m| columns(&(*m * 3.0))),
                ),
            ],
            auto.clone(),
        ),
        (
            "three axes",
            vec![axis(0), axis(1), axis(2), radii_column()],
            auto.clone(),
        ),
        (
            "named axes",
            vec![axis(0), axis(1), axis(2), radii_column()],
            BlobSettings {
                axes: Some("axis1, axis2,axis3".into()),
                ..auto.clone()
            },
        ),
        (
            "xyzw",
            vec![
                Column::new("orient", 4, turns([0, 1, 2, 3])),
                radii_column(),
            ],
            auto.clone(),
        ),
        (
            "wxyz",
            vec![
                Column::new("quat_wxyz", 4, turns([3, 0, 1, 2])),
                radii_column(),
            ],
            auto.clone(),
        ),
        (
            "wxyz by name",
            vec![
                Column::new("quat_wxyz", 4, turns([3, 0, 1, 2])),
                radii_column(),
            ],
            BlobSettings {
                orientation: Some("quat_wxyz".into()),
                ..auto.clone()
            },
        ),
        (
            "wxyz in its own order",
            vec![
                Column::new("rot", 4, turns([3, 0, 1, 2])),
                Column::new("s", 3, radii.clone()),
            ],
            BlobSettings {
                orientation: Some("rot.1,rot.2,rot.3,rot.0".into()),
                radii: Some("s".into()),
                ..auto.clone()
            },
        ),
        (
            "F",
            vec![Column::new("F", 9, f32s(gradient.clone()))],
            BlobSettings {
                radius: one,
                ..auto.clone()
            },
        ),
        (
            "F00 to F22",
            scalars,
            BlobSettings {
                radius: one,
                ..auto.clone()
            },
        ),
        (
            "named F",
            vec![Column::new("dg", 9, gradient.clone())],
            BlobSettings {
                support: Some(KERNEL_Q.sqrt().recip()),
                deformation: Some("dg".into()),
                ..auto.clone()
            },
        ),
        (
            "thermal",
            vec![Column::new("anisou", 6, numbers(&images, thermal))],
            BlobSettings {
                anisotropy: Anisotropy::Thermal,
                ..auto
            },
        ),
    ];
    let mut random = Random(3);
    for (name, columns, settings) in cases {
        let built = of(columns, &settings).unwrap();
        assert_eq!(built.report.dropped, 0, "{name}");
        assert_eq!(built.report.warnings.len(), 1, "{name}: {:?}", built.report);
        let off = error(&built.field, &supports, &mut random);
        assert!(off < 3e-6, "{name}: off by {off}");
    }
}

#[test]
fn equal_radii_are_the_ball_of_that_radius() {
    for weights in [Weights::Unit, Weights::Volume] {
        let settings = BlobSettings {
            weights,
            ..settings()
        };
        let balls = of(vec![Column::new("radius", 1, vec![0.7, 1.3])], &settings).unwrap();
        let radii = vec![0.7, 0.7, 0.7, 1.3, 1.3, 1.3];
        let built = of(vec![Column::new("aspherical_shape", 3, radii)], &settings).unwrap();
        assert_eq!(
            built.report.support_source,
            SupportSource::Ellipsoids("aspherical_shape".into())
        );
        for i in 0..2 {
            let expected = balls.field.shapes.mean_radius(i);
            assert!((built.field.shapes.mean_radius(i) / expected - 1.0).abs() < 1e-6);
        }
        assert_eq!(built.field.weights, balls.field.weights);
    }
}

#[test]
fn a_gradient_stretches_each_particles_own_ball() {
    let f = DMat3::from_cols(
        DVec3::new(0.0, 2.0, 0.1),
        DVec3::new(-1.0, 0.3, 0.0),
        DVec3::Z * 0.6,
    );
    let columns = vec![
        Column::new("radius", 1, vec![0.5, 2.0]),
        Column::new("F", 9, [row_by_row(f), row_by_row(f)].concat()),
    ];
    let built = of(columns.clone(), &settings()).unwrap();
    let supports = [0.5, 2.0].map(|radius| f * (radius / KERNEL_Q.sqrt()));
    assert!(error(&built.field, &supports, &mut Random(1)) < 3e-6);
    assert_eq!(
        built.report.support_source,
        SupportSource::Column("radius".into())
    );
    let balls = BlobSettings {
        anisotropy: Anisotropy::None,
        ..settings()
    };
    assert!(matches!(
        of(columns, &balls).unwrap().field.shapes,
        Shapes::Balls(_)
    ));
}

#[test]
fn probabilities_are_those_of_the_crystallographers() {
    // ORTEP-III, ORNL-6895, table of the three-dimensional normal distribution.
    for (probability, radius) in [(0.5, 1.5382), (0.3, 1.1932), (0.9, 2.5003), (0.99, 3.3682)] {
        assert!(
            (radius_of_probability(probability) - radius).abs() < 6e-5,
            "{probability}"
        );
    }
    assert!(radius_of_probability(1.0 - f64::EPSILON) <= 10.0);
    assert!(radius_of_probability(f64::MIN_POSITIVE) >= 0.0);
}
