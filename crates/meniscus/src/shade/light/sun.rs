//! A disk at infinity.

use super::LightSample;
use crate::math::sampling::tangents;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};

/// A sun of some apparent size, or of none.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Sun {
    pub(in crate::shade) towards: DVec3,
    /// Irradiance on a surface that faces it, over π.
    pub(in crate::shade) radiance: Vec3,
    /// 1 − cos of half its angle; 0: one direction.
    pub(in crate::shade) height: f64,
}

impl Sun {
    pub(super) fn new(towards: DVec3, radiance: Vec3, half_angle: f64) -> Self {
        let sine = (0.5 * half_angle).sin();
        Self {
            towards,
            radiance,
            height: 2.0 * sine * sine,
        }
    }

    /// Irradiance on a surface that faces it, over π.
    pub(super) fn irradiance(&self) -> Vec3 {
        self.radiance
    }

    pub(in crate::shade) fn is_point(&self) -> bool {
        self.height < 1e-12
    }

    /// The radiance of the disk: E = π sin²(half angle) L.
    fn disk(&self) -> Vec3 {
        self.radiance / (self.height * (2.0 - self.height)) as f32
    }

    pub(super) fn middle(&self) -> LightSample {
        LightSample {
            towards: self.towards,
            distance: f64::INFINITY,
            weight: self.radiance * PI as f32,
            density: f64::INFINITY,
        }
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> LightSample {
        if self.is_point() {
            return self.middle();
        }
        let z = 1.0 - u[0] * self.height;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let [first, second] = tangents(self.towards);
        let density = self.density();
        LightSample {
            towards: ((first * cos + second * sin) * radius + self.towards * z).normalize(),
            distance: f64::INFINITY,
            weight: self.disk() / density as f32,
            density,
        }
    }

    pub(super) fn density(&self) -> f64 {
        if self.is_point() {
            0.0
        } else {
            1.0 / (TAU * self.height)
        }
    }

    pub(super) fn radiance(&self, direction: DVec3) -> Vec3 {
        // 1 − cos by the chord, which keeps its digits where the disk is small.
        let height = 0.5 * direction.distance_squared(self.towards);
        if self.is_point() || height > self.height {
            Vec3::ZERO
        } else {
            self.disk()
        }
    }
}
