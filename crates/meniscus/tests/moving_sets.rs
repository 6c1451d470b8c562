//! A moving set traced through the structure of the frame before is judged by the oracle as a new one is.

use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::field::{Motion, Search};
use meniscus::frame::{Blobs, Update};
use meniscus::kernel::Kernel;
use meniscus::math::simd::Level;
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::examine::Question;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints};

/// The scene with every blob moved by `distance` in a direction of its own.
fn moved(scene: &Scene, distance: f32) -> Scene {
    let mut next = scene.clone();
    next.field.search = Search::default();
    for (i, center) in next.field.centers.iter_mut().enumerate() {
        let turn = 2.4 * i as f32;
        center[0] += distance * turn.cos();
        center[i % 2 + 1] += distance * turn.sin();
    }
    next
}

#[test]
fn updated_structures_trace_the_moved_blobs() {
    for kind in ["pool", "ellipsoids"] {
        let start = corpus::scene(kind, Kernel::Sextic, 3000);
        let spacing = start.field.spacing;
        for engine in [Engine::Particles, Engine::Interval, Engine::Cells] {
            let mut blobs = Blobs::build(start.field.clone(), engine, Level::new());
            let mut done = Vec::new();
            for distance in [0.1, 0.2, 40.0] {
                let next = moved(&start, distance * spacing);
                done.push(blobs.update(next.field.clone()));
                let oracle = Oracle::new(&next.field);
                let stage = Stage::new(&next, &oracle, 100);
                let mut all = rays::hemisphere(&stage.points, 5);
                all.extend(rays::primary(&oracle, 40, DVec3::new(0.3, 0.5, 1.0)));
                let complaint = complaints(&blobs, &stage, &all, Question::Closest);
                assert_eq!(complaint, None, "{engine:?}, {distance} spacings");
            }
            let first = match engine {
                Engine::Cells => Update::Rebuilt,
                _ => Update::Refitted,
            };
            assert_eq!(done, [first, first, Update::Rebuilt], "{kind} {engine:?}");
        }
    }
}

#[test]
fn another_number_of_blobs_is_built_anew() {
    let (few, many) = [200, 300]
        .map(|count| corpus::scene("pool", Kernel::Quartic, count))
        .into();
    let mut blobs = Blobs::build(few.field, Engine::Particles, Level::new());
    assert_eq!(blobs.update(many.field.clone()), Update::Rebuilt);
    assert_eq!(blobs.field.len(), many.field.len());
}

#[test]
fn blobs_that_begin_to_move_are_built_anew() {
    let scene = corpus::scene("pool", Kernel::Quartic, 200);
    let mut moving = scene.field.clone();
    let count = moving.len();
    moving.motion = Some(Motion {
        velocities: vec![[0.1, 0.0, 0.0]; count],
        half_accelerations: vec![[0.0; 3]; count],
        velocity_gradients: Vec::new(),
        shutter: [0.0, 1.0],
    });
    let mut blobs = Blobs::build(scene.field.clone(), Engine::Particles, Level::new());
    assert_eq!(blobs.update(moving.clone()), Update::Rebuilt);
    assert_eq!(blobs.update(moving), Update::Refitted);
    assert_eq!(blobs.update(scene.field), Update::Rebuilt);
}
