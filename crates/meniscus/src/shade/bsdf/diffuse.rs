//! Lambert's law: the same radiance in every direction.

use super::{BsdfSample, Scattering};
use crate::math::sampling::cosine_hemisphere;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// An even surface of one albedo.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Diffuse {
    /// Part of the light that is scattered.
    pub(in crate::shade) color: Vec3,
}

impl Diffuse {
    pub(super) fn evaluate(&self, light: DVec3) -> Vec3 {
        self.color * (light.z.max(0.0) * FRAC_1_PI) as f32
    }

    pub(super) fn density(&self, light: DVec3) -> f64 {
        light.z.max(0.0) * FRAC_1_PI
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<BsdfSample> {
        let light = cosine_hemisphere(DVec3::Z, u);
        (light.z > 0.0).then(|| BsdfSample {
            light,
            weight: self.color,
            density: self.density(light),
            scattering: Scattering::Diffuse,
        })
    }
}
