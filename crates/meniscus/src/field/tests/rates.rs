//! How columns say that shapes turn.

use crate::field::{BlobField, FieldBuild, MOST_TURN};
use crate::particles::{Column, Particles};
use crate::scene::BlobSettings;
use glam::DVec3;

const SHUTTER_SECS: [f64; 2] = [-0.1, 0.1];

fn built(columns: Vec<Column>) -> FieldBuild {
    let particles = Particles {
        columns,
        ..Particles::from_positions(vec![DVec3::ZERO, DVec3::X])
    };
    let settings = BlobSettings::default();
    BlobField::from_moving_particles(&particles, &settings, SHUTTER_SECS, 2.0).unwrap()
}

fn radii() -> Column {
    Column::new("radii", 3, vec![1.0, 0.5, 0.5, 1.0, 0.5, 0.5])
}

fn spin(turns: [f64; 2]) -> Column {
    Column::new("w", 3, vec![0.0, 0.0, turns[0], 0.0, turns[1], 0.0])
}

#[test]
fn angular_velocities_turn_ellipsoids_and_nothing_else() {
    let motion = built(vec![radii(), spin([1.0, 2.0])]).field.motion.unwrap();
    // Times the scale of velocities.
    let about_z = [0.0, -2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let about_y = [0.0, 0.0, 4.0, 0.0, 0.0, 0.0, -4.0, 0.0, 0.0];
    assert_eq!(motion.velocity_gradients, [about_z, about_y]);
    assert!(built(vec![spin([1.0, 2.0])]).field.motion.is_none());
    assert!(
        built(vec![radii(), spin([0.0, 0.0])])
            .field
            .motion
            .is_none()
    );
}

#[test]
fn a_velocity_gradient_goes_before_an_angular_velocity() {
    let gradient: Vec<f64> = (0..18).map(|k| 0.1 * f64::from(k)).collect();
    let columns = vec![radii(), spin([1.0, 2.0]), Column::new("C", 9, gradient)];
    let motion = built(columns).field.motion.unwrap();
    assert_eq!(motion.velocity_gradients[0][5], 1.0);
    assert_eq!(motion.velocity_gradients[1][0], 1.8);
}

#[test]
fn fast_turns_are_slowed_down_and_counted() {
    let FieldBuild { field, report } = built(vec![radii(), spin([1e6, 0.1])]);
    let motion = field.motion.unwrap();
    let turn = |i: usize| {
        let squares = motion.velocity_gradients[i].map(|rate| f64::from(rate).powi(2));
        squares.iter().sum::<f64>().sqrt() * SHUTTER_SECS[1]
    };
    assert!(
        turn(0) < MOST_TURN && turn(0) > 0.99 * MOST_TURN,
        "{}",
        turn(0)
    );
    assert!((turn(1) - 0.02 * 2.0_f64.sqrt()).abs() < 1e-6);
    let is_told = |text: &String| text.starts_with("1 shapes turn");
    assert!(report.warnings.iter().any(is_told), "{:?}", report.warnings);
    let not_finite = built(vec![radii(), spin([f64::NAN, 0.1])])
        .field
        .motion
        .unwrap();
    assert_eq!(not_finite.velocity_gradients[0], [0.0; 9]);
}
