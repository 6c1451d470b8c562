use crate::accel::Engine;
use crate::field::{BlobField, Search};
use crate::frame::Blobs;
use crate::intersect::{Crossing, Scratch};
use crate::kernel::Kernel;
use crate::math::ray::{Ray, Side};
use crate::math::simd::Level;
use crate::primitive::{Ellipsoid, Shapes};
use glam::{DMat3, DVec3};

fn field(kernel: Kernel, threshold: f32, blobs: &[([f32; 3], f32, f32)]) -> Blobs {
    let field = BlobField {
        kernel,
        threshold,
        origin: DVec3::new(100.0, 0.0, -3.0),
        centers: blobs.iter().map(|b| b.0).collect(),
        shapes: Shapes::Balls(blobs.iter().map(|b| b.1).collect()),
        weights: blobs.iter().map(|b| b.2).collect(),
        rows: (0..blobs.len() as u32).collect(),
        motion: None,
        attributes: Vec::new(),
        spacing: 1.0,
        search: Search::default(),
    };
    Blobs::build(field, Engine::Sweep, Level::new())
}

fn ray_at(x: f64) -> Ray {
    Ray::new(DVec3::new(100.0 + x, 0.0, -3.0), DVec3::X)
}

fn crossings(blobs: &Blobs, ray: &Ray) -> Vec<Crossing> {
    let mut found = Vec::new();
    blobs.crossings(ray, &mut Scratch::default(), &mut found);
    found
}

#[test]
fn one_ball_has_its_closed_form() {
    for kernel in Kernel::ALL {
        let blobs = field(kernel, 0.2, &[([0.0; 3], 2.0, 0.5)]);
        let radius = 2.0 * kernel.q_at(f64::from(0.2_f32) / 0.5).unwrap().sqrt();
        let mut scratch = Scratch::default();
        let ray = Ray {
            direction: DVec3::X * 4.0,
            ..ray_at(-7.0)
        };
        let hit = blobs.closest(&ray, &mut scratch).unwrap();
        assert!((hit.t - (7.0 - radius) / 4.0).abs() < 1e-7, "{kernel:?}");
        assert!(hit.entering && hit.strongest == 0);
        assert!(hit.outward.normalize().distance(-DVec3::X) < 1e-12);
        let inner = blobs.closest(&ray_at(0.5), &mut scratch).unwrap();
        assert!((inner.t - (radius - 0.5)).abs() < 1e-7 && !inner.entering);
        assert_eq!(crossings(&blobs, &ray).len(), 2);
    }
}

#[test]
fn one_ellipsoid_has_its_closed_form() {
    let metric = DMat3::from_diagonal(DVec3::new(1.0 / 16.0, 1.0, 4.0));
    let blobs = field(Kernel::Octic, 0.3, &[([0.0; 3], 1.0, 1.0)]);
    let field = BlobField {
        shapes: Shapes::Ellipsoids(vec![Ellipsoid::from_metric(metric).unwrap()]),
        ..blobs.field
    };
    let blobs = Blobs::build(field, Engine::Sweep, Level::new());
    let q = Kernel::Octic.q_at(f64::from(0.3_f32)).unwrap();
    let hit = blobs
        .closest(&ray_at(-10.0), &mut Scratch::default())
        .unwrap();
    assert!((hit.t - (10.0 - 4.0 * q.sqrt())).abs() < 1e-7);
}

#[test]
fn a_stated_side_keeps_a_ray_from_hitting_its_own_start() {
    let blobs = field(
        Kernel::Sextic,
        0.5,
        &[([0.0; 3], 2.0, 1.0), ([5.0, 0.0, 0.0], 2.0, 1.0)],
    );
    let mut scratch = Scratch::default();
    let all = crossings(&blobs, &ray_at(-9.0));
    assert_eq!(
        all.iter().map(|c| c.entering).collect::<Vec<_>>(),
        [true, false, true, false]
    );
    // Starts a little outside and a little inside of where the first ball is left.
    for shift in [-1e-6, 0.0, 1e-6] {
        let start = ray_at(-9.0).with_range(all[1].t + shift, f64::INFINITY);
        let hit = blobs
            .closest(&start.with_side(Side::Outside), &mut scratch)
            .unwrap();
        assert!((hit.t - all[2].t).abs() < 1e-9 && hit.entering, "{shift}");
    }
    let start = ray_at(-9.0).with_range(all[0].t - 1e-6, f64::INFINITY);
    let hit = blobs
        .closest(&start.with_side(Side::Inside), &mut scratch)
        .unwrap();
    assert!((hit.t - all[1].t).abs() < 1e-9 && !hit.entering);
    // Never on the stated side again: no hit.
    let past = ray_at(-9.0).with_range(all[3].t + 1e-3, f64::INFINITY);
    assert!(
        blobs
            .closest(&past.with_side(Side::Inside), &mut scratch)
            .is_none()
    );
}

#[test]
fn ranges_end_rays() {
    let blobs = field(Kernel::Quartic, 0.2, &[([0.0; 3], 1.0, 1.0)]);
    let all = crossings(&blobs, &ray_at(-3.0));
    let count = |from, to| crossings(&blobs, &ray_at(-3.0).with_range(from, to)).len();
    assert_eq!(all.len(), 2);
    assert_eq!(count(0.0, all[0].t - 1e-9), 0);
    assert_eq!(count(0.0, all[0].t + 1e-9), 1);
    assert_eq!(count(all[0].t + 1e-9, all[1].t - 1e-9), 0);
    assert_eq!(count(-10.0, all[0].t + 1e-9), 1);
    assert_eq!(count(1.0, 0.0), 0);
    assert_eq!(count(3.0, 3.0), 0);
}

#[test]
fn directions_of_any_length_and_far_origins() {
    let blobs = field(Kernel::Wyvill, 0.2, &[([0.0; 3], 1.0, 1.0)]);
    let exact = crossings(&blobs, &ray_at(-3.0))[0].t;
    let mut scratch = Scratch::default();
    for scale in [1e-150, 1e-5, 7.0, 1e150] {
        let ray = Ray {
            direction: DVec3::new(scale, 0.0, -1e-310),
            ..ray_at(-3.0)
        };
        let hit = blobs.closest(&ray, &mut scratch).unwrap();
        assert!((hit.t * scale - exact).abs() < 1e-12, "{scale}");
    }
    let far = blobs.closest(&ray_at(-1e7), &mut scratch).unwrap();
    assert!((far.t - (1e7 - 3.0 + exact)).abs() < 1e-8);
}

#[test]
fn a_negative_blob_cuts_a_hole() {
    let blobs = field(
        Kernel::Sextic,
        0.3,
        &[([0.0; 3], 2.0, 1.0), ([0.0; 3], 0.5, -2.0)],
    );
    let directions: Vec<bool> = crossings(&blobs, &ray_at(-3.0))
        .iter()
        .map(|c| c.entering)
        .collect();
    assert_eq!(directions, [true, false, true, false]);
}
