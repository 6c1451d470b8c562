//! A parallelogram that shines on one side.

use super::LightSample;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// A parallelogram of one radiance.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Rectangle {
    pub(in crate::shade) center: DVec3,
    pub(in crate::shade) edges: [DVec3; 2],
    /// Unit vector towards which it shines.
    normal: DVec3,
    area: f64,
    pub(in crate::shade) radiance: Vec3,
}

impl Rectangle {
    pub(super) fn new(center: DVec3, edges: [DVec3; 2], radiance: Vec3) -> Self {
        let (normal, area) = edges[0].cross(edges[1]).normalize_and_length();
        Self {
            center,
            edges,
            normal,
            area,
            radiance,
        }
    }

    /// Irradiance over π, about, on a surface that faces its centre. Never 0 in front of it.
    pub(super) fn irradiance(&self, point: DVec3) -> Vec3 {
        let (away, distance) = (point - self.center).normalize_and_length();
        let cosine = away.dot(self.normal);
        if (point - self.center).dot(self.normal) <= 0.0 {
            return Vec3::ZERO;
        }
        let solid = self.area * cosine / (distance * distance + self.area * FRAC_1_PI);
        self.radiance * (solid * FRAC_1_PI) as f32
    }

    pub(super) fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let place = self.center + self.edges[0] * (u[0] - 0.5) + self.edges[1] * (u[1] - 0.5);
        let (towards, distance) = (place - point).normalize_and_length();
        let cosine = -towards.dot(self.normal);
        if !(cosine > 0.0 && distance > 0.0) {
            return None;
        }
        let density = distance * distance / (cosine * self.area);
        Some(LightSample {
            towards,
            distance,
            weight: self.radiance / density as f32,
            density,
        })
    }

    pub(super) fn density(&self, point: DVec3, direction: DVec3) -> f64 {
        match self.met(point, direction, f64::INFINITY) {
            Some((t, _)) => t * t / (-direction.dot(self.normal) * self.area),
            None => 0.0,
        }
    }

    pub(super) fn met(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, Vec3)> {
        let rate = -direction.dot(self.normal);
        if rate <= 0.0 {
            return None;
        }
        let t = (origin - self.center).dot(self.normal) / rate;
        if !(t > 0.0 && t < t_max) {
            return None;
        }
        let place = origin + direction * t - self.center;
        // Coordinates along the edges by the area of the other parallelogram.
        let along = |edge: usize| {
            let other = self.edges[1 - edge];
            let sign = if edge == 0 { 1.0 } else { -1.0 };
            sign * place.cross(other).dot(self.normal) / self.area
        };
        (along(0).abs() <= 0.5 && along(1).abs() <= 0.5).then_some((t, self.radiance))
    }
}
