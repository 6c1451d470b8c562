//! The GPU's answers against the float64 oracle: the rays and the rule of every engine's suite.
//!
//! Without an adapter that runs shaders these tests say so and pass; where `MENISCUS_REQUIRE_GPU=1`, as in
//! CI, they fail.

mod common;

use common::{Gpu, device};
use glam::DVec3;
use meniscus::accel::Engine;
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
        println!(
            "{}: {} rays, {} crowded, {} on the CPU",
            scene.name, work.rays, work.crowded, work.on_cpu
        );
        traced += work.rays;
        on_cpu += work.on_cpu;
    }
    println!(
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
        &corpus::suite(),
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
        &corpus::suite(),
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
        &corpus::suite(),
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
    let mut scenes = corpus::suite();
    scenes.extend(corpus::evil());
    check(
        "evil_rays_and_sets",
        &scenes,
        TracerOptions::default(),
        evil,
    );
}

/// Little room for blobs, and buffers of 4 KiB: what large fields meet on small devices.
#[test]
fn little_room_and_small_buffers() {
    let scenes: Vec<Scene> = corpus::KINDS
        .iter()
        .map(|kind| corpus::scene(kind, Kernel::Sextic, 400))
        .collect();
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
