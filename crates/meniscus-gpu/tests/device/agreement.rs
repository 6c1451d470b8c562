//! The device's answers against the float64 oracle: the rays and the rule of every engine's suite.

use crate::common::{Gpu, SHUTTER, blobs, device, moving};
use glam::DVec3;
use meniscus::field::MOST_TURN;
use meniscus::intersect::Scratch;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::scene::Builder;
use meniscus_gpu::TracerOptions;
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::{Question, Tracer};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints};
use meniscus_testing::turning::{SHUTTER_SECS, frozen, turning};

const EYES: [DVec3; 2] = [DVec3::new(0.3, 0.5, 1.0), DVec3::new(-1.0, 0.1, -0.2)];
const BOTH: [Question; 2] = [Question::ClosestTogether, Question::AnyTogether];

/// Every kind of set with one kernel each.
fn some_scenes() -> Vec<Scene> {
    let kinds = corpus::KINDS.iter().enumerate();
    kinds
        .map(|(i, kind)| corpus::scene(kind, Kernel::ALL[i % Kernel::ALL.len()], 400))
        .collect()
}

fn check(
    test: &str,
    scenes: &[Scene],
    options: TracerOptions,
    rays_of: impl Fn(&Stage) -> Vec<Ray>,
) {
    check_tree_of(Builder::Sah, test, scenes, options, rays_of);
}

#[expect(clippy::print_stderr, reason = "how many rays went where")]
fn check_tree_of(
    builder: Builder,
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
        let blobs = blobs(scene.field.clone(), builder);
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

/// The same rays on trees that the device built.
#[test]
fn trees_of_the_device() {
    let rays_of = |stage: &Stage| {
        let mut all = rays::hemisphere(&stage.points, 31);
        all.extend(rays::primary(stage.oracle, 24, EYES[0]));
        all.extend(rays::grazing(stage.oracle, &stage.points, 41));
        all.extend(rays::inside(stage.oracle, &stage.points, 51));
        rays::shuffled(all, 33)
    };
    let mut scenes = some_scenes();
    scenes.extend(corpus::evil());
    let options = TracerOptions::default();
    check_tree_of(
        Builder::Device,
        "trees_of_the_device",
        &scenes,
        options,
        rays_of,
    );
    let small = TracerOptions {
        largest_chunk_bytes: Some(1 << 13),
        capacity: None,
    };
    let scenes = ["pool", "ellipsoids"].map(|kind| corpus::scene(kind, Kernel::Sextic, 400));
    check_tree_of(
        Builder::Device,
        "trees_of_the_device",
        &scenes,
        small,
        rays_of,
    );
}

/// Long ways through many blobs: more rounds than llvmpipe lets loops run, which has to be noticed.
#[test]
fn long_ways_inside() {
    let Some(device) = device("long_ways_inside") else {
        return;
    };
    let scene = corpus::scene("pool", Kernel::Quartic, 40_000);
    let blobs = blobs(scene.field.clone(), Builder::Morton);
    let gpu = Gpu::new(device, &blobs, TracerOptions::default());
    let field = &scene.field;
    let rays: Vec<Ray> = (0..100)
        .map(|i| {
            let origin = field.origin + field.center(i * 397 % field.len()).as_dvec3();
            let angle = 2.4 * i as f64;
            let direction = DVec3::new(angle.cos(), 0.3 * (0.7 * angle).sin(), angle.sin());
            Ray::new(origin, direction.normalize())
        })
        .collect();
    let mut scratch = Scratch::default();
    let ours = gpu.closest_many(&rays, &mut scratch);
    let tolerance = 1e-4 * f64::from(field.spacing);
    for (ray, ours) in rays.iter().zip(ours) {
        let theirs = blobs.closest(ray, &mut scratch);
        let [ours, theirs] = [ours, theirs].map(|hit| hit.map_or(f64::INFINITY, |hit| hit.t));
        assert!(
            ours == theirs || (ours - theirs).abs() <= tolerance,
            "{ours}, not {theirs}"
        );
    }
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
    for (kind, kernel, builder) in [
        ("pool", Kernel::Sextic, Builder::Sah),
        ("ellipsoids", Kernel::Quartic, Builder::Sah),
        ("ellipsoids", Kernel::Octic, Builder::Device),
        ("mixed", Kernel::Wyvill, Builder::Device),
    ] {
        let scene = moving(corpus::scene(kind, kernel, 400));
        let shutter = SHUTTER;
        let blobs = blobs(scene.field.clone(), builder);
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

/// The same among ellipsoids that turn and stretch; their trees are the processor's, whoever is asked.
#[test]
fn turning_blobs() {
    let Some(device) = device("turning_blobs") else {
        return;
    };
    for (turn, kernel, builder) in [
        (0.05, Kernel::Quartic, Builder::Sah),
        (0.4, Kernel::Sextic, Builder::Sah),
        (0.99 * MOST_TURN, Kernel::Wyvill, Builder::Device),
    ] {
        let scene = turning(&corpus::scene("ellipsoids", kernel, 300), turn);
        let blobs = blobs(scene.field.clone(), builder);
        let gpu = Gpu::new(device, &blobs, TracerOptions::default());
        for time in [SHUTTER_SECS[0], 0.0, 0.23, SHUTTER_SECS[1]] {
            let frozen = frozen(&scene, time);
            let oracle = Oracle::new(&frozen.field);
            let stage = Stage::new(&frozen, &oracle, 80);
            let mut all = rays::hemisphere(&stage.points, 5);
            all.extend(rays::primary(&oracle, 24, EYES[0]));
            all.extend(rays::grazing(&oracle, &stage.points, 6));
            all.extend(rays::inside(&oracle, &stage.points, 7));
            let all: Vec<Ray> = all.into_iter().map(|ray| Ray { time, ..ray }).collect();
            for question in BOTH {
                let complaint = complaints(&gpu, &stage, &all, question);
                assert_eq!(complaint, None, "{turn} at {time}");
            }
        }
        let work = gpu.work();
        assert!(work.on_cpu * 5 < work.rays, "{turn}: {work:?}");
    }
}

/// What is claimed of a million rays takes a million: `cargo test -p meniscus-gpu --test device -- --ignored`.
#[test]
#[ignore = "takes minutes: run by benches/gpu.sh"]
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
