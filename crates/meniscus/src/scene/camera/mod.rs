//! The camera: from eye, target, up and field of view to primary rays.

mod framing;
mod settings;
mod turntable;

pub(super) use framing::horizontal_axes;
pub use settings::{CameraSettings, Up, UpError};

use crate::math::ray::{Ray, RayDifferential};
use glam::DVec3;

/// A camera that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CameraError {
    /// Eye and target coincide, are too far apart, or are not finite.
    #[error("the camera's eye and target must be two different finite points")]
    Direction,
    /// Up is zero, not finite, or points along the view.
    #[error("the camera's up must not point along its view direction")]
    Up,
    /// The field of view is not between 0° and 180°.
    #[error("the field of view must lie between 0 and 180 degrees")]
    Fov,
}

/// A pinhole camera for a film of a given size: forward = target − eye, right = forward × up,
/// vertical field of view, square pixels; pixel (0, 0) is top left. All in float64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Where it stands, world space.
    pub eye: DVec3,
    /// Unit view direction.
    pub forward: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Vertical field of view in radians.
    pub fov: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
}

impl Camera {
    /// A camera at `eye` that looks at `target`; `fov` in radians, `size` in pixels.
    ///
    /// # Errors
    /// When the points, the up direction or the angle define no camera.
    pub fn new(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        fov: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        if !(fov > 0.0 && fov < std::f64::consts::PI) {
            return Err(CameraError::Fov);
        }
        let forward = (target - eye)
            .try_normalize()
            .ok_or(CameraError::Direction)?;
        let right = up
            .try_normalize()
            .map(|up| forward.cross(up))
            .filter(|right| right.length_squared() > 1e-12)
            .and_then(DVec3::try_normalize)
            .ok_or(CameraError::Up)?;
        Ok(Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            fov,
            size,
        })
    }

    /// Half width and half height of the picture at distance 1 along the view axis.
    fn half_extents(&self) -> [f64; 2] {
        let half_height = (0.5 * self.fov).tan();
        let [width, height] = self.size.map(f64::from);
        [half_height * width / height, half_height]
    }

    /// The ray through a point of the film, in pixels from the top left corner (the centre of pixel
    /// (0, 0) is (0.5, 0.5)). Unit direction, differentials per pixel, side unknown, time 0.
    pub fn ray(&self, film: [f64; 2]) -> Ray {
        let [half_width, half_height] = self.half_extents();
        let [width, height] = self.size.map(f64::from);
        let x = (2.0 * film[0] / width - 1.0) * half_width;
        let y = (1.0 - 2.0 * film[1] / height) * half_height;
        let raw = self.forward + self.right * x + self.up * y;
        let length = raw.length();
        let direction = raw / length;
        let pixel = 2.0 * half_height / height;
        // d(v/|v|) = (dv − u (u·dv))/|v| with u = v/|v|.
        let change = |step: DVec3| (step - direction * direction.dot(step)) / length;
        Ray {
            differential: Some(RayDifferential {
                origin: [DVec3::ZERO; 2],
                direction: [change(self.right * pixel), change(self.up * -pixel)],
            }),
            ..Ray::new(self.eye, direction)
        }
    }

    /// Distance of a world point along the view axis.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// Where a world point appears on the film, in pixels from the top left corner; `None` behind
    /// the eye.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let depth = self.depth(point);
        if depth <= 0.0 {
            return None;
        }
        let [half_width, half_height] = self.half_extents();
        let [width, height] = self.size.map(f64::from);
        let offset = (point - self.eye) / depth;
        Some([
            (offset.dot(self.right) / half_width + 1.0) * 0.5 * width,
            (1.0 - offset.dot(self.up) / half_height) * 0.5 * height,
        ])
    }
}

#[cfg(test)]
mod tests;
