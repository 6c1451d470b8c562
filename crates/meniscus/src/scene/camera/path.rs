//! Cameras that move: keyframes in the scene's time.

use super::{Camera, CameraError, CameraSettings, Up};
use crate::math::differential::RayDifferential;
use crate::math::keyframes::{Curve, place};
use crate::math::ray::Ray;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// `[[camera.key]]`: where the camera is at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// When, in seconds of the scene (see [`crate::scene::MotionSettings::time`]); keys come in order.
    pub time: f64,
    /// Where the camera stands, world space.
    pub eye: DVec3,
    /// What it looks at, world space.
    pub target: DVec3,
    /// Which way is up; unset, that of `[camera]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Up>,
    /// Vertical field of view in degrees; unset, that of `[camera]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f64>,
}

/// The way of a camera. Eye, target, up and field of view each follow a smooth curve, and at every time
/// the camera looks from the one at the other: so it turns rigidly and keeps its target in the middle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CameraPath {
    /// Time of the frame, in seconds of the scene.
    pub(super) frame_secs: f64,
    pub(super) eye: Curve,
    target: Curve,
    up: Curve,
    /// Its x is the field of view in radians.
    fov: Curve,
    size: [u32; 2],
    /// At the keys, for where the curves define no camera.
    at_keys: Vec<Camera>,
    pub(super) times: Vec<f64>,
}

impl CameraPath {
    fn new(
        settings: &CameraSettings,
        size: [u32; 2],
        frame_secs: f64,
    ) -> Result<Self, CameraError> {
        let keys = &settings.keys;
        let up = |key: &CameraKey| key.up.unwrap_or(settings.up).vector();
        let fov = |key: &CameraKey| key.fov.unwrap_or(settings.fov).to_radians();
        let times: Vec<f64> = keys.iter().map(|key| key.time).collect();
        let curve = |of: &dyn Fn(&CameraKey) -> DVec3| {
            Curve::new(&times, keys.iter().map(of).collect::<Vec<_>>())
        };
        let at_keys = keys.iter();
        let at_keys = at_keys.map(|key| Camera::new(key.eye, key.target, up(key), fov(key), size));
        Ok(Self {
            frame_secs,
            eye: curve(&|key| key.eye),
            target: curve(&|key| key.target),
            up: curve(&up),
            fov: curve(&|key| DVec3::X * fov(key)),
            size,
            at_keys: at_keys.collect::<Result<_, _>>()?,
            times,
        })
    }

    /// The camera at a time relative to the frame.
    fn try_at(&self, secs: f64) -> Result<Camera, CameraError> {
        let time = self.frame_secs + secs;
        let [eye, target, up, fov] =
            [&self.eye, &self.target, &self.up, &self.fov].map(|curve| curve.at(time));
        Camera::new(eye, target, up, fov.x, self.size)
    }

    /// Where the curves define no camera it looks as at the key before, from where it is.
    pub(super) fn at(&self, secs: f64) -> Camera {
        self.try_at(secs).unwrap_or_else(|_| {
            let time = self.frame_secs + secs;
            let (key, _) = place(&self.times, time);
            Camera {
                eye: self.eye.at(time),
                ..self.at_keys[key].clone()
            }
        })
    }
}

/// Points between two keys at which [`CameraSettings::check_path`] looks for a camera.
const CHECKS: u32 = 32;
/// Step of differences by time, in seconds.
const TIME_STEP: f64 = 1e-6;

impl CameraSettings {
    /// The first time on the way between the keys at which there is no camera, and why; keys are sorted.
    pub fn check_path(&self) -> Option<(f64, CameraError)> {
        for pair in self.keys.windows(2) {
            let path = CameraPath::new(self, [1, 1], 0.0).ok()?;
            for step in 1..CHECKS {
                let part = f64::from(step) / f64::from(CHECKS);
                let time = pair[0].time + (pair[1].time - pair[0].time) * part;
                if let Err(error) = path.try_at(time) {
                    return Some((time, error));
                }
            }
        }
        None
    }
}

impl Camera {
    /// The camera of keys, for a frame at `frame_secs` seconds of the scene.
    pub(super) fn on_path(
        settings: &CameraSettings,
        size: [u32; 2],
        frame_secs: f64,
    ) -> Result<Self, CameraError> {
        let path = CameraPath::new(settings, size, frame_secs)?;
        let now = path.at(0.0);
        Ok(Self {
            path: (settings.keys.len() > 1).then(|| Arc::new(path)),
            ..now
        })
    }

    /// Whether it is elsewhere at other times.
    pub fn moves(&self) -> bool {
        self.path.is_some()
    }

    /// The camera that stands where this one is at a time, in seconds relative to the frame.
    #[must_use]
    pub fn at(&self, secs: f64) -> Self {
        match &self.path {
            None => self.clone(),
            Some(path) => path.at(secs),
        }
    }

    /// [`Camera::ray`] at a time, in seconds relative to the frame.
    #[inline(always)]
    pub fn ray_at(&self, film: [f64; 2], secs: f64) -> Ray {
        let ray = match &self.path {
            None => self.ray(film),
            Some(path) => path.at(secs).ray(film),
        };
        Ray { time: secs, ..ray }
    }

    /// How [`Camera::ray_at`] changes from one pixel to the next, and per second.
    pub fn differential_at(&self, film: [f64; 2], secs: f64) -> RayDifferential {
        let Some(path) = &self.path else {
            return self.differential(film);
        };
        let mut differential = path.at(secs).differential(film);
        let [before, after] = [-TIME_STEP, TIME_STEP].map(|step| path.at(secs + step).ray(film));
        let rate = |from: DVec3, to: DVec3| ((to - from) / (2.0 * TIME_STEP)).as_vec3();
        differential.origin[2] = rate(before.origin, after.origin);
        differential.direction[2] = rate(before.direction, after.direction);
        differential
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, eye: DVec3, target: DVec3) -> CameraKey {
        CameraKey {
            time,
            eye,
            target,
            up: None,
            fov: None,
        }
    }

    fn camera(keys: Vec<CameraKey>, frame_secs: f64) -> Camera {
        let settings = CameraSettings {
            keys,
            ..CameraSettings::default()
        };
        Camera::on_path(&settings, [64, 48], frame_secs).unwrap()
    }

    #[test]
    fn a_camera_on_its_way_keeps_its_target_in_the_middle_and_its_axes_at_right_angles() {
        let target = DVec3::new(0.5, 0.0, 0.2);
        let keys = [(0.0, 0.0_f64), (1.0, 1.2), (2.5, 2.0)].map(|(time, angle)| {
            let eye = DVec3::new(5.0 * angle.sin(), 1.0 + angle, 5.0 * angle.cos());
            CameraKey {
                fov: Some(30.0 + 10.0 * angle),
                ..key(time, eye, target)
            }
        });
        let moving = camera(keys.to_vec(), 1.0);
        assert!(moving.moves());
        for secs in [-1.0, -0.4, 0.0, 0.7, 1.5] {
            let there = moving.at(secs);
            let [x, y] = there.project(target).unwrap();
            assert!((x - 32.0).abs() + (y - 24.0).abs() < 1e-9);
            let axes = [there.right, there.up, there.forward];
            for (i, a) in axes.iter().enumerate() {
                for (j, b) in axes.iter().enumerate() {
                    assert!((a.dot(*b) - f64::from(u8::from(i == j))).abs() < 1e-12);
                }
            }
            let ray = moving.ray_at([10.0, 7.0], secs);
            assert_eq!(
                ray,
                Ray {
                    time: secs,
                    ..there.ray([10.0, 7.0])
                }
            );
        }
        assert_eq!(moving.at(0.0).eye, moving.eye);
        assert!(moving.eye.distance(keys[1].eye) < 1e-12);
        assert_eq!(moving.at(-7.0), moving.at(-1.0));
        // Differences by time, against the stated ones.
        let differential = moving.differential_at([50.0, 12.0], 0.3);
        let h = 1e-4;
        let [before, after] = [0.3 - h, 0.3 + h].map(|secs| moving.ray_at([50.0, 12.0], secs));
        let rate = (after.direction - before.direction) / (2.0 * h);
        assert!(differential.direction[2].as_dvec3().distance(rate) < 1e-5);
        let rate = (after.origin - before.origin) / (2.0 * h);
        assert!(differential.origin[2].as_dvec3().distance(rate) < 1e-4);
    }

    #[test]
    fn a_target_that_passes_the_eye_is_found_and_survived() {
        let keys = vec![
            key(0.0, DVec3::ZERO, DVec3::X),
            key(1.0, DVec3::ZERO, DVec3::NEG_X),
        ];
        let settings = CameraSettings {
            keys: keys.clone(),
            ..CameraSettings::default()
        };
        assert_eq!(settings.check_path(), Some((0.5, CameraError::Direction)));
        assert_eq!(camera(keys, 0.0).at(0.5).forward, DVec3::X);
        assert!(!camera(vec![key(3.0, DVec3::ZERO, DVec3::X)], 0.0).moves());
    }
}
