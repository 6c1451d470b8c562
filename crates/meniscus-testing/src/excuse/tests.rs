use super::{Fault, Reason, Verdict, judge_closest, judge_crossings, judge_occluded};
use crate::oracle::Oracle;
use glam::DVec3;
use meniscus::field::{BlobField, Search};
use meniscus::intersect::BlobHit;
use meniscus::kernel::Kernel;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::Shapes;

/// A ball about the origin whose surface has the radius 1.
fn ball() -> BlobField {
    let q = Kernel::Quartic.q_at(0.25).unwrap();
    BlobField {
        kernel: Kernel::Quartic,
        threshold: 0.25,
        origin: DVec3::ZERO,
        centers: vec![[0.0; 3]],
        shapes: Shapes::Balls(vec![(1.0 / q.sqrt()) as f32]),
        weights: vec![1.0],
        rows: vec![0],
        motion: None,
        attributes: Vec::new(),
        spacing: 1.0,
        search: Search::default(),
    }
}

/// A ray along x that passes the surface's top at this height above it.
fn over(height: f64) -> Ray {
    Ray::new(DVec3::new(-5.0, 1.0 + height, 0.0), DVec3::X)
}

fn hit(ray: &Ray, t: f64, entering: bool) -> BlobHit {
    BlobHit {
        t,
        outward: ray.at(t),
        strongest: 0,
        entering,
    }
}

fn reason(verdict: Verdict) -> Option<Reason> {
    match verdict {
        Verdict::Excused { reason, .. } => Some(reason),
        _ => None,
    }
}

#[test]
fn only_what_stays_within_the_band_is_excused() {
    let field = ball();
    let oracle = Oracle::new(&field);
    // The field falls by 1 per length here: these excursions are 2e-6 and 1e-3 high.
    let (shallow, deep) = (over(-2e-6), over(-1e-3));
    assert_eq!(oracle.crossings(&shallow).len(), 2);
    let excused = judge_closest(&oracle, &shallow, None);
    assert_eq!(reason(excused), Some(Reason::SkippedExcursion));
    assert!(!judge_occluded(&oracle, &shallow, false).is_wrong());
    assert!(!judge_crossings(&oracle, &shallow, &[]).is_wrong());
    let missed = Verdict::Wrong(Fault::Missed);
    assert_eq!(judge_closest(&oracle, &deep, None), missed);
    assert_eq!(judge_occluded(&oracle, &deep, false), missed);
    assert_eq!(judge_crossings(&oracle, &deep, &[]), missed);
    // Anywhere in the shallow excursion is as good as its beginning; in the deep one it is not.
    let flat = judge_closest(&oracle, &shallow, Some(&hit(&shallow, 5.0, true)));
    assert_eq!(reason(flat), Some(Reason::FlatCrossing));
    assert!(judge_closest(&oracle, &deep, Some(&hit(&deep, 5.0, true))).is_wrong());
}

#[test]
fn a_touch_may_be_counted_where_it_comes_within_the_band() {
    let field = ball();
    let oracle = Oracle::new(&field);
    let (near, clear) = (over(2e-6), over(1e-3));
    let counted = judge_closest(&oracle, &near, Some(&hit(&near, 5.0, true)));
    assert_eq!(reason(counted), Some(Reason::CountedTouch));
    assert!(!judge_occluded(&oracle, &near, true).is_wrong());
    let invented = Verdict::Wrong(Fault::Invented);
    assert_eq!(
        judge_closest(&oracle, &clear, Some(&hit(&clear, 5.0, true))),
        invented
    );
    assert_eq!(judge_occluded(&oracle, &clear, true), invented);
    let leaving = judge_closest(&oracle, &near, Some(&hit(&near, 5.0, false)));
    assert_eq!(leaving, Verdict::Wrong(Fault::Direction));
}

#[test]
fn a_stated_side_forbids_a_hit_at_the_start() {
    let field = ball();
    let oracle = Oracle::new(&field);
    for depth in [-3e-6, 0.0, 3e-6] {
        let start = DVec3::X * (1.0 - depth);
        let away = Ray::new(start, DVec3::X).with_side(Side::Outside);
        assert_eq!(
            judge_closest(&oracle, &away, None),
            Verdict::Match,
            "{depth}"
        );
        for t in [0.0, 1e-6] {
            let acne = judge_closest(&oracle, &away, Some(&hit(&away, t, true)));
            assert_eq!(acne, Verdict::Wrong(Fault::HitsItsStart), "{depth} {t}");
        }
        // Through the ball from inside: only the far side counts.
        let through = Ray::new(start, -DVec3::X).with_side(Side::Inside);
        let far = hit(&through, 2.0 - depth, false);
        assert_eq!(judge_closest(&oracle, &through, Some(&far)), Verdict::Match);
        assert!(judge_closest(&oracle, &through, None).is_wrong());
    }
}

#[test]
fn numbers_that_are_none_are_errors() {
    let field = ball();
    let oracle = Oracle::new(&field);
    let ray = Ray::new(DVec3::X * -5.0, DVec3::X);
    assert_eq!(
        judge_closest(&oracle, &ray, Some(&hit(&ray, 4.0, true))),
        Verdict::Match
    );
    for t in [f64::NAN, -1.0, f64::INFINITY] {
        let judged = judge_closest(&oracle, &ray, Some(&hit(&ray, t, true)));
        assert_eq!(judged, Verdict::Wrong(Fault::Range));
    }
    let unknown_normal = BlobHit {
        outward: DVec3::NAN,
        ..hit(&ray, 4.0, true)
    };
    let judged = judge_closest(&oracle, &ray, Some(&unknown_normal));
    assert_eq!(judged, Verdict::Wrong(Fault::Normal));
    let no_ray = Ray::new(DVec3::NAN, DVec3::X);
    assert_eq!(judge_closest(&oracle, &no_ray, None), Verdict::Match);
    assert!(judge_closest(&oracle, &no_ray, Some(&hit(&ray, 4.0, true))).is_wrong());
}
