//! The device's answers against the float64 oracle: the rays and the rule of every engine's suite.

use crate::common::{Gpu, device};
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::field::{Motion, Search};
use meniscus::frame::Blobs;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus_gpu::TracerOptions;
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::Question;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints};

const EYES: [DVec3; 2] = [DVec3::new(0.3, 0.5, 1.0), DVec3::new(-1.0, 0.1, -0.2)];
const BOTH: [Question; 2] = [Question::ClosestTogether, Question::AnyTogether];

/// Every kind of set with one kernel each.
fn some_scenes() -> Vec<Scene> {
    let kinds = corpus::KINDS.iter().enumerate();
    kinds
        .map(|(i, kind)| corpus::scene(kind, Kernel::ALL[i % Kernel::ALL.len()], 400))
        .collect()
}

#[expect(clippy::print_stderr, reason = "how many rays went where")]
fn check(
    test: &str,
    scenes: &[Scene],
    options: TracerOptions,
    rays_of: impl Fn(&Stage) -> Vec<Ray>,
) {
    let Some(device) = device(test) else {
        return;
    };
    let mut problems = Vec::new();
    let (mut traced, mut on_cpu) = (0, 0);
    for scene in scenes {
        let oracle = Oracle::new(&scene.field);
        let stage = Stage::new(scene, &oracle, 120);
        let rays = rays_of(&stage);
        let blobs = Blobs::build(scene.field.clone(), Engine::Particles, Level::new());
        let gpu = Gpu::new(device, &blobs, options);
        for question in BOTH {
            problems.extend(complaints(&gpu, &stage, &rays, question));
        }
        let work = gpu.work();
        eprintln!(
            "{}: {} rays, {} crowded, {} on the CPU",
            scene.name, work.rays, work.crowded, work.on_cpu
        );
        traced += work.rays;
        on_cpu += work.on_cpu;
    }
    eprintln!(
        "{test}: {traced} rays on {}, {on_cpu} of them answered by the CPU",
        device.describe()
    );
    assert!(traced > 1000, "only {traced} rays");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn ordinary_rays() {
    check(
        "ordinary_rays",
        &corpus::suite(),
        TracerOptions::default(),
        |stage| {
            let mut all = rays::hemisphere(&stage.points, 31);
            for eye in EYES {
                all.extend(rays::primary(stage.oracle, 24, eye));
            }
            rays::shuffled(all, 32)
        },
    );
}

#[test]
fn shadow_rays() {
    check(
        "shadow_rays",
        &some_scenes(),
        TracerOptions::default(),
        |stage| {
            let lights = [DVec3::new(0.4, 0.8, 0.2), DVec3::Y, DVec3::NEG_X];
            let towards = |light: DVec3| rays::shadow(&stage.points, light.normalize());
            lights.into_iter().flat_map(towards).collect()
        },
    );
}

#[test]
fn grazing_rays() {
    check(
        "grazing_rays",
        &some_scenes(),
        TracerOptions::default(),
        |stage| {
            (0..2)
                .flat_map(|seed| rays::grazing(stage.oracle, &stage.points, 41 + seed))
                .collect()
        },
    );
}

#[test]
fn inside_rays() {
    check(
        "inside_rays",
        &some_scenes(),
        TracerOptions::default(),
        |stage| {
            (0..2)
                .flat_map(|seed| rays::inside(stage.oracle, &stage.points, 51 + seed))
                .collect()
        },
    );
}

#[test]
fn evil_rays_and_sets() {
    let evil = |stage: &Stage| {
        let some = &stage.points[..stage.points.len().min(60)];
        let mut all = rays::evil(stage.oracle, some, 61);
        all.extend(rays::primary(stage.oracle, 12, EYES[0]));
        all.extend(rays::grazing(stage.oracle, some, 73));
        all
    };
    let mut scenes = some_scenes();
    scenes.extend(corpus::evil());
    check(
        "evil_rays_and_sets",
        &scenes,
        TracerOptions::default(),
        evil,
    );
}

/// Little room for blobs, and buffers of 16 KiB: what large fields meet on small devices.
#[test]
fn little_room_and_small_buffers() {
    let scenes =
        ["pool", "mixed", "ellipsoids"].map(|kind| corpus::scene(kind, Kernel::Sextic, 400));
    let options = TracerOptions {
        largest_chunk_bytes: Some(1 << 14),
        capacity: Some(8),
    };
    check("little_room_and_small_buffers", &scenes, options, |stage| {
        let mut all = rays::primary(stage.oracle, 24, EYES[0]);
        all.extend(rays::hemisphere(&stage.points, 35));
        all.extend(rays::inside(stage.oracle, &stage.points, 36));
        all
    });
}

/// Rays at times of their own among blobs that move.
#[test]
fn moving_blobs() {
    let Some(device) = device("moving_blobs") else {
        return;
    };
    let shutter = [-0.3, 0.7];
    for (kind, kernel) in [("pool", Kernel::Sextic), ("ellipsoids", Kernel::Quartic)] {
        let mut scene = corpus::scene(kind, kernel, 400);
        let speed = 2.0 * scene.field.spacing;
        let rate = |i: usize, turn: f32| {
            let angle = turn * i as f32;
            [angle.cos() * speed, angle.sin() * speed, 0.3 * speed]
        };
        let count = scene.field.len();
        scene.field.motion = Some(Motion {
            velocities: (0..count).map(|i| rate(i, 2.4)).collect(),
            half_accelerations: (0..count).map(|i| rate(i, -1.1)).collect(),
            velocity_gradients: Vec::new(),
            shutter,
        });
        scene.field.search = Search::default();
        let blobs = Blobs::build(scene.field.clone(), Engine::Particles, Level::new());
        let gpu = Gpu::new(device, &blobs, TracerOptions::default());
        for time in [shutter[0], 0.0, 0.13, shutter[1]] {
            let oracle = Oracle::at(&scene.field, time);
            let stage = Stage::new(&scene, &oracle, 100);
            let mut all = rays::hemisphere(&stage.points, 5);
            all.extend(rays::primary(&oracle, 24, EYES[0]));
            all.extend(rays::grazing(&oracle, &stage.points, 6));
            all.extend(rays::inside(&oracle, &stage.points, 7));
            let all: Vec<Ray> = all.into_iter().map(|ray| Ray { time, ..ray }).collect();
            for question in BOTH {
                let complaint = complaints(&gpu, &stage, &all, question);
                assert_eq!(complaint, None, "{kind} at {time}");
            }
        }
        let work = gpu.work();
        assert!(work.on_cpu * 5 < work.rays, "{kind}: {work:?}");
    }
}

/// What is claimed of a million rays takes a million: `cargo test -p meniscus-gpu --test device -- --ignored`.
#[test]
#[ignore = "takes minutes"]
fn a_million_rays() {
    check(
        "a_million_rays",
        &corpus::suite(),
        TracerOptions::default(),
        |stage| {
            let mut all = rays::hemisphere(&stage.points, 131);
            for eye in EYES {
                all.extend(rays::primary(stage.oracle, 90, eye));
            }
            for seed in 0..10 {
                all.extend(rays::grazing(stage.oracle, &stage.points, 141 + seed));
                all.extend(rays::inside(stage.oracle, &stage.points, 161 + seed));
            }
            rays::shuffled(all, 132)
        },
    );
}
