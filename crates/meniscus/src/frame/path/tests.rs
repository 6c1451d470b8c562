use super::*;
use crate::scene::Matrix;

const SHUTTER: [f64; 2] = [-0.4, 0.6];

fn key(time: f64, angle: f64, scale: DVec3, origin: DVec3) -> PlacementKey {
    let axis = DVec3::new(2.0, 1.0, 2.0) / 3.0;
    PlacementKey {
        time,
        matrix: Matrix(DAffine3::from_scale_rotation_translation(
            scale,
            DQuat::from_axis_angle(axis, angle),
            origin,
        )),
    }
}

fn keys() -> Vec<PlacementKey> {
    vec![
        key(0.0, 0.2, DVec3::ONE, DVec3::new(1.0, 0.0, 0.0)),
        key(
            0.5,
            2.9,
            DVec3::new(1.0, 2.0, 0.7),
            DVec3::new(2.0, 3.0, -1.0),
        ),
        key(
            1.5,
            4.0,
            DVec3::new(1.5, 1.0, 1.0),
            DVec3::new(-2.0, 1.0, 0.0),
        ),
    ]
}

fn moving(keys: &[PlacementKey]) -> InstancePath {
    InstancePath::new(keys, 0.5, SHUTTER).1.unwrap()
}

fn distance(a: &DAffine3, b: &DAffine3) -> f64 {
    let columns = |m: &DAffine3| m.to_cols_array();
    let parts = columns(a).into_iter().zip(columns(b));
    parts.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn paths_go_through_their_keys_and_turn_evenly() {
    let keys = keys();
    let path = InstancePath::new(&keys, 0.5, [-0.5, 1.0]).1.unwrap();
    for key in &keys {
        let there = path.at(key.time - 0.5);
        assert!(distance(&there.world_from_object, &key.matrix.0) < 1e-12);
    }
    // From 0.2 to 2.9 about one axis: a third of the way is a third of the angle.
    let rigid = [
        key(0.0, 0.2, DVec3::ONE, DVec3::ZERO),
        key(3.0, 2.9, DVec3::ONE, DVec3::Z),
    ];
    let path = InstancePath::new(&rigid, 0.0, [0.0, 3.0]).1.unwrap();
    let third = key(1.0, 1.1, DVec3::ONE, DVec3::Z / 3.0);
    assert!(distance(&path.at(1.0).world_from_object, &third.matrix.0) < 1e-12);
    // Mirrors stay mirrors on the way.
    let mirrors = [0.0, 1.0].map(|time| key(time, time, DVec3::new(-1.0, 1.0, 1.0), DVec3::ZERO));
    let path = InstancePath::new(&mirrors, 0.0, [0.0, 1.0]).1.unwrap();
    let there = path.at(0.5).world_from_object.matrix3;
    assert!((there.determinant() + 1.0).abs() < 1e-12);
}

#[test]
fn rates_are_differences() {
    let path = moving(&keys());
    let h = 1e-6;
    for secs in [-0.3, -0.1, 0.2, 0.5] {
        let placement = path.at(secs);
        let [before, after] = [secs - h, secs + h].map(|secs| path.at(secs));
        let difference = |a: DAffine3, b: DAffine3| DAffine3 {
            matrix3: (b.matrix3 - a.matrix3) * (0.5 / h),
            translation: (b.translation - a.translation) / (2.0 * h),
        };
        let there = difference(before.world_from_object, after.world_from_object);
        assert!(distance(&placement.world_from_object_rate, &there) < 1e-6);
        let back = difference(before.object_from_world, after.object_from_world);
        assert!(distance(&placement.object_from_world_rate, &back) < 1e-6);
    }
}

#[test]
fn bounds_hold_the_instance_at_random_times() {
    let path = moving(&keys());
    let mut state = 7_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let object = DAabb {
        min: DVec3::new(-1.0, -0.5, 0.3),
        max: DVec3::new(2.0, 1.0, 1.2),
    };
    for shutter in [SHUTTER, [0.1, 0.2], [-9.0, 9.0]] {
        let bounds = path.bounds(object, shutter);
        let mut touched = DAabb::EMPTY;
        for _ in 0..20_000 {
            let secs = shutter[0] + (shutter[1] - shutter[0]) * next();
            // Corners reach farthest.
            let corner = DVec3::from_array([0, 1, 2].map(|axis| {
                if next() < 0.5 {
                    object.min[axis]
                } else {
                    object.max[axis]
                }
            }));
            let point = path.at(secs).world_from_object.transform_point3(corner);
            touched = touched.including(point);
        }
        assert!(bounds.min.cmple(touched.min).all() && touched.max.cmple(bounds.max).all());
        let slack = bounds.size() - touched.size();
        assert!(slack.max_element() < 0.6 * touched.size().max_element() + 1e-9);
    }
}

#[test]
fn an_instance_at_rest_has_no_path_and_its_key_to_the_last_bit() {
    let [first, .., last] = &keys()[..] else {
        panic!("three keys");
    };
    let with = |keys: &[PlacementKey], frame, shutter| InstancePath::new(keys, frame, shutter);
    let same = [
        *first,
        PlacementKey {
            time: 1.0,
            ..*first
        },
    ];
    assert_eq!(with(&same, 0.5, SHUTTER), (first.matrix.0, None));
    assert_eq!(with(&keys(), -3.0, SHUTTER), (first.matrix.0, None));
    assert_eq!(with(&keys(), 5.0, SHUTTER), (last.matrix.0, None));
    assert_eq!(with(&keys()[..1], 0.0, SHUTTER), (first.matrix.0, None));
    let (still, path) = with(&keys(), 0.75, [0.0; 2]);
    assert!(path.is_none());
    let moving = InstancePath::new(&keys(), 0.75, SHUTTER).0;
    assert!(distance(&still, &moving) < 1e-12);
}
