use super::*;
use crate::math::aabb::DAabb;
use proptest::prelude::*;

fn front(size: [u32; 2]) -> Camera {
    Camera::new(
        DVec3::Z * 5.0,
        DVec3::ZERO,
        DVec3::Y,
        90_f64.to_radians(),
        size,
    )
    .unwrap()
}

#[test]
fn axes_follow_the_contract() {
    let camera = front([4, 2]);
    assert_eq!(camera.forward, DVec3::NEG_Z);
    assert_eq!(camera.right, DVec3::X);
    assert_eq!(camera.up, DVec3::Y);
    let tilted = Camera::new(
        DVec3::ZERO,
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::Z,
        0.5,
        [3, 3],
    )
    .unwrap();
    let forward = DVec3::new(1.0, 2.0, 3.0).normalize();
    assert!(tilted.right.distance(forward.cross(DVec3::Z).normalize()) < 1e-15);
    assert!(tilted.up.dot(DVec3::Z) > 0.0);
}

#[test]
fn pixel_centres_lie_where_square_pixels_put_them() {
    // 90° at height 2: a pixel is 1 high at distance 1, so centres stand at ±0.5 and ±1.5.
    let camera = front([4, 2]);
    let through = |x: f64, y: f64| {
        let ray = camera.ray([x, y]);
        assert!((ray.direction.length() - 1.0).abs() < 1e-15);
        ray.direction / -ray.direction.z
    };
    assert!(through(0.5, 0.5).distance(DVec3::new(-1.5, 0.5, -1.0)) < 1e-15);
    assert!(through(3.5, 0.5).distance(DVec3::new(1.5, 0.5, -1.0)) < 1e-15);
    assert!(through(3.5, 1.5).distance(DVec3::new(1.5, -0.5, -1.0)) < 1e-15);
    assert!(through(2.0, 1.0).distance(DVec3::NEG_Z) < 1e-15);
    // The top edge in the middle is half the vertical field of view up.
    assert!(through(2.0, 0.0).distance(DVec3::new(0.0, 1.0, -1.0)) < 1e-12);
}

#[test]
fn differentials_are_the_change_from_pixel_to_pixel() {
    let camera = Camera::new(
        DVec3::new(3.0, 1.0, -2.0),
        DVec3::new(0.2, 0.1, 0.4),
        DVec3::Z,
        0.7,
        [640, 480],
    )
    .unwrap();
    let step = 1e-4;
    for film in [[0.5, 0.5], [320.0, 240.0], [600.3, 471.9]] {
        let differential = camera.differential(film);
        assert_eq!(differential.origin, [Vec3::ZERO; 3]);
        for axis in 0..2 {
            let (mut before, mut after) = (film, film);
            before[axis] -= step;
            after[axis] += step;
            let measured =
                (camera.ray(after).direction - camera.ray(before).direction) / (2.0 * step);
            let stated = differential.direction[axis].as_dvec3();
            assert!(measured.distance(stated) < 1e-6 * stated.length() + 1e-11);
        }
    }
}

#[test]
fn projection_inverts_the_ray() {
    let camera = front([64, 48]);
    for film in [[0.5, 0.5], [63.0, 1.0], [32.0, 24.0]] {
        let ray = camera.ray(film);
        let back = camera.project(ray.at(7.0)).unwrap();
        assert!((back[0] - film[0]).abs() < 1e-9 && (back[1] - film[1]).abs() < 1e-9);
        assert!(
            (camera.depth(ray.at(7.0)) - 7.0 * ray.direction.dot(camera.forward)).abs() < 1e-12
        );
    }
    assert_eq!(camera.project(DVec3::Z * 6.0), None);
}

#[test]
fn impossible_cameras_are_refused() {
    let new = |eye, up, fov| Camera::new(eye, DVec3::ZERO, up, fov, [8, 8]);
    assert_eq!(new(DVec3::ZERO, DVec3::Y, 1.0), Err(CameraError::Direction));
    assert_eq!(new(DVec3::NAN, DVec3::Y, 1.0), Err(CameraError::Direction));
    assert_eq!(
        new(DVec3::INFINITY, DVec3::Y, 1.0),
        Err(CameraError::Direction)
    );
    assert_eq!(new(DVec3::Y, DVec3::Y, 1.0), Err(CameraError::Up));
    assert_eq!(new(DVec3::Y, DVec3::ZERO, 1.0), Err(CameraError::Up));
    assert_eq!(new(DVec3::Y, DVec3::NAN, 1.0), Err(CameraError::Up));
    for fov in [0.0, -1.0, std::f64::consts::PI, f64::NAN] {
        assert_eq!(new(DVec3::Z, DVec3::Y, fov), Err(CameraError::Fov));
    }
}

#[test]
fn a_given_eye_or_target_is_kept() {
    let bounds = DAabb {
        min: DVec3::new(1.0, 2.0, 3.0),
        max: DVec3::new(3.0, 4.0, 5.0),
    };
    let mut settings = CameraSettings {
        eye: Some(DVec3::new(9.0, 1.0, 0.0)),
        ..CameraSettings::default()
    };
    let camera = Camera::from_settings(&settings, bounds, [32, 32]).unwrap();
    assert_eq!(camera.eye, DVec3::new(9.0, 1.0, 0.0));
    let towards = (DVec3::new(2.0, 3.0, 4.0) - camera.eye).normalize();
    assert!(camera.forward.distance(towards) < 1e-15);

    settings = CameraSettings {
        target: Some(DVec3::new(1.0, 2.0, 3.0)),
        ..CameraSettings::default()
    };
    let camera = Camera::from_settings(&settings, bounds, [32, 32]).unwrap();
    let seen = camera.project(DVec3::new(1.0, 2.0, 3.0)).unwrap();
    assert!((seen[0] - 16.0).abs() < 1e-9 && (seen[1] - 16.0).abs() < 1e-9);
    assert_in_picture(&camera, bounds);
}

fn assert_in_picture(camera: &Camera, bounds: DAabb) {
    for corner in 0..8 {
        let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
        let [x, y] = camera
            .project(DVec3::new(pick(0), pick(1), pick(2)))
            .expect("every corner is before the eye");
        assert!(
            x >= 0.0 && x <= f64::from(camera.size[0]),
            "corner {corner} at {x}, {y}"
        );
        assert!(
            y >= 0.0 && y <= f64::from(camera.size[1]),
            "corner {corner} at {x}, {y}"
        );
    }
}

proptest! {
    #[test]
    fn framing_contains_every_corner_with_a_small_margin(
        low in prop::array::uniform3(-1e3_f64..1e3),
        size in prop::array::uniform3(0.0_f64..1e3),
        fov in 1_f64..150.0,
        size_px in prop::array::uniform2(1_u32..3000),
        axis in 0_usize..6,
    ) {
        let min = DVec3::from_array(low);
        let bounds = DAabb { min, max: min + DVec3::from_array(size) };
        let up = [DVec3::X, DVec3::Y, DVec3::Z][axis % 3] * if axis < 3 { 1.0 } else { -1.0 };
        let camera = Camera::framing(bounds, up, fov.to_radians(), size_px).unwrap();
        assert_in_picture(&camera, bounds);
        // From above, and upright.
        prop_assert!(camera.forward.dot(up) < 0.0 && camera.up.dot(up) > 0.0);
        // No farther than needed: some corner comes near the edge.
        let nearest_edge = (0..8).map(|corner| {
            let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
            let [x, y] = camera.project(DVec3::new(pick(0), pick(1), pick(2))).unwrap();
            let [w, h] = size_px.map(f64::from);
            (x / w).min(1.0 - x / w).min((y / h).min(1.0 - y / h))
        }).fold(1.0, f64::min);
        prop_assert!(nearest_edge < 0.06, "margin {nearest_edge}");
    }
}

#[test]
fn bounds_without_size_are_framed() {
    let at = |min: DVec3, max: DVec3| {
        Camera::framing(DAabb { min, max }, DVec3::Y, 0.7, [1280, 720]).unwrap()
    };
    let far = DVec3::new(1e6, -2e6, 3e6);
    for point in [DVec3::ZERO, far, DVec3::splat(1e-30)] {
        let camera = at(point, point);
        let [x, y] = camera.project(point).unwrap();
        assert!(
            (x - 640.0).abs() < 1e-3 && (y - 360.0).abs() < 1e-3,
            "{point}: {x}, {y}"
        );
    }
    assert_in_picture(
        &at(far, far + DVec3::X),
        DAabb {
            min: far,
            max: far + DVec3::X,
        },
    );
    let nothing = Camera::framing(DAabb::EMPTY, DVec3::Y, 0.7, [4, 4]).unwrap();
    assert!(nothing.eye.is_finite());
    let infinite = at(DVec3::NEG_INFINITY, DVec3::INFINITY);
    assert!(infinite.eye.is_finite());
}

#[test]
fn up_is_read_by_name_and_by_numbers() {
    assert_eq!("-z".parse(), Ok(Up(DVec3::NEG_Z)));
    assert_eq!("1, 2,-3".parse(), Ok(Up(DVec3::new(1.0, 2.0, -3.0))));
    assert!("w".parse::<Up>().is_err());
    assert!("1,2".parse::<Up>().is_err());
}
