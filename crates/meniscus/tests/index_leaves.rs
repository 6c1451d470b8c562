//! Engine `cells` with leaves of indices: the answers of leaves of copies to the last bit, in less memory.

use glam::DVec3;
use meniscus::accel::cells::TimedCells;
use meniscus::accel::{Accel, Engine};
use meniscus::field::{BlobField, Motion, Search};
use meniscus::frame::Blobs;
use meniscus::intersect::Scratch;
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus::scene::{EngineSettings, Leaves};
use meniscus_testing::corpus;
use meniscus_testing::oracle::Oracle;
use meniscus_testing::random::Stream;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, levels};

const SHUTTER_SECS: [f64; 2] = [-0.3, 0.7];

/// `field` with blobs that fly together, each a little off the way of the others, on bent ways if `bent`.
fn moving(field: &BlobField, bent: bool) -> BlobField {
    let spacing = field.spacing;
    let rate = |i: usize, salt: u64, together: [f32; 3]| {
        let mut random = Stream::new(salt, i as u64);
        together.map(|speed| spacing * (speed + 0.1 * (random.unit() as f32 - 0.5)))
    };
    let motion = Motion {
        velocities: (0..field.len())
            .map(|i| rate(i, 3, [0.5, -0.2, 0.1]))
            .collect(),
        half_accelerations: (0..field.len())
            .map(|i| rate(i, 4, [-0.1, 0.3, 0.0]).map(|rate| if bent { rate } else { 0.0 }))
            .collect(),
        velocity_gradients: Vec::new(),
        shutter: SHUTTER_SECS,
    };
    BlobField {
        motion: Some(motion),
        search: Search::default(),
        ..field.clone()
    }
}

fn built(field: &BlobField, leaves: Leaves, level: Level) -> Blobs {
    let settings = EngineSettings {
        leaves,
        ..EngineSettings::default()
    };
    let mut blobs = Blobs::build_with(field.clone(), Engine::Cells, settings, level);
    if blobs.accel.engine() != Engine::Cells {
        // Nobody would ask for cells where blobs fly apart, but they have to be right.
        blobs.accel = Accel::Cells(TimedCells::build(field, 1, leaves));
    }
    blobs
}

/// Compares both kinds of leaves on rays one by one and together, at times all over the shutter.
fn compare(name: &str, field: &BlobField, rays: &[Ray], level: Level) {
    let [open, close] = SHUTTER_SECS;
    let timed: Vec<Ray> = rays
        .iter()
        .enumerate()
        .map(|(i, ray)| Ray {
            time: open + (close - open) * Stream::new(9, i as u64 / 16).unit(),
            ..*ray
        })
        .collect();
    let [copies, indices] =
        [Leaves::Copies, Leaves::Indices].map(|leaves| built(field, leaves, level));
    let mut scratch = Scratch::default();
    let mut hits = 0;
    for (i, ray) in timed.iter().enumerate() {
        let expected = copies.closest(ray, &mut scratch);
        assert_eq!(
            indices.closest(ray, &mut scratch),
            expected,
            "{name}: ray {i}, alone"
        );
        hits += usize::from(expected.is_some());
    }
    assert!(hits > 0, "{name}: no ray hit");
    let mut answers = [vec![None; rays.len()], vec![None; rays.len()]];
    let mut blocked = [vec![false; rays.len()], vec![false; rays.len()]];
    for (i, blobs) in [&copies, &indices].into_iter().enumerate() {
        blobs.closest_many(&timed, &mut answers[i], &mut scratch);
        blobs.occluded_many(&timed, &mut blocked[i], &mut scratch);
    }
    assert!(answers[0] == answers[1], "{name}: first hits together");
    assert!(blocked[0] == blocked[1], "{name}: any hits together");
    let [more, less] = [&copies, &indices].map(|blobs| blobs.accel.structure_bytes());
    assert!(
        less < more,
        "{name}: {less} bytes with indices, {more} with copies"
    );
}

#[test]
fn hits_are_those_of_copies_in_less_memory() {
    for scene in corpus::suite() {
        let oracle = Oracle::new(&scene.field);
        let stage = Stage::new(&scene, &oracle, 60);
        let mut rays = rays::primary(&oracle, 24, DVec3::new(0.3, 0.5, 1.0));
        rays.extend(rays::shadow(&stage.points, DVec3::new(0.2, 0.9, 0.4)));
        rays.extend(rays::hemisphere(&stage.points, 5));
        rays.extend(rays::inside(&oracle, &stage.points, 6));
        for level in levels() {
            compare(&scene.name, &scene.field, &rays, level);
        }
        let level = Level::new();
        for bent in [false, true] {
            let name = format!("{} moving, bent {bent}", scene.name);
            compare(&name, &moving(&scene.field, bent), &rays, level);
        }
    }
}
