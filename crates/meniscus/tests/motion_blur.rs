//! Pictures of moving particles against the mean of many still ones.

use meniscus::field::BlobField;
use meniscus::film::{ChannelSet, Film, PlaneData};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::DVec3;
use meniscus::particles::{Column, Particles};
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::{Background, BlobSettings, Light, Scene, Surface, Weights};
use std::sync::Arc;

const SIZE: [u32; 2] = [40, 30];
const SHUTTER_SECS: [f64; 2] = [-0.5, 0.5];
const STILLS: u32 = 256;
const SAMPLES_OF_A_STILL: u32 = 4;

/// Position, velocity and acceleration.
type Throw = [DVec3; 3];

/// Balls that pass, fall and turn round at different speeds.
fn throws() -> Vec<Throw> {
    let vector = |x, y, z| DVec3::new(x, y, z);
    vec![
        [vector(-1.0, 0.0, 0.0), vector(2.0, 0.3, 0.0), DVec3::ZERO],
        [
            vector(0.2, 0.5, 0.3),
            vector(-0.4, 0.1, 0.5),
            vector(0.0, -3.0, 0.0),
        ],
        [vector(0.9, -0.4, 0.0), DVec3::ZERO, vector(-2.5, 4.0, 0.0)],
        [vector(0.0, -0.6, 0.2), DVec3::ZERO, DVec3::ZERO],
    ]
}

/// Where they are at a time, at rest there.
fn stopped(throws: &[Throw], t: f64) -> Vec<Throw> {
    let place = |&[p, v, a]: &Throw| [p + v * t + a * (0.5 * t * t), DVec3::ZERO, DVec3::ZERO];
    throws.iter().map(place).collect()
}

fn particles(throws: &[Throw]) -> Particles {
    let mut particles = Particles::from_positions(throws.iter().map(|throw| throw[0]).collect());
    for (place, name) in [(1, "velocity"), (2, "acceleration")] {
        let values = throws
            .iter()
            .flat_map(|throw| throw[place].as_vec3().to_array());
        let column = Column::new(name, 3, values.collect::<Vec<f32>>());
        particles.columns.push(column);
    }
    let numbers: Vec<f32> = (1..=throws.len()).map(|number| number as f32).collect();
    particles.columns.push(Column::new("number", 1, numbers));
    particles
}

fn frame(throws: &[Throw], shutter_secs: [f64; 2]) -> Frame {
    let mut surface = Surface::from_file("");
    surface.support = Some(0.7);
    surface.threshold = Some(0.3);
    surface.weights = Some(Weights::Unit);
    surface.attributes = vec!["number".into()];
    let settings = surface.settings(&BlobSettings::default());
    let scene = Scene {
        surfaces: vec![surface],
        lights: vec![Light::sun(DVec3::new(0.5, 1.0, 0.7))],
        ..Scene::default()
    };
    let particles = particles(throws);
    let built = BlobField::from_moving_particles(&particles, &settings, shutter_secs, 1.0).unwrap();
    Frame::build(&scene, vec![built.field], &FrameSettings::default()).unwrap()
}

fn picture(frame: &Frame, settings: &RenderSettings) -> Film {
    let camera = Camera::new(DVec3::new(0.0, 0.3, 5.0), DVec3::ZERO, DVec3::Y, 0.7, SIZE).unwrap();
    let (progress, state) = (Progress::none(), RenderState::new());
    let rendered = CpuBackend.render(frame, &camera, settings, &state, &progress);
    rendered.unwrap().0
}

fn settings(spp: u32, seed: u32, shutter_secs: [f64; 2]) -> RenderSettings {
    RenderSettings {
        spp,
        seed,
        shutter_secs,
        background: Background::Transparent,
        threads: Some(1),
        ..RenderSettings::default()
    }
}

fn plane(film: &Film, name: &str) -> Vec<f64> {
    match film.plane_named(name) {
        Some(PlaneData::F32(values)) => values.into_iter().map(f64::from).collect(),
        other => panic!("{name} is {other:?}"),
    }
}

/// Red and alpha of all pixels.
fn values(film: &Film) -> Vec<f64> {
    ["R", "A"]
        .into_iter()
        .flat_map(|name| plane(film, name))
        .collect()
}

fn mean_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

#[test]
fn blur_is_the_mean_of_what_stands_still_at_all_times() {
    let throws = throws();
    let [open, close] = SHUTTER_SECS;
    let mut mean = vec![0.0; 2 * (SIZE[0] * SIZE[1]) as usize];
    for still in 0..STILLS {
        let t = open + (close - open) * (f64::from(still) + 0.5) / f64::from(STILLS);
        let one = picture(
            &frame(&stopped(&throws, t), [0.0; 2]),
            &settings(SAMPLES_OF_A_STILL, 7 + still, [0.0; 2]),
        );
        for (mean, value) in mean.iter_mut().zip(values(&one)) {
            *mean += value / f64::from(STILLS);
        }
    }
    let blurred = values(&picture(
        &frame(&throws, SHUTTER_SECS),
        &settings(1024, 3, SHUTTER_SECS),
    ));
    // A pixel that is covered half of the time has a variance of 1/4: 1024 samples of each leave a
    // mean difference below 0.018 even if every pixel were one of those and nothing were stratified.
    let off = mean_difference(&blurred, &mean);
    assert!(off < 0.006, "off by {off}");
    let sharp = values(&picture(
        &frame(&throws, [0.0; 2]),
        &settings(64, 3, [0.0; 2]),
    ));
    let moved = mean_difference(&sharp, &mean);
    assert!(moved > 0.03, "the blur shows nothing: {moved}");
}

#[test]
fn particles_at_rest_look_the_same_to_the_last_bit_under_an_open_shutter() {
    let there = stopped(&throws(), 0.0);
    let still = picture(&frame(&there, [0.0; 2]), &settings(16, 5, [0.0; 2]));
    let open = picture(&frame(&there, SHUTTER_SECS), &settings(16, 5, SHUTTER_SECS));
    assert_eq!(values(&still), values(&open));
}

#[test]
fn attributes_are_those_of_the_moment() {
    let t = 0.4;
    let numbers = |throws: &[Throw], shutter_secs: [f64; 2], moment: f64| {
        let attributes = [("number".to_owned(), 1)];
        let settings = RenderSettings {
            channels: Arc::new(ChannelSet::new(&["all"], &attributes).unwrap()),
            ..settings(1, 5, [moment; 2])
        };
        plane(&picture(&frame(throws, shutter_secs), &settings), "number")
    };
    let moving = numbers(&throws(), SHUTTER_SECS, t);
    let still = numbers(&stopped(&throws(), t), [0.0; 2], 0.0);
    for (moving, still) in moving.iter().zip(&still) {
        assert!((moving - still).abs() < 1e-3, "{moving} is not {still}");
    }
    for number in [1.0, 2.0, 3.0, 4.0] {
        assert!(still.iter().any(|seen| (seen - number).abs() < 0.1));
    }
    let before = numbers(&throws(), SHUTTER_SECS, 0.0);
    assert!(mean_difference(&before, &still) > 0.1);
}

#[test]
fn the_same_blur_for_any_number_of_threads() {
    let frame = frame(&throws(), SHUTTER_SECS);
    let picture = |threads| {
        let settings = RenderSettings {
            threads: Some(threads),
            ..settings(16, 5, SHUTTER_SECS)
        };
        values(&picture(&frame, &settings))
    };
    assert_eq!(picture(1), picture(3));
}

#[test]
fn the_channel_of_motion_is_the_way_across_the_film() {
    let velocity = DVec3::new(0.8, -0.5, 0.0);
    let frame = frame(&[[DVec3::ZERO, velocity, DVec3::ZERO]], SHUTTER_SECS);
    let settings = RenderSettings {
        channels: Arc::new(ChannelSet::new(&["motion", "position"], &[]).unwrap()),
        ..settings(1, 5, SHUTTER_SECS)
    };
    let film = picture(&frame, &settings);
    let [mx, my, px, py, pz, alpha] =
        ["motion.X", "motion.Y", "P.X", "P.Y", "P.Z", "A"].map(|name| plane(&film, name));
    let eye = DVec3::new(0.0, 0.3, 5.0);
    let forward = -eye.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let per_pixel = 2.0 * (0.35_f64).tan() / f64::from(SIZE[1]);
    let mut seen = 0;
    for pixel in (0..mx.len()).filter(|&pixel| alpha[pixel] == 1.0) {
        // When within the shutter the ray was cast hardly matters: nothing comes nearer.
        let at = DVec3::new(px[pixel], py[pixel], pz[pixel]) - eye;
        let depth = at.dot(forward);
        let film_of = |p: DVec3| [p.dot(right), -p.dot(up)].map(|c| c / p.dot(forward) / per_pixel);
        let [from, to] = [-0.5, 0.5].map(|t| film_of(at + velocity * t));
        assert!((mx[pixel] - (to[0] - from[0])).abs() < 0.25, "{depth}");
        assert!((my[pixel] - (to[1] - from[1])).abs() < 0.25);
        assert!(mx[pixel] > 4.0 && my[pixel] > 2.0);
        seen += 1;
    }
    assert!(seen > 20, "{seen}");
}
