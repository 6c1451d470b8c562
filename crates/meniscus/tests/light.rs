//! Integrators on whole pictures: the same bits for any threads and tiles, convergence, adaptive
//! sampling.

use meniscus::field::BlobField;
use meniscus::film::{ChannelSet, Film, PlaneData, Region};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::DVec3;
use meniscus::particles::{Column, Particles};
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState, RenderStats};
use meniscus::scene::camera::Camera;
use meniscus::scene::{
    Background, BlobSettings, Color, Ground, IntegratorKind, IntegratorSettings, Light, LightKind,
    Material, MaterialKind, Plane, Scene, Surface, Weights,
};
use std::sync::Arc;
use std::time::Duration;

const SIZE: [u32; 2] = [40, 30];

/// Three drops of one material on the ground under a sun, a lamp and a sky, before a mirror.
fn scene(material: Material) -> (Frame, Camera) {
    let centers = [[-0.9, 0.0, 0.0], [0.0, 0.2, 0.4], [0.7, -0.1, -0.2]];
    let mut particles = Particles::from_positions(centers.map(DVec3::from_array).to_vec());
    let wear = Column::new("wear", 1, vec![0.0_f32, 0.5, 1.0]);
    particles.columns.push(wear);
    let roughness_by = material.kind.takes_roughness().then(|| "wear".to_owned());
    let mut scene = Scene {
        surfaces: vec![Surface {
            radius: Some(0.6),
            threshold: Some(0.3),
            weights: Some(Weights::Unit),
            attributes: vec!["wear".to_owned()],
            roughness_by,
            material: Some("drops".to_owned()),
            ..Surface::from_file("")
        }],
        planes: vec![Plane {
            point: DVec3::new(0.0, 0.0, -3.0),
            normal: Some(DVec3::Z),
            material: Some("mirror".to_owned()),
        }],
        ground: Some(Ground::default()),
        lights: vec![
            Light {
                angle: Some(20.0),
                ..Light::sun(DVec3::new(1.0, 2.0, 1.0))
            },
            Light::sky(),
            Light {
                kind: LightKind::Sphere,
                position: Some(DVec3::new(-1.5, 1.0, 1.0)),
                radius: Some(0.3),
                intensity: 4.0,
                ..Light::default()
            },
        ],
        ..Scene::default()
    };
    scene.materials.insert("drops".to_owned(), material);
    let mirror = Material::of(MaterialKind::Mirror, Some(Color([0.8; 3])));
    scene.materials.insert("mirror".to_owned(), mirror);
    let settings = scene.surfaces[0].settings(&BlobSettings::default());
    let field = BlobField::from_particles(&particles, &settings).unwrap();
    let frame = Frame::build(&scene, vec![field.field], &FrameSettings::default()).unwrap();
    let eye = DVec3::new(1.0, 1.5, 5.0);
    let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, 0.7, SIZE).unwrap();
    (frame, camera)
}

fn settings(kind: IntegratorKind, spp: u32) -> RenderSettings {
    RenderSettings {
        spp,
        integrator: IntegratorSettings {
            kind,
            depth: 6,
            ..IntegratorSettings::default()
        },
        channels: Arc::new(ChannelSet::new(&["all"], &[("wear".to_owned(), 1)]).unwrap()),
        ..RenderSettings::default()
    }
}

fn render(frame: &Frame, camera: &Camera, settings: &RenderSettings) -> (Film, RenderStats) {
    CpuBackend
        .render(
            frame,
            camera,
            settings,
            &RenderState::new(),
            &Progress::none(),
        )
        .unwrap()
}

fn plane(film: &Film, name: &str) -> Vec<f32> {
    match film.plane_named(name) {
        Some(PlaneData::F32(values)) => values,
        other => panic!("{name} is {other:?}"),
    }
}

fn water() -> Material {
    Material {
        absorption: Some(Color([0.3, 0.8, 0.9])),
        absorption_depth: Some(1.0),
        ..Material::of(MaterialKind::Water, None)
    }
}

#[test]
fn every_integrator_gives_the_same_bits_for_any_threads_tiles_and_samples() {
    for material in [
        water(),
        Material::of(MaterialKind::Metal, None),
        Material::of(MaterialKind::Foam, None),
    ] {
        let (frame, camera) = scene(material);
        for kind in IntegratorKind::ALL {
            let whole = RenderSettings {
                threads: Some(1),
                ..settings(kind, 4)
            };
            let (film, stats) = render(&frame, &camera, &whole);
            for threads in [2, 8] {
                let (again, again_stats) = render(
                    &frame,
                    &camera,
                    &RenderSettings {
                        threads: Some(threads),
                        ..whole.clone()
                    },
                );
                assert_eq!(film, again, "{kind:?} on {threads} threads");
                assert_eq!(stats.rays, again_stats.rays);
            }
            let full = Region::full(SIZE[0], SIZE[1]);
            let channels = whole.channels.clone();
            let mut merged = Film::new(SIZE, full, channels, Background::Sky).unwrap();
            for samples in [1..4, 0..1] {
                for tile in full.tiles(17) {
                    let part = RenderSettings {
                        region: Some(tile),
                        samples: Some(samples.clone()),
                        ..whole.clone()
                    };
                    merged.merge(&render(&frame, &camera, &part).0).unwrap();
                }
            }
            assert_eq!(film, merged, "{kind:?} in parts");
        }
    }
}

#[test]
fn paths_converge_to_one_picture_with_the_root_of_the_samples() {
    for material in [water(), Material::glossy(Color([0.7, 0.3, 0.2]), 1.0, 0.3)] {
        let (frame, camera) = scene(material);
        let picture = |spp: u32, seed: u32| {
            let film = render(
                &frame,
                &camera,
                &RenderSettings {
                    seed,
                    ..settings(IntegratorKind::Path, spp)
                },
            );
            plane(&film.0, "G")
        };
        let reference = picture(1024, 1);
        let average = |values: &[f32]| values.iter().map(|&v| f64::from(v)).sum::<f64>();
        let error = |spp: u32| {
            let found = picture(spp, 2);
            let squares = found.iter().zip(&reference);
            let squares = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
            let mean = (squares / reference.len() as f64).sqrt();
            // The whole picture's mean differs by less than its pixels' errors allow.
            let off = (average(&found) - average(&reference)) / reference.len() as f64;
            let bound = 5.0 * mean / (reference.len() as f64).sqrt();
            assert!(
                off.abs() < bound,
                "{spp} samples: off by {off}, bound {bound}"
            );
            mean
        };
        let [few, more, many] = [4, 16, 64].map(error);
        // Each step should halve the error (stratified samples do better); 0.75 leaves room for luck.
        assert!(
            more < 0.75 * few && many < 0.75 * more,
            "{few} {more} {many}"
        );
        assert!(many < 0.35 * few, "{few} {many}");
    }
}

#[test]
fn no_sample_is_negative_or_endless_and_a_closed_box_is_dark() {
    let (mut frame, camera) = scene(water());
    let (film, _) = render(&frame, &camera, &settings(IntegratorKind::Path, 16));
    for name in ["R", "G", "B"] {
        let values = plane(&film, name);
        assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0));
    }
    frame.lights.clear();
    let dark = RenderSettings {
        background: Background::Transparent,
        ..settings(IntegratorKind::Path, 4)
    };
    let (film, _) = render(&frame, &camera, &dark);
    assert!(plane(&film, "R").iter().all(|&v| v == 0.0));
}

#[test]
fn noisy_tiles_get_more_samples_and_the_picture_does_not_depend_on_threads() {
    let (frame, camera) = scene(Material::diffuse(Color([0.5; 3])));
    let with = |threads: usize, noise: f64| {
        render(
            &frame,
            &camera,
            &RenderSettings {
                noise: Some(noise),
                threads: Some(threads),
                ..settings(IntegratorKind::Path, 256)
            },
        )
        .0
    };
    let film = with(1, 0.08);
    assert_eq!(film, with(3, 0.08));
    let samples = plane(&film, "samples");
    let least = samples.iter().copied().fold(f32::INFINITY, f32::min);
    let most = samples.iter().copied().fold(0.0, f32::max);
    assert!(
        least >= 16.0 && most <= 256.0 && most > least,
        "{least} to {most}"
    );
    // A finer target takes more everywhere, and comes closer to the truth.
    let finer = plane(&with(2, 0.04), "samples");
    assert!(finer.iter().zip(&samples).all(|(a, b)| a >= b));
    let reference = settings(IntegratorKind::Path, 512);
    let truth = plane(&render(&frame, &camera, &reference).0, "G");
    let error: f64 = plane(&film, "G")
        .iter()
        .zip(&truth)
        .map(|(a, b)| (f64::from(a - b) / (f64::from(*b) + 0.05)).powi(2))
        .sum();
    let error = (error / truth.len() as f64).sqrt();
    assert!(error < 0.08, "{error}");
}

#[test]
fn a_time_limit_ends_the_picture_evenly_sampled() {
    let (frame, camera) = scene(Material::diffuse(Color([0.5; 3])));
    let limited = RenderSettings {
        time_limit: Some(Duration::from_millis(1)),
        ..settings(IntegratorKind::Path, 100_000)
    };
    let (film, stats) = render(&frame, &camera, &limited);
    let samples = plane(&film, "samples");
    assert!(samples.iter().all(|&n| n == samples[0] && n >= 1.0));
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert_eq!(stats.rays.primary, samples[0] as u64 * pixels);
}
