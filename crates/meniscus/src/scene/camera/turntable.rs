//! A camera that goes round an object.

use super::Camera;
use glam::{DQuat, DVec3};

impl Camera {
    /// The camera turned about the axis through `center` along `up` (a unit vector) by `angle`
    /// radians, to the right as it sees the object; it stands still there.
    #[must_use]
    pub fn turned(&self, center: DVec3, up: DVec3, angle: f64) -> Self {
        let turn = DQuat::from_axis_angle(up, angle);
        Self {
            eye: center + turn * (self.eye - center),
            forward: turn * self.forward,
            right: turn * self.right,
            up: turn * self.up,
            path: None,
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_keeps_height_distance_and_what_is_in_the_middle() {
        let center = DVec3::new(1.0, 2.0, 3.0);
        let eye = DVec3::new(1.0, 5.0, 13.0);
        let camera = Camera::new(eye, center, DVec3::Y, 0.7, [64, 48]).unwrap();
        let quarter = camera.turned(center, DVec3::Y, std::f64::consts::FRAC_PI_2);
        assert!(
            quarter.eye.distance(DVec3::new(11.0, 5.0, 3.0)) < 1e-12,
            "{}",
            quarter.eye
        );
        let [x, y] = quarter.project(center).unwrap();
        assert!((x - 32.0).abs() < 1e-9 && (y - 24.0).abs() < 1e-9);
        let middle = quarter.ray([32.0, 24.0]);
        assert!(
            middle
                .direction
                .distance((center - quarter.eye).normalize())
                < 1e-12
        );
        let aside = quarter.ray([40.0, 9.0]);
        let [x, y] = quarter.project(aside.at(5.0)).unwrap();
        assert!((x - 40.0).abs() < 1e-9 && (y - 9.0).abs() < 1e-9, "{x} {y}");
        let whole = camera.turned(center, DVec3::Y, std::f64::consts::TAU);
        assert!(whole.eye.distance(eye) < 1e-12 && whole.right.distance(camera.right) < 1e-12);
    }
}
