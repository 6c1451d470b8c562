//! Rendered films against closed forms: one ball, whose intersection, shadow and shading are known.

use meniscus::field::BlobField;
use meniscus::film::{ChannelSet, Film, NO_INDEX, PlaneData, Region};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::DVec3;
use meniscus::particles::{Column, Particles};
use meniscus::render::{
    Backend, CpuBackend, Progress, RenderError, RenderSettings, RenderState, RenderStats,
};
use meniscus::scene::camera::Camera;
use meniscus::scene::generate::Generator;
use meniscus::scene::{
    Background, BlobSettings, Color, Ground, Light, Material, Scene, Surface, Weights,
};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

const SIZE: [u32; 2] = [64, 48];
const ALBEDO: f64 = 0.5;
const TOWARDS_SUN: DVec3 = DVec3::new(0.6, 0.64, 0.48);

/// A white-lit diffuse ball of `radius` around `center` under a sun of radiance 1, without sky.
fn ball(center: DVec3, radius: f64, ground: bool) -> (Scene, Frame) {
    let mut particles = Particles::from_positions(vec![center]);
    particles
        .columns
        .push(Column::new("velocity", 3, vec![1.0_f32, -2.0, 0.5]));
    particles.rows = vec![41];
    let mut surface = Surface::from_file("");
    surface.radius = Some(radius);
    surface.threshold = Some(0.3);
    surface.weights = Some(Weights::Unit);
    surface.attributes = vec!["velocity".into()];
    surface.material = Some("white".into());
    let sun = Light {
        intensity: 1.0,
        color: None,
        ..Light::sun(TOWARDS_SUN)
    };
    let mut scene = Scene {
        surfaces: vec![surface],
        lights: vec![sun],
        ..Scene::default()
    };
    scene
        .materials
        .insert("white".into(), Material::diffuse(Color([ALBEDO; 3])));
    scene.ground = ground.then(|| Ground {
        height: Some(center.y - 2.0 * radius),
        material: Some("white".into()),
    });
    let settings = scene.surfaces[0].settings(&BlobSettings::default());
    let field = BlobField::from_particles(&particles, &settings).unwrap();
    let frame = Frame::build(&scene, vec![field.field], &FrameSettings::default()).unwrap();
    (scene, frame)
}

fn camera(center: DVec3, radius: f64) -> Camera {
    let eye = center + DVec3::new(1.0, 2.0, 6.0) * radius;
    Camera::new(eye, center, DVec3::Y, 0.8, SIZE).unwrap()
}

fn settings() -> RenderSettings {
    let attributes = [("velocity".to_owned(), 3)];
    RenderSettings {
        spp: 1,
        channels: Arc::new(ChannelSet::new(&["all"], &attributes).unwrap()),
        background: Background::Transparent,
        ..RenderSettings::default()
    }
}

fn render(frame: &Frame, camera: &Camera, settings: &RenderSettings) -> (Film, RenderStats) {
    let progress = Progress::none();
    CpuBackend
        .render(frame, camera, settings, &RenderState::new(), &progress)
        .unwrap()
}

fn real(film: &Film, name: &str) -> Vec<f64> {
    match film.plane_named(name) {
        Some(PlaneData::F32(values)) => values.into_iter().map(f64::from).collect(),
        other => panic!("{name} is {other:?}"),
    }
}

fn index(film: &Film, name: &str) -> Vec<u32> {
    match film.plane_named(name) {
        Some(PlaneData::U32(values)) => values,
        other => panic!("{name} is {other:?}"),
    }
}

/// First intersection with a ball, in closed form.
fn ball_hit(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let to_center = center - origin;
    let along = to_center.dot(direction);
    let miss = (to_center - direction * along).length_squared();
    let half = (radius * radius - miss).sqrt();
    (half.is_finite() && along - half > 0.0).then_some(along - half)
}

#[test]
fn a_ball_has_its_closed_form_geometry_and_no_acne_at_any_scale() {
    for (radius, offset) in [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (0.5, 1e6)] {
        let center = DVec3::new(offset, 0.5 * offset, -offset);
        let (_, frame) = ball(center, radius, false);
        let camera = camera(center, radius);
        let (film, stats) = render(&frame, &camera, &settings());
        let [red, alpha, z] = ["R", "A", "Z"].map(|name| real(&film, name));
        let position = ["P.X", "P.Y", "P.Z"].map(|name| real(&film, name));
        let normal = ["N.X", "N.Y", "N.Z"].map(|name| real(&film, name));
        let curvature = ["mean", "gaussian"].map(|name| real(&film, &format!("curvature.{name}")));
        let velocity = real(&film, "velocity.Y");
        let (id, surface) = (index(&film, "id"), index(&film, "surface"));
        let (mut hits, mut lit) = (0, 0);
        for pixel in 0..(SIZE[0] * SIZE[1]) as usize {
            let x = pixel as u32 % SIZE[0];
            let y = pixel as u32 / SIZE[0];
            let ray = camera.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]);
            let t = ball_hit(ray.origin, ray.direction, center, radius);
            let at =
                |planes: &[Vec<f64>; 3]| DVec3::from_array([0, 1, 2].map(|c| planes[c][pixel]));
            let closest = (center - ray.origin).cross(ray.direction).length();
            if (closest / radius - 1.0).abs() < 1e-3 {
                continue; // grazing: f32 decides
            }
            let Some(t) = t else {
                assert_eq!((alpha[pixel], z[pixel]), (0.0, f64::INFINITY));
                assert_eq!((at(&position), at(&normal)), (DVec3::ZERO, DVec3::ZERO));
                assert_eq!((id[pixel], surface[pixel]), (NO_INDEX, NO_INDEX));
                assert_eq!((red[pixel], velocity[pixel]), (0.0, 0.0));
                continue;
            };
            hits += 1;
            assert_eq!((alpha[pixel], id[pixel], surface[pixel]), (1.0, 41, 0));
            assert!((velocity[pixel] + 2.0).abs() < 1e-6);
            assert!((curvature[0][pixel] * radius - 1.0).abs() < 1e-3);
            assert!((curvature[1][pixel] * radius * radius - 1.0).abs() < 2e-3);
            let expected = ray.at(t);
            let outward = (expected - center) / radius;
            let slope = outward.dot(-ray.direction);
            let tolerance = 2e-4 * radius / slope + 1.2e-7 * offset;
            assert!((at(&position) - expected).length() < tolerance);
            assert!((z[pixel] - camera.depth(expected)).abs() < tolerance);
            assert!((at(&normal) - outward).length() < 2e-3 / slope);
            // The ball is convex: it never shadows its lit half, and acne would show as black.
            let nl = outward.dot(TOWARDS_SUN);
            if nl > 0.01 {
                lit += 1;
            }
            let shown = red[pixel];
            assert!(
                (shown - ALBEDO * nl.max(0.0)).abs() < 2e-3 / slope,
                "radius {radius}: {shown} for {nl} at {x}, {y}"
            );
        }
        assert!(
            hits > 200 && lit > 100,
            "radius {radius}: {hits} hits, {lit} lit"
        );
        assert_eq!(stats.rays.primary, u64::from(SIZE[0] * SIZE[1]));
        assert!(stats.rays.shadow >= lit && stats.rays.shadow < stats.rays.primary);
    }
}

#[test]
fn the_ground_shows_the_hard_shadow_of_the_ball_and_none_of_its_own() {
    let center = DVec3::new(3.0, 1.0, -2.0);
    let radius = 0.7;
    let (_, frame) = ball(center, radius, true);
    let camera = camera(center, radius);
    let (film, _) = render(&frame, &camera, &settings());
    let red = real(&film, "R");
    let surface = index(&film, "surface");
    let planes = ["P.X", "P.Y", "P.Z"].map(|name| real(&film, name));
    let (mut shadowed, mut lit) = (0, 0);
    for pixel in (0..red.len()).filter(|&pixel| surface[pixel] == 1) {
        let point = DVec3::from_array([0, 1, 2].map(|c| planes[c][pixel]));
        let miss = (center - point).cross(TOWARDS_SUN).length();
        if (miss / radius - 1.0).abs() < 1e-3 {
            continue;
        }
        let expected = if miss < radius {
            0.0
        } else {
            ALBEDO * TOWARDS_SUN.y
        };
        assert!(
            (red[pixel] - expected).abs() < 1e-4,
            "{} at {point}",
            red[pixel]
        );
        if miss < radius {
            shadowed += 1;
        } else {
            lit += 1;
        }
    }
    assert!(shadowed > 50 && lit > 300, "{shadowed} shadowed, {lit} lit");
}

/// A dense fluid on the ground, whose rays go together.
fn pool() -> (Frame, Camera) {
    let generated = Generator::Pool.generate(3000, 1, None).unwrap();
    let scene = generated.scene;
    let surface = &scene.surfaces[0];
    let settings = surface.settings(&BlobSettings::default());
    let field = BlobField::from_particles(&generated.particles, &settings).unwrap();
    let frame = Frame::build(&scene, vec![field.field], &FrameSettings::default()).unwrap();
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), SIZE).unwrap();
    (frame, camera)
}

#[test]
fn any_number_of_threads_tiles_and_sample_ranges_gives_the_same_bits() {
    let center = DVec3::new(0.1, 0.2, 0.3);
    let (_, frame) = ball(center, 1.0, true);
    let (pool, pool_camera) = pool();
    let channels = settings().channels;
    let plain = Arc::new(ChannelSet::new(&["depth", "normal", "id"], &[]).unwrap());
    for (frame, camera, channels) in [
        (&frame, &camera(center, 1.0), channels),
        (&pool, &pool_camera, plain),
    ] {
        let with = |change: &dyn Fn(&mut RenderSettings)| {
            let mut settings = RenderSettings {
                spp: 6,
                background: Background::Sky,
                channels: channels.clone(),
                ..settings()
            };
            change(&mut settings);
            render(frame, camera, &settings).0
        };
        let whole = with(&|s| s.threads = Some(1));
        for threads in [2, 8] {
            assert_eq!(whole, with(&|s| s.threads = Some(threads)));
        }
        let full = Region::full(SIZE[0], SIZE[1]);
        let mut merged = Film::new(SIZE, full, channels.clone(), Background::Sky).unwrap();
        // Rectangles that cut through the blocks of rays that are traced together.
        let rectangles = full.tiles(23);
        for samples in [3..6, 0..1, 1..3] {
            for &rectangle in &rectangles {
                let part = with(&|s| {
                    s.region = Some(rectangle);
                    s.samples = Some(samples.clone());
                });
                merged.merge(&part).unwrap();
            }
        }
        assert_eq!(whole, merged);
    }
}

#[test]
fn a_cancelled_rendering_returns_no_film() {
    let (_, frame) = ball(DVec3::ZERO, 1.0, false);
    let camera = camera(DVec3::ZERO, 1.0);
    let cancel = AtomicBool::new(false);
    let stop_at_first_tile = |_, _| cancel.store(true, Ordering::Relaxed);
    let progress = Progress::none()
        .with_cancel(&cancel)
        .with_callback(&stop_at_first_tile);
    let result = CpuBackend.render(&frame, &camera, &settings(), &RenderState::new(), &progress);
    assert!(matches!(result, Err(RenderError::Cancelled)));
    assert!(progress.done() < u64::from(SIZE[0] * SIZE[1]));
}

#[test]
fn progress_counts_every_sample() {
    let (_, frame) = ball(DVec3::ZERO, 1.0, false);
    let camera = camera(DVec3::ZERO, 1.0);
    let total = AtomicBool::new(false);
    let watch = |done, all| {
        assert!(done <= all && all == 2 * u64::from(SIZE[0] * SIZE[1]));
        total.store(done == all, Ordering::Relaxed);
    };
    let progress = Progress::none().with_callback(&watch);
    let settings = RenderSettings {
        spp: 2,
        threads: Some(1),
        ..settings()
    };
    CpuBackend
        .render(&frame, &camera, &settings, &RenderState::new(), &progress)
        .unwrap();
    assert!(total.load(Ordering::Relaxed));
}

#[test]
fn impossible_settings_are_errors() {
    let (_, frame) = ball(DVec3::ZERO, 1.0, false);
    let camera = camera(DVec3::ZERO, 1.0);
    let fails = |settings: RenderSettings| {
        CpuBackend
            .render(
                &frame,
                &camera,
                &settings,
                &RenderState::new(),
                &Progress::none(),
            )
            .unwrap_err()
            .to_string()
    };
    let samples = fails(RenderSettings {
        samples: Some(1..3),
        ..settings()
    });
    assert!(samples.contains("samples 1 to 2"), "{samples}");
    let none = fails(RenderSettings {
        spp: 0,
        ..settings()
    });
    assert!(none.contains("samples"), "{none}");
    let region = fails(RenderSettings {
        region: Some(Region {
            x: 60,
            y: 0,
            width: 5,
            height: 5,
        }),
        ..settings()
    });
    assert!(region.contains("64x48"), "{region}");
}

#[test]
fn a_state_that_saw_other_frames_changes_no_picture_and_no_count() {
    let (_, small) = ball(DVec3::ZERO, 1.0, false);
    let (_, large) = ball(DVec3::X, 3.0, true);
    let state = RenderState::new();
    let render = |frame: &Frame, state: &RenderState, progress: &Progress<'_>| {
        CpuBackend.render(
            frame,
            &camera(DVec3::ZERO, 1.0),
            &settings(),
            state,
            progress,
        )
    };
    render(&large, &state, &Progress::none()).unwrap();
    let cancelled = AtomicBool::new(true);
    let stop = Progress::none().with_cancel(&cancelled);
    assert!(render(&large, &state, &stop).is_err());
    let (film, stats) = render(&small, &state, &Progress::none()).unwrap();
    let (fresh_film, fresh_stats) = render(&small, &RenderState::new(), &Progress::none()).unwrap();
    assert_eq!(film, fresh_film);
    assert_eq!(stats.counters, fresh_stats.counters);
    assert_eq!(stats.rays, fresh_stats.rays);
}
