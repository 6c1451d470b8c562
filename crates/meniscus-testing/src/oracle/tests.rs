use super::{Oracle, marching};
use crate::corpus;
use crate::random::Stream;
use glam::{DMat3, DVec3};
use meniscus::field::{BlobField, Search};
use meniscus::kernel::Kernel;
use meniscus::math::ray::{Ray, Side};
use meniscus::primitive::{Ellipsoid, Shapes};

fn one_ball(kernel: Kernel, radius: f32, weight: f32, threshold: f32) -> BlobField {
    BlobField {
        kernel,
        threshold,
        origin: DVec3::new(3.0, -20.0, 0.5),
        centers: vec![[0.25, 0.5, -0.125]],
        shapes: Shapes::Balls(vec![radius]),
        weights: vec![weight],
        rows: vec![0],
        motion: None,
        attributes: Vec::new(),
        spacing: 1.0,
        search: Search::default(),
    }
}

/// Parameters at which a line meets |A(x − p)|² = q, from the quadratic formula.
fn quadric(field: &BlobField, q: f64, ray: &Ray) -> Option<[f64; 2]> {
    let w = field
        .shapes
        .transform(0, ray.origin - field.origin - field.center(0).as_dvec3());
    let v = field.shapes.transform(0, ray.direction);
    let (a, b, c) = (v.dot(v), w.dot(v), w.dot(w) - q);
    let root = b * b - a * c;
    (root > 0.0).then(|| [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a])
}

#[test]
fn one_ball_and_one_ellipsoid_have_closed_forms() {
    let turned = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(0.4);
    let axes = DMat3::from_diagonal(DVec3::new(0.1, 1.0, 10.0));
    let factor = Ellipsoid::from_metric(turned * axes * turned.transpose()).unwrap();
    let mut hits = 0;
    for kernel in Kernel::ALL {
        let ball = one_ball(kernel, 2.0, 0.75, 0.25);
        let ellipsoid = BlobField {
            shapes: Shapes::Ellipsoids(vec![factor]),
            ..ball.clone()
        };
        for field in [ball, ellipsoid] {
            let oracle = Oracle::new(&field);
            let q = kernel.q_at(0.25 / 0.75).unwrap();
            for i in 0..200 {
                let mut random = Stream::new(5, i);
                let target = field.origin + random.cube() * 2.0 - 1.0;
                let direction = random.direction() * random.log_range(1e-3, 1e3);
                let ray = Ray::new(target - direction * random.range(-1.0, 9.0), direction)
                    .with_range(f64::NEG_INFINITY.max(-1e9), f64::INFINITY);
                let found = oracle.crossings(&ray);
                let Some(expected) = quadric(&field, q, &ray) else {
                    assert!(found.is_empty());
                    continue;
                };
                hits += 1;
                assert_eq!(found.len(), 2, "{kernel:?} {ray:?}");
                assert!(found[0].entering && !found[1].entering);
                let length = direction.length();
                for (c, t) in found.iter().zip(expected) {
                    // `q_at` of wyvill is good to 1e-7 near its flat end.
                    assert!((c.t - t).abs() * length < 1e-6, "{kernel:?}: {} {t}", c.t);
                }
            }
        }
    }
    assert!(hits > 400, "only {hits} rays hit");
}

#[test]
fn crossings_agree_with_interval_marching() {
    let mut changes = 0;
    for scene in corpus::small() {
        let field = &scene.field;
        let oracle = Oracle::new(field);
        let bounds = field.bounds();
        let (min, size) = (
            bounds.min.as_dvec3() + field.origin,
            bounds.size().as_dvec3(),
        );
        for i in 0..12 {
            let mut random = Stream::new(11, i);
            let (a, b) = (min + size * random.cube(), min + size * random.cube());
            let ray = Ray::new(a, b - a).with_range(-0.5, 1.5);
            let found = oracle.crossings(&ray);
            let stretches = marching::signs(field, &ray, 1e-9);
            let side_at = |t: f64| found.iter().take_while(|c| c.t <= t).count();
            let (above, _) = oracle.sign_changes(&ray).unwrap();
            for stretch in stretches.iter().filter(|s| s.above.is_some()) {
                let (from, to) = (side_at(stretch.from), side_at(stretch.to));
                assert_eq!(
                    from, to,
                    "{}: a crossing where the sign is proven",
                    scene.name
                );
                let inside = above != (from % 2 == 1);
                assert_eq!(stretch.above, Some(inside), "{} at {stretch:?}", scene.name);
            }
            changes += found.len();
        }
    }
    assert!(changes > 60, "only {changes} crossings");
}

#[test]
fn a_stated_side_waits_for_the_field_to_return() {
    let field = one_ball(Kernel::Sextic, 2.0, 1.0, 0.25);
    let oracle = Oracle::new(&field);
    let center = field.origin + field.center(0).as_dvec3();
    let inside = Ray::new(center, DVec3::X);
    assert_eq!(oracle.crossings(&inside).len(), 1);
    assert_eq!(oracle.first(&inside.with_side(Side::Outside), None), None);
    let outside = Ray::new(center - DVec3::X * 5.0, DVec3::X).with_side(Side::Inside);
    let first = oracle.first(&outside, None).unwrap();
    assert!(!first.entering && first.t > 5.0);
    let hinted = oracle.first(&outside, Some(first.t)).unwrap();
    assert!((hinted.t - first.t).abs() < 1e-12 && !hinted.entering);
}

#[test]
fn gradients_are_differences_of_values() {
    for scene in corpus::small() {
        let oracle = Oracle::new(&scene.field);
        let center = scene.field.origin + scene.field.center(0).as_dvec3();
        let h = 1e-4 * f64::from(scene.field.shapes.half_extents(0)[0]);
        let point = center + DVec3::new(0.31, 0.17, -0.23) * (1e3 * h);
        let sample = oracle.sample(point);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            let up = oracle.sample(point + axis * h).value;
            let down = oracle.sample(point - axis * h).value;
            let slope = (up - down) / (2.0 * h);
            let scale = 1e-4 * (sample.absolute_slope + sample.absolute / h * 1e-6);
            assert!(
                (slope + sample.outward.dot(axis)).abs() < scale,
                "{}",
                scene.name
            );
        }
    }
}
