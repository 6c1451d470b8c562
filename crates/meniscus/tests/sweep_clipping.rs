//! The papers' clipping rules in engine `sweep`: counted against the float64 oracle, beside our own.

use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::frame::Blobs;
use meniscus::intersect::{Counters, Scratch};
use meniscus::math::simd::Level;
use meniscus::scene::{Clipping, EngineSettings};
use meniscus_testing::corpus;
use meniscus_testing::examine::{Question, Tally, examine};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::Stage;

/// Real errors of primary and grazing rays, and the work of the primary ones.
fn measured(clipping: Clipping) -> (Tally, Tally, Counters) {
    let settings = EngineSettings {
        clipping,
        ..EngineSettings::default()
    };
    let (mut primary, mut grazing) = (Tally::default(), Tally::default());
    let mut scratch = Scratch::default();
    for scene in corpus::suite() {
        let oracle = Oracle::new(&scene.field);
        let stage = Stage::new(&scene, &oracle, 100);
        let field = scene.field.clone();
        let blobs = Blobs::build_with(field, Engine::Sweep, settings, Level::new());
        let straight = rays::primary(&oracle, 20, DVec3::new(0.3, 0.5, 1.0));
        let near = rays::grazing(&oracle, &stage.points, 41);
        for ray in &straight {
            blobs.closest(ray, &mut scratch);
        }
        primary = primary.merge(examine(&blobs, &oracle, &straight, Question::Closest));
        grazing = grazing.merge(examine(&blobs, &oracle, &near, Question::Closest));
    }
    (primary, grazing, scratch.counters)
}

#[test]
fn own_clipping_is_right_and_the_papers_rules_lose_little() {
    let (primary, grazing, work) = measured(Clipping::Own);
    assert_eq!(primary.real_errors() + grazing.real_errors(), 0);
    assert!(work.polynomials > 0 && work.clip_iterations > 0 && work.clip_failures == 0);

    let (primary, grazing, work) = measured(Clipping::Nishita);
    let rate = |tally: &Tally| tally.real_errors() as f64 / tally.rays as f64;
    assert!(rate(&primary) < 5e-3, "{primary}");
    assert!(rate(&grazing) < 0.2, "{grazing}");
    assert!(work.clip_iterations > 0);

    // Its roots are exact to a thousandth of an interval only, which the oracle does not forgive; the
    // side of the root is right nearly always.
    let (primary, _, work) = measured(Clipping::Kanamori);
    let lost = primary.wrong.get("Missed").copied().unwrap_or_default();
    assert!(lost as f64 / (primary.rays as f64) < 0.25, "{primary}");
    assert!(work.clip_iterations > 0);
}

#[test]
fn other_engines_that_need_float64_never_use_the_papers_rules() {
    let scene = &corpus::evil()[0];
    let settings = EngineSettings {
        clipping: Clipping::Kanamori,
        ..EngineSettings::default()
    };
    let field = scene.field.clone();
    let cells = Blobs::build_with(field, Engine::Cells, settings, Level::new());
    let oracle = Oracle::new(&scene.field);
    let straight = rays::primary(&oracle, 8, DVec3::new(0.3, 0.5, 1.0));
    let tally = examine(&cells, &oracle, &straight, Question::All);
    assert_eq!(tally.real_errors(), 0, "{tally}");
}
