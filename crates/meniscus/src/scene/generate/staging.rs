//! Ready scenes: surface settings, a camera that frames the set, a sun, a material.

use crate::math::aabb::DAabb;
use crate::scene::preset::Preset;
use crate::scene::{
    BlobSettings, CameraSettings, Ground, IntegratorSettings, Light, Scene, Surface, Up,
};
use glam::DVec3;
use std::path::PathBuf;

/// What makes a set look good.
pub(super) struct Staging {
    /// Surface settings.
    pub(super) blobs: BlobSettings,
    /// What the camera frames.
    pub(super) bounds: DAabb,
    /// Direction from the middle of the bounds to the camera, any length.
    pub(super) towards_eye: DVec3,
    /// Which way is up.
    pub(super) up: DVec3,
    /// Direction towards the sun, any length.
    pub(super) light: DVec3,
    /// Name of the preset whose material suits.
    pub(super) preset: &'static str,
    /// Whether a ground plane belongs under the set.
    pub(super) ground: bool,
}

/// Vertical field of view of every staged camera, in degrees.
const FOV_DEGREES: f64 = 35.0;

impl Staging {
    /// The scene; the file of its one surface is left to the caller.
    pub(super) fn scene(self) -> Scene {
        let eye = eye_that_frames(self.bounds, self.towards_eye, self.up);
        let blobs = self.blobs;
        let mut scene = Scene {
            camera: CameraSettings {
                eye: Some(rounded(eye)),
                target: Some(rounded(self.bounds.center())),
                up: Up(self.up),
                fov: FOV_DEGREES,
                ..CameraSettings::default()
            },
            surfaces: vec![Surface {
                file: PathBuf::new(),
                radius: blobs.radius,
                support: blobs.support,
                kernel: Some(blobs.kernel),
                threshold: Some(blobs.threshold),
                weights: Some(blobs.weights),
                ..Surface::default()
            }],
            ground: self.ground.then(Ground::default),
            lights: vec![Light::sun(rounded(self.light.normalize())), Light::sky()],
            ..Scene::default()
        };
        if let Some(preset) = Preset::from_name(self.preset) {
            preset.apply(&mut scene);
            // A first look is quick; `--integrator path` gives the material its due.
            scene.integrator = IntegratorSettings::default();
        }
        scene
    }
}

/// Without the digits that nobody wants to read in a scene file.
fn rounded(v: DVec3) -> DVec3 {
    (v * 1e6).round() / 1e6
}

/// A point in direction `towards_eye` from the middle of `bounds`, just far enough that a picture of
/// 4:3 (or wider) holds all eight corners.
fn eye_that_frames(bounds: DAabb, towards_eye: DVec3, up: DVec3) -> DVec3 {
    let back = towards_eye.normalize();
    let right = (-back).cross(up).normalize();
    let image_up = right.cross(-back);
    let tangent = (FOV_DEGREES.to_radians() / 2.0).tan();
    let center = bounds.center();
    let distance = (0..8).fold(0.0f64, |distance, corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        let p = DVec3::new(pick(0), pick(1), pick(2)) - center;
        let vertical = p.dot(image_up).abs() / tangent;
        let horizontal = p.dot(right).abs() / (tangent * 4.0 / 3.0);
        distance.max(vertical.max(horizontal) + p.dot(back))
    });
    center + back * distance
}
