//! Sets of ellipsoids that turn and stretch while the shutter is open, and what they are at one time.

use crate::corpus::Scene;
use crate::random::Stream;
use glam::{DMat3, DVec3};
use meniscus::field::{BlobField, Motion, Search};
use meniscus::primitive::{Ellipsoid, Shapes};

/// When the shutter opens and closes.
pub const SHUTTER_SECS: [f64; 2] = [-0.3, 0.7];

/// `scene` with blobs that move by about half a spacing, spin and stretch; `turn` is |L| times the
/// longest time, at most.
pub fn turning(scene: &Scene, turn: f64) -> Scene {
    let field = &scene.field;
    let numbers = |salt: u64, i: usize| {
        let mut random = Stream::new(71 + salt, i as u64);
        [(); 9].map(|()| random.unit() - 0.5)
    };
    let speed = 0.5 * f64::from(field.spacing);
    let rate = |salt: u64, i: usize| {
        let [x, y, z, ..] = numbers(salt, i).map(|number| (number * speed) as f32);
        [x, y, z]
    };
    let gradient = |i: usize| {
        let numbers = numbers(2, i);
        let size = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
        numbers.map(|x| (x / size * turn / SHUTTER_SECS[1]) as f32)
    };
    let motion = Motion {
        velocities: (0..field.len()).map(|i| rate(0, i)).collect(),
        half_accelerations: (0..field.len()).map(|i| rate(1, i)).collect(),
        velocity_gradients: (0..field.len()).map(gradient).collect(),
        shutter: SHUTTER_SECS,
    };
    Scene {
        name: format!("{} turning {turn}", scene.name),
        field: BlobField {
            motion: Some(motion),
            search: Search::default(),
            ..field.clone()
        },
    }
}

/// The still scene that a turning one is at a time.
///
/// # Panics
/// If nothing turns in it.
pub fn frozen(scene: &Scene, time: f64) -> Scene {
    let field = &scene.field;
    let (Some(motion), Shapes::Ellipsoids(factors)) = (&field.motion, &field.shapes) else {
        panic!("nothing turns in {}", scene.name);
    };
    let place = |i: usize| {
        let [p, v, a] = [
            field.centers[i],
            motion.velocities[i],
            motion.half_accelerations[i],
        ]
        .map(|x| DVec3::from_array(x.map(f64::from)));
        (p + v * time + a * (time * time)).as_vec3().to_array()
    };
    let shape = |i: usize| {
        let rows = motion.velocity_gradients[i].map(f64::from);
        let x = DMat3::from_cols_array(&rows).transpose() * time;
        let factor = factors[i].matrix() * (DMat3::IDENTITY - x + x * x * 0.5);
        Ellipsoid::from_metric(factor.transpose() * factor).expect("it is far from flat")
    };
    Scene {
        name: scene.name.clone(),
        field: BlobField {
            centers: (0..field.len()).map(place).collect(),
            shapes: Shapes::Ellipsoids((0..field.len()).map(shape).collect()),
            motion: None,
            search: Search::default(),
            ..field.clone()
        },
    }
}
