//! Thin froth: light leaves it evenly to both sides, and it has no inside of its own.

use super::{BsdfSample, Scattering};
use crate::math::sampling::cosine_hemisphere;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// A thin layer that scatters.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Foam {
    /// Part of the light that is scattered, to both sides together.
    pub(in crate::shade) color: Vec3,
    /// Part of that which goes through.
    pub(in crate::shade) translucency: f64,
}

impl Foam {
    /// The part of the scattered light on `light`'s side.
    fn part(&self, light: DVec3) -> f64 {
        if light.z > 0.0 {
            1.0 - self.translucency
        } else {
            self.translucency
        }
    }

    pub(super) fn evaluate(&self, light: DVec3) -> Vec3 {
        self.color * self.density(light) as f32
    }

    pub(super) fn density(&self, light: DVec3) -> f64 {
        self.part(light) * light.z.abs() * FRAC_1_PI
    }

    pub(super) fn sample(&self, choice: f64, u: [f64; 2]) -> Option<BsdfSample> {
        let mut light = cosine_hemisphere(DVec3::Z, u);
        if choice < self.translucency {
            light.z = -light.z;
        }
        (light.z != 0.0).then(|| BsdfSample {
            light,
            weight: self.color,
            density: self.density(light),
            scattering: Scattering::Diffuse,
        })
    }
}
