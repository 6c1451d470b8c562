//! Ellipsoids that turn and stretch while the shutter is open, judged by the oracle on the field as it
//! stands at the time of each ray.

use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::field::{BlobField, MOST_TURN};
use meniscus::frame::Blobs;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus_testing::corpus;
use meniscus_testing::examine::Question;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints, levels};
use meniscus_testing::turning::{SHUTTER_SECS, frozen, turning};

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
