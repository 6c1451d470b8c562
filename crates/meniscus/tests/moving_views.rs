//! Cameras and instances that move while the shutter is open.

use meniscus::field::BlobField;
use meniscus::film::{ChannelSet, Film, PlaneData};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::intersect::Scratch;
use meniscus::math::aabb::DAabb;
use meniscus::math::ray::{Ray, Side};
use meniscus::math::{DAffine3, DMat3, DVec3};
use meniscus::particles::Particles;
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::{
    Background, BlobSettings, CameraKey, CameraSettings, Instance, Light, Matrix, MotionSettings,
    PlacementKey, Scene, Surface,
};
use std::sync::Arc;

const SIZE: [u32; 2] = [24, 18];
const SHUTTER_SECS: [f64; 2] = [-0.5, 0.5];
const FRAME_SECS: f64 = 2.0;
const STILLS: u32 = 256;
const SAMPLES_OF_A_STILL: u32 = 2;

/// A bar of five balls, placed by `keys` or by `matrix`.
fn frame(matrix: DAffine3, keys: Vec<PlacementKey>, shutter: f64) -> Frame {
    let bar = (0..5).map(|i| DVec3::new(0.4 * f64::from(i) - 0.8, 0.0, 0.0));
    let mut surface = Surface::from_file("");
    surface.name = Some("bar".to_owned());
    surface.radius = Some(0.3);
    let settings = surface.settings(&BlobSettings::molecule());
    let scene = Scene {
        surfaces: vec![surface],
        instances: vec![Instance {
            surface: "bar".to_owned(),
            matrix: Matrix(matrix),
            material: None,
            keys,
        }],
        motion: MotionSettings {
            shutter,
            fps: 1.0,
            time: FRAME_SECS,
            ..MotionSettings::default()
        },
        lights: vec![Light::sun(DVec3::new(0.5, 1.0, 0.7))],
        ..Scene::default()
    };
    let particles = Particles::from_positions(bar.collect());
    let field = BlobField::from_particles(&particles, &settings)
        .unwrap()
        .field;
    Frame::build(&scene, vec![field], &FrameSettings::default()).unwrap()
}

/// Half a turn and a way to the right in a second, slowly before.
fn keys() -> Vec<PlacementKey> {
    let key = |time: f64, angle: f64, x: f64| PlacementKey {
        time,
        matrix: Matrix(DAffine3 {
            matrix3: DMat3::from_rotation_z(angle),
            translation: DVec3::X * x,
        }),
    };
    vec![key(1.0, 0.0, -0.5), key(1.5, 0.2, -0.4), key(2.5, 3.0, 0.6)]
}

fn camera(keys: Vec<CameraKey>) -> Camera {
    let settings = match keys.is_empty() {
        true => CameraSettings {
            eye: Some(DVec3::new(0.0, 0.5, 5.0)),
            target: Some(DVec3::ZERO),
            ..CameraSettings::default()
        },
        false => CameraSettings {
            keys,
            ..CameraSettings::default()
        },
    };
    Camera::from_settings_at(&settings, DAabb::EMPTY, SIZE, FRAME_SECS).unwrap()
}

fn flight() -> Vec<CameraKey> {
    let key = |time: f64, eye: DVec3, target: DVec3| CameraKey {
        time,
        eye,
        target,
        up: None,
        fov: None,
    };
    vec![
        key(1.5, DVec3::new(-0.6, 0.5, 5.0), DVec3::ZERO),
        key(2.0, DVec3::new(0.3, 0.6, 4.5), DVec3::X * 0.2),
        key(2.6, DVec3::new(1.5, 0.2, 4.0), DVec3::ZERO),
    ]
}

fn picture(frame: &Frame, camera: &Camera, spp: u32, seed: u32, shutter_secs: [f64; 2]) -> Film {
    let settings = RenderSettings {
        spp,
        seed,
        shutter_secs,
        channels: Arc::new(ChannelSet::new(&["all"], &[]).unwrap()),
        background: Background::Transparent,
        ..RenderSettings::default()
    };
    let (progress, state) = (Progress::none(), RenderState::new());
    let rendered = CpuBackend.render(frame, camera, &settings, &state, &progress);
    rendered.unwrap().0
}

fn plane(film: &Film, name: &str) -> Vec<f64> {
    match film.plane_named(name) {
        Some(PlaneData::F32(values)) => values.into_iter().map(f64::from).collect(),
        other => panic!("{name} is {other:?}"),
    }
}

fn values(film: &Film) -> Vec<f64> {
    ["R", "A"]
        .into_iter()
        .flat_map(|name| plane(film, name))
        .collect()
}

fn mean_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

/// Blur against the mean of stills, and against another blur with other random numbers.
fn assert_blur(frame: &Frame, camera: &Camera, still: impl Fn(f64) -> (Frame, Camera)) {
    let [open, close] = SHUTTER_SECS;
    let mut mean = vec![0.0; 2 * (SIZE[0] * SIZE[1]) as usize];
    for i in 0..STILLS {
        let secs = open + (close - open) * (f64::from(i) + 0.5) / f64::from(STILLS);
        let (frame, camera) = still(secs);
        let one = picture(&frame, &camera, SAMPLES_OF_A_STILL, 7 + i, [0.0; 2]);
        for (mean, value) in mean.iter_mut().zip(values(&one)) {
            *mean += value / f64::from(STILLS);
        }
    }
    let blurred = [3, 4].map(|seed| values(&picture(frame, camera, 512, seed, SHUTTER_SECS)));
    let noise = mean_difference(&blurred[0], &blurred[1]);
    let difference = mean_difference(&blurred[0], &mean);
    let sharp = values(&picture(frame, camera, 64, 3, [0.0; 2]));
    let blur = mean_difference(&sharp, &mean);
    assert!(difference < 2.0 * noise + 1e-4, "{difference} for {noise}");
    assert!(blur > 4.0 * difference, "{blur} for {difference}");
}

#[test]
fn a_turning_instance_is_the_mean_of_its_stills() {
    let moving = frame(DAffine3::IDENTITY, keys(), 1.0);
    assert!(moving.moves());
    let still = |secs: f64| {
        let there = moving.instances[0].at(secs).world_from_object;
        (frame(there, Vec::new(), 0.0), camera(Vec::new()))
    };
    assert_blur(&moving, &camera(Vec::new()), still);
}

#[test]
fn a_flying_camera_is_the_mean_of_its_stills() {
    let there = DAffine3::from_translation(DVec3::Y * 0.1);
    let flying = camera(flight());
    let still = |secs: f64| (frame(there, Vec::new(), 0.0), flying.at(secs));
    assert_blur(&frame(there, Vec::new(), 0.0), &flying, still);
}

#[test]
fn what_rests_is_what_never_moved_to_the_last_bit() {
    let there = keys()[1].matrix;
    let resting: Vec<PlacementKey> = [0.0, 2.0, 9.0]
        .map(|time| PlacementKey {
            time,
            matrix: there,
        })
        .to_vec();
    let never = frame(there.0, Vec::new(), 0.0);
    let rests = frame(DAffine3::IDENTITY, resting, 1.0);
    assert!(!rests.moves());
    let camera = camera(Vec::new());
    let [a, b] = [&never, &rests].map(|frame| picture(frame, &camera, 4, 1, SHUTTER_SECS));
    assert_eq!(a, b);
    // Without a shutter a moving one stands where it is then.
    let sharp = frame(DAffine3::IDENTITY, keys(), 0.0);
    assert!(!sharp.moves());
    let moving = frame(DAffine3::IDENTITY, keys(), 1.0);
    let [a, b] = [&sharp, &moving].map(|frame| values(&picture(frame, &camera, 4, 1, [0.0; 2])));
    assert!(mean_difference(&a, &b) < 1e-6);
}

#[test]
fn rays_meet_the_instance_where_it_is_at_their_time() {
    let moving = frame(DAffine3::IDENTITY, keys(), 1.0);
    let mut scratch = Scratch::default();
    let mut met = 0;
    for i in 0..200 {
        let secs = -0.5 + f64::from(i) / 199.0;
        let there = moving.instances[0].at(secs).world_from_object;
        let still = frame(there, Vec::new(), 0.0);
        let angle = 2.4 * f64::from(i);
        let eye = DVec3::new(angle.cos(), angle.sin(), 1.5) * 3.0;
        let target = there.transform_point3(DVec3::X * (0.01 * f64::from(i) - 1.0));
        let ray = Ray::new(eye, (target - eye).normalize());
        let expected = still.closest_hit(&ray, &mut scratch);
        let ray = Ray { time: secs, ..ray };
        let found = moving.closest_hit(&ray, &mut scratch);
        assert_eq!(found.is_some(), expected.is_some());
        assert_eq!(moving.any_hit(&ray, &mut scratch), expected.is_some());
        if let (Some(found), Some(expected)) = (found, expected) {
            assert!((found.t - expected.t).abs() < 1e-6);
            assert!(found.normal.distance(expected.normal) < 1e-5);
            let inside = found.position - found.normal * 1e-3;
            assert_eq!(moving.side(0, inside, secs, &mut scratch), Side::Inside);
            met += 1;
        }
    }
    assert!(met > 120, "{met}");
}

#[test]
fn the_motion_channel_counts_the_camera() {
    let still = frame(DAffine3::IDENTITY, Vec::new(), 0.0);
    let flying = camera(flight());
    let film = picture(&still, &flying, 1, 0, SHUTTER_SECS);
    let [x, y] = ["motion.X", "motion.Y"].map(|name| plane(&film, name));
    let places = ["P.X", "P.Y", "P.Z"].map(|name| plane(&film, name));
    let alpha = plane(&film, "A");
    let mut seen = 0;
    for pixel in (0..alpha.len()).filter(|&pixel| alpha[pixel] > 0.0) {
        let point = DVec3::from_array([0, 1, 2].map(|axis| places[axis][pixel]));
        let [from, to] = SHUTTER_SECS.map(|secs| flying.at(secs).project(point).unwrap());
        let error = (x[pixel] - (to[0] - from[0])).hypot(y[pixel] - (to[1] - from[1]));
        assert!(error < 1e-3, "{pixel}: {error}");
        seen += 1;
    }
    assert!(seen > 20 && x.iter().any(|x| x.abs() > 1.0), "{seen}");
}

#[test]
fn what_is_hit_is_carried_along_with_its_instance() {
    let moving = frame(DAffine3::IDENTITY, keys(), 1.0);
    let ray = Ray {
        time: 0.1,
        ..Ray::new(DVec3::Z * 5.0, DVec3::NEG_Z)
    };
    let hit = moving.closest_hit(&ray, &mut Scratch::default()).unwrap();
    let placed = |secs: f64| moving.instances[0].at(secs);
    let object = placed(0.1).object_from_world.transform_point3(hit.position);
    for secs in [-0.5, 0.1, 0.4] {
        let expected = placed(secs).world_from_object.transform_point3(object);
        assert!(moving.carried(&hit, 0.1, secs).distance(expected) < 1e-12);
    }
    let h = 1e-6;
    let [before, after] = [0.1 - h, 0.1 + h].map(|secs| moving.carried(&hit, 0.1, secs));
    let velocity = (after - before) / (2.0 * h);
    assert!(moving.velocity(&hit, 0.1).distance(velocity) < 1e-6);
    let bounds = moving.bounds([-0.5, 0.5]);
    assert!(bounds.min.cmple(hit.position).all() && hit.position.cmple(bounds.max).all());
}
