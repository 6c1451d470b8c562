//! Ellipsoids that turn and stretch while the shutter is open, judged by the oracle on the field as it
//! stands at the time of each ray.

use glam::{DMat3, DVec3};
use meniscus::accel::Engine;
use meniscus::field::{BlobField, MOST_TURN, Motion, Search};
use meniscus::frame::Blobs;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::primitive::{Ellipsoid, Shapes};
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::Question;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::random::Stream;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints, levels};

const SHUTTER_SECS: [f64; 2] = [-0.3, 0.7];

/// `scene` with blobs that move by about half a spacing, spin and stretch; `turn` is |L| times the
/// longest time, at most.
fn turning(scene: &Scene, turn: f64) -> Scene {
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
fn frozen(scene: &Scene, time: f64) -> Scene {
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
        Ellipsoid::from_metric(factor.transpose() * factor).unwrap()
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

#[test]
fn turning_ellipsoids_are_what_they_are_at_the_ray_s_time() {
    let mut problems = Vec::new();
    let mut traced = 0;
    for (n, kind) in ["ellipsoids", "tangent"].into_iter().enumerate() {
        for (m, turn) in [0.05, 0.4, 0.99 * MOST_TURN].into_iter().enumerate() {
            let kernel = Kernel::ALL[(2 * n + m) % Kernel::ALL.len()];
            let scene = turning(&corpus::scene(kind, kernel, 300), turn);
            let mut structures = Vec::new();
            for engine in [
                Engine::Cells,
                Engine::Particles,
                Engine::Interval,
                Engine::FittedBvh,
                Engine::Sweep,
            ] {
                for level in levels() {
                    let blobs = Blobs::build(scene.field.clone(), engine, level);
                    structures.push((format!("{engine:?} {level:?}"), blobs));
                }
            }
            for time in [SHUTTER_SECS[0], 0.0, 0.23, SHUTTER_SECS[1]] {
                let frozen = frozen(&scene, time);
                let oracle = Oracle::new(&frozen.field);
                let stage = Stage::new(&frozen, &oracle, 60);
                let mut all = rays::hemisphere(&stage.points, 3);
                all.extend(rays::grazing(&oracle, &stage.points, 4));
                all.extend(rays::inside(&oracle, &stage.points, 5));
                all.extend(rays::primary(&oracle, 14, DVec3::new(0.3, 0.5, 1.0)));
                let all: Vec<Ray> = all.into_iter().map(|ray| Ray { time, ..ray }).collect();
                for (name, blobs) in &structures {
                    for question in [Question::Closest, Question::Any] {
                        traced += all.len();
                        let complaint = complaints(blobs, &stage, &all, question);
                        problems.extend(complaint.map(|text| format!("{name} at {time}: {text}")));
                    }
                }
            }
        }
    }
    assert!(traced > 100_000, "only {traced} rays");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn cells_hand_on_what_turns() {
    let scene = corpus::scene("ellipsoids", Kernel::Sextic, 300);
    let level = levels()[0];
    let engine_of = |field: &BlobField| {
        let blobs = Blobs::build(field.clone(), Engine::Cells, level);
        blobs.accel.engine()
    };
    assert_eq!(engine_of(&scene.field), Engine::Cells);
    assert_eq!(engine_of(&turning(&scene, 0.1).field), Engine::Particles);
}
