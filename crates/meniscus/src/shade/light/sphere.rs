//! A ball that shines.

use super::LightSample;
use crate::math::sampling::{tangents, uniform_sphere};
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// A ball of one radiance.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Sphere {
    pub(in crate::shade) center: DVec3,
    pub(in crate::shade) radius: f64,
    pub(in crate::shade) radiance: Vec3,
}

impl Sphere {
    pub(super) fn new(center: DVec3, radius: f64, radiance: Vec3) -> Self {
        Self {
            center,
            radius,
            radiance,
        }
    }

    /// sin² of half the angle under which it is seen; `None` inside.
    fn sine_squared(&self, point: DVec3) -> Option<f64> {
        let sine_squared = self.radius * self.radius / point.distance_squared(self.center);
        (sine_squared < 1.0).then_some(sine_squared)
    }

    /// 1 − cos of half the angle under which it is seen, without loss of digits far away.
    fn height(&self, point: DVec3) -> Option<f64> {
        let sine_squared = self.sine_squared(point)?;
        Some(sine_squared / (1.0 + (1.0 - sine_squared).sqrt()))
    }

    /// Irradiance over π on a surface that faces its centre.
    pub(super) fn irradiance(&self, point: DVec3) -> Vec3 {
        self.radiance * self.sine_squared(point).unwrap_or(1.0) as f32
    }

    pub(super) fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let towards = match self.height(point) {
            None => uniform_sphere(u),
            Some(height) => {
                let axis = (self.center - point).normalize();
                let z = 1.0 - u[0] * height;
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let [first, second] = tangents(axis);
                ((first * cos + second * sin) * radius + axis * z).normalize()
            }
        };
        // At the rim rounding may miss the ball: its nearest point is the place then.
        let distance = self
            .met(point, towards, f64::INFINITY)
            .map_or((self.center - point).dot(towards), |(t, _)| t);
        let density = self.density(point);
        Some(LightSample {
            towards,
            distance,
            weight: self.radiance / density as f32,
            density,
        })
    }

    pub(super) fn density(&self, point: DVec3) -> f64 {
        match self.height(point) {
            None => 0.25 / PI,
            Some(height) => 1.0 / (TAU * height),
        }
    }

    pub(super) fn met(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, Vec3)> {
        let to_center = self.center - origin;
        let along = to_center.dot(direction);
        let miss_squared = (to_center - direction * along).length_squared();
        let half = (self.radius * self.radius - miss_squared).sqrt();
        if !half.is_finite() {
            return None;
        }
        let t = if along - half > 0.0 {
            along - half
        } else {
            along + half
        };
        (t > 0.0 && t < t_max).then_some((t, self.radiance))
    }
}
