//! The default camera: a three-quarter view, slightly from above, that shows the whole object.

use super::{Camera, CameraError, CameraSettings};
use crate::math::aabb::DAabb;
use glam::DVec3;

/// Two horizontal unit vectors: with Y up they are +X and +Z, and with Z up +X and −Y, so that the
/// default views look at the same sides of an object whichever axis its file calls up.
pub(crate) fn horizontal_axes(up: DVec3) -> [DVec3; 2] {
    let side = if up.x.abs() > 0.9 {
        DVec3::NEG_Z * up.x.signum()
    } else {
        DVec3::X
    };
    let side = (side - up * up.dot(side)).normalize();
    [side, side.cross(up)]
}

/// How far the default camera stands above the horizon, in radians.
const FRAMING_ELEVATION: f64 = 0.38;
/// How far the default camera is turned from the front, in radians.
const FRAMING_AZIMUTH: f64 = 0.55;
/// Part of the picture that the framed box fills at most.
const FRAMING_FILL: f64 = 0.9;

impl Camera {
    /// The camera of a scene whose objects fill `bounds` (world space). An unset eye and target
    /// frame the bounds; an unset target is their centre; an unset eye stands where the whole box
    /// is seen around the given target.
    ///
    /// # Errors
    /// When the settings define no camera.
    pub fn from_settings(
        settings: &CameraSettings,
        bounds: DAabb,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        Self::from_settings_at(settings, bounds, size, 0.0)
    }

    /// [`Camera::from_settings`] for a frame at `frame_secs` seconds of the scene: what keys count in.
    ///
    /// # Errors
    /// When the settings define no camera.
    pub fn from_settings_at(
        settings: &CameraSettings,
        bounds: DAabb,
        size: [u32; 2],
        frame_secs: f64,
    ) -> Result<Self, CameraError> {
        if !settings.keys.is_empty() {
            return Self::on_path(settings, size, frame_secs);
        }
        let fov = settings.fov.to_radians();
        let up = settings.up.0;
        let bounds = with_some_size(bounds);
        match (settings.eye, settings.target) {
            (Some(eye), target) => Self::new(eye, target.unwrap_or(bounds.center()), up, fov, size),
            (None, target) => {
                Self::framing_around(target.unwrap_or(bounds.center()), bounds, up, fov, size)
            }
        }
    }

    /// A camera that frames `bounds` from a three-quarter view slightly above: the whole box is in
    /// the picture, with a margin. A box without size (or without points) gets one first.
    ///
    /// # Errors
    /// When `up` or `fov` (radians) define no camera.
    pub fn framing(
        bounds: DAabb,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let bounds = with_some_size(bounds);
        Self::framing_around(bounds.center(), bounds, up, fov, size)
    }

    fn framing_around(
        target: DVec3,
        bounds: DAabb,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let up = up.try_normalize().ok_or(CameraError::Up)?;
        let [side, front] = horizontal_axes(up);
        let (sin, cos) = FRAMING_AZIMUTH.sin_cos();
        let towards_eye =
            (side * sin + front * cos) * FRAMING_ELEVATION.cos() + up * FRAMING_ELEVATION.sin();
        let at_target = Self::new(target + towards_eye, target, up, fov, size)?;
        let [x_reach, y_reach] = at_target.half_extents.map(|reach| reach * FRAMING_FILL);
        // A corner c (relative to the target) is inside the picture when |c·right| ≤ reach·depth
        // with depth = distance + c·forward.
        let distance = corners(bounds)
            .map(|corner| corner - target)
            .iter()
            .fold(0.0, |d, c| {
                let x = c.dot(at_target.right).abs() / x_reach;
                let y = c.dot(at_target.up).abs() / y_reach;
                f64::max(d, x.max(y) - c.dot(at_target.forward))
            });
        // Never inside the box, even where the target lies far outside it.
        let distance = distance.max(bounds.size().length() * 1e-3);
        Self::new(target + towards_eye * distance, target, up, fov, size)
    }
}

fn corners(bounds: DAabb) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

/// A box that a camera can frame: one around the origin if there is no finite point, and never
/// smaller than what float64 resolves at its place.
fn with_some_size(bounds: DAabb) -> DAabb {
    if bounds.is_empty() || !(bounds.min.is_finite() && bounds.max.is_finite()) {
        return DAabb {
            min: DVec3::NEG_ONE,
            max: DVec3::ONE,
        };
    }
    let center = bounds.center();
    if bounds.size().max_element() > 1e-9 * center.abs().max_element() {
        return bounds;
    }
    let half = DVec3::splat((center.abs().max_element() * 1e-3).max(f64::from(f32::MIN_POSITIVE)));
    let half = if center == DVec3::ZERO {
        DVec3::ONE
    } else {
        half
    };
    DAabb {
        min: center - half,
        max: center + half,
    }
}
