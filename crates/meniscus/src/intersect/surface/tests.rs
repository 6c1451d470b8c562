use super::*;
use crate::accel::Engine;
use crate::field::BlobField;
use crate::frame::{FrameSettings, Instance};
use crate::intersect::Scratch;
use crate::kernel::Kernel;
use crate::math::ray::Ray;
use crate::particles::{Column, Particles};
use crate::scene::{BlobSettings, Matrix, PlacementKey, Scene, Surface, Weights};
use glam::{DAffine3, DQuat};

const SHUTTER: [f64; 2] = [-0.5, 0.5];

/// A repeatable sequence of numbers in [−1, 1).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Particles with velocities and accelerations, traced in float64.
fn moving(particles: &Particles, settings: &BlobSettings) -> Frame {
    let built = BlobField::from_moving_particles(particles, settings, SHUTTER, 1.0).unwrap();
    let scene = Scene {
        surfaces: vec![Surface::from_file("")],
        ..Scene::default()
    };
    let engine = FrameSettings {
        engine: Engine::Sweep,
        ..FrameSettings::default()
    };
    Frame::build(&scene, vec![built.field], &engine).unwrap()
}

fn at(frame: &Frame, ray: &Ray, time: f64) -> Option<Hit> {
    let ray = Ray { time, ..*ray };
    frame.closest_hit(&ray, &mut Scratch::default())
}

#[test]
fn a_lone_ball_that_is_thrown_has_its_closed_forms() {
    for kernel in Kernel::ALL {
        let radius = 0.75;
        let settings = BlobSettings {
            radius: Some(radius),
            kernel,
            ..BlobSettings::molecule()
        };
        let mut ball = Particles::from_positions(vec![DVec3::ZERO]);
        let (v, a) = (DVec3::new(0.5, -0.25, 1.0), DVec3::new(-0.5, 1.0, 0.25));
        for (name, rate) in [("velocity", v), ("acceleration", a)] {
            let column = Column::new(name, 3, rate.as_vec3().to_array().to_vec());
            ball.columns.push(column);
        }
        let frame = moving(&ball, &settings);
        for time in [-0.4, 0.0, 0.3] {
            let center = v * time + a * (0.5 * time * time);
            let velocity = v + a * time;
            let ray = Ray::new(DVec3::new(0.1, 0.2, 5.0), DVec3::NEG_Z * 2.0);
            let hit = at(&frame, &ray, time).unwrap();
            let found = frame.level_set(&hit, time);
            let n = (hit.position - center) / radius;
            let near = |found: f64, expected: f64| {
                assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
            };
            near(found.normal().distance(n), 0.0);
            near(found.mean_curvature(), 1.0 / radius);
            near(found.gaussian_curvature(), 1.0 / radius.powi(2));
            let step = DVec3::new(0.3, 0.5, -0.2);
            let tangent = step - n * n.dot(step);
            near(
                (found.shape_operator() * step).distance(tangent / radius),
                0.0,
            );
            near(found.normal_speed(), n.dot(velocity));
            let rate = n.dot(velocity) / n.dot(ray.direction);
            near(found.hit_rate(ray.direction), rate);
            // The hit goes along the ray, the centre goes its own way.
            let change = found.hit_change(ray.direction, DVec3::ZERO, 1.0);
            near(change.position.distance(ray.direction * rate), 0.0);
            let normal_rate = (change.position - velocity) / radius;
            near(change.normal.distance(normal_rate), 0.0);
            near(frame.velocity(&hit, time).distance(velocity), 0.0);
        }
    }
}

#[test]
fn hits_of_rays_that_turn_and_wait_change_as_their_derivatives_say() {
    let mut next = random(4);
    let mut vectors = |count: usize, size: f64| -> Vec<DVec3> {
        (0..count)
            .map(|_| DVec3::new(next(), next(), next()) * size)
            .collect()
    };
    let count = 60;
    let mut particles = Particles::from_positions(vectors(count, 1.0));
    for (name, size) in [("velocity", 0.4), ("acceleration", 0.5)] {
        let rates = vectors(count, size).into_iter();
        let numbers: Vec<f32> = rates.flat_map(|rate| rate.as_vec3().to_array()).collect();
        particles.columns.push(Column::new(name, 3, numbers));
    }
    let signs: Vec<f32> = (0..count)
        .map(|i| if i % 6 == 0 { -0.4 } else { 1.0 })
        .collect();
    particles.columns.push(Column::new("sign", 1, signs));
    let axes = vectors(count, 1.0).into_iter();
    let metrics: Vec<f32> = axes
        .flat_map(|axis| {
            let long = axis.normalize() * 0.8;
            let m = |i: usize, j: usize| {
                let one = if i == j { 1.0 } else { 0.0 };
                ((one - long[i] * long[j]) / 0.36) as f32
            };
            [m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2)]
        })
        .collect();
    particles.columns.push(Column::new("M", 6, metrics));
    let mut compared = 0;
    for (kernel, moves) in [(Kernel::Sextic, false), (Kernel::Octic, true)] {
        for metric in [None, Some("M".to_owned())] {
            let settings = BlobSettings {
                kernel,
                threshold: 0.4,
                support: metric.is_none().then_some(0.6),
                weights: Weights::Column("sign".into()),
                metric,
                ..BlobSettings::default()
            };
            let mut frame = moving(&particles, &settings);
            // Turned, stretched and shifted.
            let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 0.7);
            let placed = DAffine3::from_scale_rotation_translation(
                DVec3::new(1.2, 0.8, 1.0),
                turn,
                DVec3::new(0.1, 0.2, -0.3),
            );
            let keys = [0.0, 0.5, 1.0].map(|time| PlacementKey {
                time,
                matrix: Matrix(DAffine3 {
                    translation: placed.translation + DVec3::new(time, time * time, 0.0) * 0.5,
                    matrix3: DMat3::from_rotation_y(0.9 * time) * placed.matrix3,
                }),
            });
            frame.instances[0] = match moves {
                false => Instance::new(0, placed, 0),
                true => Instance::moving(0, &keys, 0.5, SHUTTER, 0),
            };
            for _ in 0..60 {
                let [eye, target, eye_rate, target_rate]: [DVec3; 4] =
                    vectors(4, 1.0).try_into().unwrap();
                let eye = eye.normalize() * 4.0;
                // A ray whose eye and target move.
                let ray_at = |time: f64| {
                    let eye = eye + eye_rate * time;
                    Ray::new(eye, target * 0.6 + target_rate * time - eye)
                };
                compared += usize::from(compare(&frame, ray_at));
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

/// Whether there was something to compare: the same sheet before and after, crossed at an angle.
fn compare(frame: &Frame, ray_at: impl Fn(f64) -> Ray) -> bool {
    let (time, h) = (0.1, 1e-5);
    let hits = [time, time - h, time + h].map(|time| at(frame, &ray_at(time), time));
    let [Some(hit), Some(before), Some(after)] = hits else {
        return false;
    };
    let ray = ray_at(time);
    let cosine = hit.normal.dot(ray.direction.normalize()).abs();
    if cosine < 0.2 || (after.t - before.t).abs() > 1e-3 {
        return false;
    }
    let point = |time: f64| ray_at(time).at(hit.t);
    let point_change = (point(time + h) - point(time - h)) / (2.0 * h);
    let found = frame.level_set(&hit, time);
    let change = found.hit_change(ray.direction, point_change, 1.0);
    let position = (after.position - before.position) / (2.0 * h);
    let normal = (after.normal - before.normal) / (2.0 * h);
    let bound = |size: f64| 2e-4 * (1.0 + size);
    assert!(
        change.position.distance(position) < bound(position.length()),
        "{} for {position}",
        change.position
    );
    assert!(
        change.normal.distance(normal) < bound(normal.length()),
        "{} for {normal}",
        change.normal
    );
    true
}
