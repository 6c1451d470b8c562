//! The checks of the suite. Each panics with every complaint it has.

use super::{Stage, complaints, levels};
use crate::corpus::{self, Scene};
use crate::examine::Question;
use crate::oracle::Oracle;
use crate::rays;
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, Scratch};
use meniscus::math::ray::Ray;
use meniscus::math::simd::level_name;
use rayon::prelude::*;

const EYES: [DVec3; 2] = [DVec3::new(0.3, 0.5, 1.0), DVec3::new(-1.0, 0.1, -0.2)];

/// Runs every scene's rays at every SIMD level.
fn check(
    engine: Engine,
    scenes: &[Scene],
    questions: &[Question],
    rays_of: impl Fn(&Stage) -> Vec<Ray> + Sync,
) {
    let mut problems = Vec::new();
    let mut traced = 0;
    for scene in scenes {
        let oracle = Oracle::new(&scene.field);
        let stage = Stage::new(scene, &oracle, 250);
        let rays = rays_of(&stage);
        for level in levels() {
            let blobs = Blobs::build(scene.field.clone(), engine, level);
            for &question in questions {
                traced += rays.len();
                let complaint = complaints(&blobs, &stage, &rays, question);
                problems.extend(complaint.map(|text| format!("{}: {text}", level_name(level))));
            }
        }
    }
    assert!(traced > 1000, "the suite had only {traced} rays");
    assert!(problems.is_empty(), "{engine:?}:\n{}", problems.join("\n"));
}

/// Primary rays, and one cosine-distributed ray from each surface point.
///
/// # Panics
/// On any real error.
pub fn ordinary_rays(engine: Engine) {
    check(engine, &corpus::suite(), &[Question::Closest], |stage| {
        let mut all = rays::hemisphere(&stage.points, 31);
        for eye in EYES {
            all.extend(rays::primary(stage.oracle, 24, eye));
        }
        rays::shuffled(all, 32)
    });
}

/// Shadow rays from surface points, which must not meet the surface that they start on.
///
/// # Panics
/// On any real error.
pub fn shadow_rays(engine: Engine) {
    let questions = [Question::Any, Question::Closest];
    check(engine, &corpus::suite(), &questions, |stage| {
        let lights = [DVec3::new(0.4, 0.8, 0.2), DVec3::Y, DVec3::NEG_X];
        let towards = |light: DVec3| rays::shadow(&stage.points, light.normalize());
        lights.into_iter().flat_map(towards).collect()
    });
}

/// Rays that touch, nearly touch, or barely cut the surface.
///
/// # Panics
/// On any real error.
pub fn grazing_rays(engine: Engine) {
    check(engine, &corpus::suite(), &[Question::Closest], |stage| {
        (0..2)
            .flat_map(|seed| rays::grazing(stage.oracle, &stage.points, 41 + seed))
            .collect()
    });
}

/// Bundles of rays that lie close together, asked about at once.
///
/// # Panics
/// On any real error.
pub fn bundles(engine: Engine) {
    let questions = [Question::ClosestTogether, Question::AnyTogether];
    check(engine, &corpus::suite(), &questions, |stage| {
        let some = &stage.points[..stage.points.len().min(60)];
        let mut all = rays::primary(stage.oracle, 8, EYES[0]);
        all.extend(rays::hemisphere(some, 45));
        all.extend(rays::shadow(some, DVec3::new(0.4, 0.8, 0.2).normalize()));
        all.extend(rays::grazing(stage.oracle, some, 46));
        all.extend(rays::inside(stage.oracle, some, 47));
        rays::bundles(&all, 48)
    });
}

/// Rays from inside, with and without their side stated.
///
/// # Panics
/// On any real error.
pub fn inside_rays(engine: Engine) {
    check(engine, &corpus::suite(), &[Question::Closest], |stage| {
        (0..2)
            .flat_map(|seed| rays::inside(stage.oracle, &stage.points, 51 + seed))
            .collect()
    });
}

/// Rays that break assumptions, in ordinary scenes.
///
/// # Panics
/// On any real error.
pub fn evil_rays(engine: Engine) {
    let questions = [Question::Closest, Question::Any];
    check(engine, &corpus::suite(), &questions, |stage| {
        let some = &stage.points[..stage.points.len().min(60)];
        rays::evil(stage.oracle, some, 61)
    });
}

/// All kinds of rays in scenes that break assumptions.
///
/// # Panics
/// On any real error.
pub fn evil_sets(engine: Engine) {
    let questions = [
        Question::Closest,
        Question::ClosestTogether,
        Question::Any,
        Question::AnyTogether,
        Question::All,
    ];
    check(engine, &corpus::evil(), &questions, |stage| {
        let mut all = rays::evil(stage.oracle, &stage.points, 71);
        for eye in EYES {
            all.extend(rays::primary(stage.oracle, 16, eye));
        }
        all.extend(rays::hemisphere(&stage.points, 72));
        all.extend(rays::grazing(stage.oracle, &stage.points, 73));
        all.extend(rays::inside(stage.oracle, &stage.points, 74));
        all
    });
}

/// Any hit says what the oracle's first crossing says.
///
/// # Panics
/// On any real error.
pub fn any_hit(engine: Engine) {
    check(engine, &corpus::suite(), &[Question::Any], |stage| {
        let mut all = rays::primary(stage.oracle, 20, EYES[0]);
        all.extend(rays::hemisphere(&stage.points, 81));
        all.extend(rays::grazing(stage.oracle, &stage.points, 82));
        all.extend(rays::inside(stage.oracle, &stage.points, 83));
        all
    });
}

/// Every crossing, in order, alternately entering and leaving.
///
/// # Panics
/// On any real error.
pub fn all_crossings(engine: Engine) {
    check(engine, &corpus::suite(), &[Question::All], |stage| {
        let mut all = rays::primary(stage.oracle, 20, EYES[1]);
        all.extend(rays::hemisphere(&stage.points, 91));
        all.extend(rays::grazing(stage.oracle, &stage.points, 92));
        all.extend(rays::inside(stage.oracle, &stage.points, 93));
        all
    });
}

/// The same bits from one, two and eight threads, from a second build, and from reused buffers.
///
/// # Panics
/// When any bit differs.
pub fn same_for_any_number_of_threads(engine: Engine) {
    let answers = |scene: &Scene, rays: &[Ray], threads: usize| -> Vec<Option<BlobHit>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads start").install(|| {
            let blobs = Blobs::build(
                scene.field.clone(),
                engine,
                meniscus::math::simd::Level::new(),
            );
            rays.par_iter()
                .map_init(Scratch::default, |scratch, ray| blobs.closest(ray, scratch))
                .collect()
        })
    };
    for kind in ["pool", "ellipsoids", "mixed"] {
        let scene = corpus::scene(kind, meniscus::kernel::Kernel::Sextic, 2000);
        let oracle = Oracle::new(&scene.field);
        let rays = rays::primary(&oracle, 40, EYES[0]);
        let first = answers(&scene, &rays, 1);
        assert!(
            first.iter().flatten().count() > 50,
            "{kind}: hardly any hit"
        );
        for threads in [1, 2, 8] {
            let again = answers(&scene, &rays, threads);
            let differ = first
                .iter()
                .zip(&again)
                .filter(|(a, b)| bits(a) != bits(b))
                .count();
            assert_eq!(differ, 0, "{kind}: rays that differ with {threads} threads");
        }
    }
}

fn bits(hit: &Option<BlobHit>) -> Option<([u64; 4], u32, bool)> {
    hit.map(|hit| {
        let numbers = [hit.t, hit.outward.x, hit.outward.y, hit.outward.z];
        (numbers.map(f64::to_bits), hit.strongest, hit.entering)
    })
}
