//! Engines that are wrong on purpose must be caught.

use super::{Stage, complaints};
use crate::corpus;
use crate::examine::{Question, Tracer, examine};
use crate::oracle::Oracle;
use crate::rays;
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::frame::Blobs;
use meniscus::intersect::{BlobHit, Crossing, Scratch};
use meniscus::kernel::Kernel;
use meniscus::math::ray::{Ray, Side};
use meniscus::math::simd::Level;

/// Spoils an engine's answers.
struct Spoiled<F: Fn(&Ray, Option<BlobHit>) -> Option<BlobHit> + Sync> {
    blobs: Blobs,
    forget_side: bool,
    spoil: F,
}

impl<F: Fn(&Ray, Option<BlobHit>) -> Option<BlobHit> + Sync> Tracer for Spoiled<F> {
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        let asked = if self.forget_side {
            ray.with_side(Side::Unknown)
        } else {
            *ray
        };
        (self.spoil)(ray, self.blobs.closest(&asked, scratch))
    }

    fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.closest(ray, scratch).is_some()
    }

    fn crossings(&self, ray: &Ray, scratch: &mut Scratch) -> Vec<Crossing> {
        let mut found = Vec::new();
        self.blobs.crossings(ray, scratch, &mut found);
        found.retain(|c| (self.spoil)(ray, Some(hit_at(c))).is_some());
        found
    }
}

fn hit_at(crossing: &Crossing) -> BlobHit {
    BlobHit {
        t: crossing.t,
        outward: DVec3::X,
        strongest: 0,
        entering: crossing.entering,
    }
}

/// The kinds of fault found in primary, hemisphere and grazing rays of a pool.
fn faults(
    forget_side: bool,
    spoil: impl Fn(&Ray, Option<BlobHit>) -> Option<BlobHit> + Sync,
    question: Question,
) -> Vec<String> {
    let scene = corpus::scene("pool", Kernel::Sextic, 300);
    let oracle = Oracle::new(&scene.field);
    let stage = Stage::new(&scene, &oracle, 300);
    let mut all = rays::primary(&oracle, 24, DVec3::new(0.2, 0.6, 1.0));
    all.extend(rays::hemisphere(&stage.points, 1));
    all.extend(rays::grazing(&oracle, &stage.points, 2));
    let blobs = Blobs::build(scene.field.clone(), Engine::Sweep, Level::new());
    let spoiled = Spoiled {
        blobs,
        forget_side,
        spoil,
    };
    let tally = examine(&spoiled, &oracle, &all, question);
    let complaint = complaints(&spoiled, &stage, &all, question);
    assert_eq!(complaint.is_some(), tally.real_errors() > 0);
    assert!(tally.examples.len() <= tally.real_errors());
    tally.wrong.into_keys().collect()
}

#[test]
fn an_engine_that_is_right_passes() {
    for question in [Question::Closest, Question::Any, Question::All] {
        assert_eq!(faults(false, |_, hit| hit, question), [""; 0]);
    }
}

#[test]
fn a_small_shift_of_t_is_caught() {
    let spacing = f64::from(corpus::scene("pool", Kernel::Sextic, 300).field.spacing);
    let shifted = |_: &Ray, hit: Option<BlobHit>| {
        hit.map(|hit| BlobHit {
            t: hit.t + 3e-4 * spacing,
            ..hit
        })
    };
    assert!(!faults(false, shifted, Question::Closest).is_empty());
}

#[test]
fn lost_and_invented_hits_are_caught() {
    let lossy = |ray: &Ray, hit: Option<BlobHit>| {
        hit.filter(|hit| hit.t.to_bits() % 50 != 0 || ray.t_min > 0.0)
    };
    for question in [Question::Closest, Question::Any, Question::All] {
        let found = faults(false, lossy, question);
        assert!(!found.is_empty(), "{question:?}");
    }
    let inventive = |ray: &Ray, hit: Option<BlobHit>| {
        let middle = BlobHit {
            t: ray.t_min + 0.3,
            outward: DVec3::X,
            strongest: 0,
            entering: true,
        };
        hit.or(Some(middle))
    };
    for question in [Question::Closest, Question::Any] {
        let found = faults(false, inventive, question);
        assert_eq!(found, ["Invented"], "{question:?}");
    }
}

#[test]
fn wrong_directions_normals_and_blobs_are_caught() {
    let flipped = |_: &Ray, hit: Option<BlobHit>| {
        hit.map(|hit| BlobHit {
            entering: !hit.entering,
            ..hit
        })
    };
    assert_eq!(faults(false, flipped, Question::Closest), ["Direction"]);
    let bent = |_: &Ray, hit: Option<BlobHit>| {
        hit.map(|hit| BlobHit {
            outward: hit.outward
                + 0.01 * hit.outward.any_orthonormal_vector() * hit.outward.length(),
            ..hit
        })
    };
    assert_eq!(faults(false, bent, Question::Closest), ["Normal"]);
    let renamed = |_: &Ray, hit: Option<BlobHit>| {
        hit.map(|hit| BlobHit {
            strongest: hit.strongest / 2,
            ..hit
        })
    };
    assert_eq!(faults(false, renamed, Question::Closest), ["Strongest"]);
}

#[test]
fn an_engine_that_forgets_the_stated_side_is_caught() {
    let found = faults(true, |_, hit| hit, Question::Closest);
    assert!(found.contains(&"HitsItsStart".to_string()), "{found:?}");
}

#[test]
fn an_engine_that_misses_what_it_only_grazes_is_caught() {
    // Passes over excursions shorter than a tenth of a spacing, as one with too long steps does.
    let scene = corpus::scene("pool", Kernel::Sextic, 300);
    let spacing = f64::from(scene.field.spacing);
    let oracle = Oracle::new(&scene.field);
    let coarse = |ray: &Ray, hit: Option<BlobHit>| {
        let crossings = oracle.crossings(ray);
        let short = crossings.len() > 1 && crossings[1].t - crossings[0].t < 0.1 * spacing;
        hit.filter(|_| !short)
    };
    assert_eq!(faults(false, coarse, Question::Closest), ["Missed"]);
}
