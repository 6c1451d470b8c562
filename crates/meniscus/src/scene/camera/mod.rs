//! The camera: from eye, target, up and field of view to primary rays.

mod framing;
mod path;
mod settings;
mod turntable;
mod way;

pub(crate) use framing::horizontal_axes;
pub use path::CameraKey;
pub use settings::{CameraSettings, Up, UpError};
pub use way::CameraPiece;

use crate::math::differential::RayDifferential;
use crate::math::ray::Ray;
use glam::{DVec3, Vec3};
use path::CameraPath;
use std::sync::Arc;

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
/// vertical field of view, square pixels; pixel (0, 0) is top left. All in float64. One that moves is
/// described as it is at the frame's time; [`Camera::at`] is the one of another time.
#[derive(Debug, Clone, PartialEq)]
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
    /// Half width and half height of the picture at distance 1 along the view axis.
    half_extents: [f64; 2],
    /// Side of a pixel at distance 1 along the view axis.
    pixel_side: f64,
    /// Where it is at other times.
    path: Option<Arc<CameraPath>>,
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
        let half_height = (0.5 * fov).tan();
        let [width, height] = size.map(f64::from);
        Ok(Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            fov,
            size,
            half_extents: [half_height * width / height, half_height],
            pixel_side: 2.0 * half_height / height,
            path: None,
        })
    }

    /// The direction through a point of the film, of length 1 along the view axis.
    #[inline(always)]
    fn towards(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [half_width, half_height] = self.half_extents;
        let to_the_right = x * self.pixel_side - half_width;
        let upwards = half_height - y * self.pixel_side;
        self.forward + self.right * to_the_right + self.up * upwards
    }

    /// The ray through a point of the film, in pixels from the top left corner (the centre of pixel
    /// (0, 0) is (0.5, 0.5)). Unit direction, side unknown, time 0, without differentials.
    #[inline(always)]
    pub fn ray(&self, film: [f64; 2]) -> Ray {
        Ray::new(self.eye, self.towards(film).normalize())
    }

    /// How [`Camera::ray`] changes from one pixel to the next.
    pub fn differential(&self, film: [f64; 2]) -> RayDifferential {
        let towards = self.towards(film);
        let length = towards.length();
        let direction = towards / length;
        // d(v/|v|) = (dv − u (u·dv))/|v| with u = v/|v|.
        let change = |step: DVec3| ((step - direction * direction.dot(step)) / length).as_vec3();
        RayDifferential {
            origin: [Vec3::ZERO; 3],
            direction: [
                change(self.right * self.pixel_side),
                change(self.up * -self.pixel_side),
                Vec3::ZERO,
            ],
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
        let [half_width, half_height] = self.half_extents;
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
