//! Metals: GGX with Schlick's reflectance, and the light that single scattering loses given back
//! (Kulla & Conty 2017).

use super::albedo::AlbedoTable;
use super::fresnel::{schlick, schlick_mean};
use super::microfacet::Ggx;
use super::{BsdfSample, Scattering, is_smooth, mirrored, widened, width_of};
use crate::math::sampling::cosine_hemisphere;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// A metal of one colour and roughness.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Conductor {
    head_on: Vec3,
    roughness: f64,
    widths: [f64; 2],
}

impl Conductor {
    /// `head_on` is the reflectance seen head on.
    pub(in crate::shade) fn new(head_on: Vec3, roughness: f64) -> Self {
        Self {
            head_on,
            roughness,
            widths: [width_of(roughness); 2],
        }
    }

    /// With lobes wider by what [`widened`] adds.
    pub(in crate::shade) fn widened(self, added: [f64; 2]) -> Self {
        let (widths, roughness) = widened(self.widths, added);
        Self {
            roughness,
            widths,
            ..self
        }
    }

    pub(in crate::shade) fn is_smooth(&self) -> bool {
        is_smooth(self.widths)
    }

    /// Reflectance of one facet.
    pub(in crate::shade) fn facet_reflectance(&self, cosine: f64) -> Vec3 {
        schlick(self.head_on, cosine)
    }

    /// What single scattering leaves for the light that is scattered again, at a cosine.
    fn lost(&self, cosine: f64) -> f64 {
        (1.0 - AlbedoTable::full().at(cosine, self.roughness)).clamp(0.0, 1.0)
    }

    /// BRDF of the light scattered more than once, without the two [`Conductor::lost`].
    fn again(&self) -> Vec3 {
        let kept = AlbedoTable::full().mean(self.roughness);
        let lost = 1.0 - kept;
        if lost < 1e-6 {
            return Vec3::ZERO;
        }
        let mean = schlick_mean(self.head_on);
        let color = mean * mean * kept as f32 / (Vec3::ONE - mean * lost as f32);
        color * (FRAC_1_PI / lost) as f32
    }

    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> Vec3 {
        if self.is_smooth() || light.z <= 0.0 {
            return Vec3::ZERO;
        }
        let ggx = Ggx::stretched(self.widths);
        let half = (view + light).normalize_or(DVec3::Z);
        let cosine = view.dot(half);
        let facets = ggx.visible(view, half) / (4.0 * cosine) * ggx.shadowing(view, light);
        let again = self.lost(view.z) * self.lost(light.z) * light.z;
        schlick(self.head_on, cosine) * facets as f32 + self.again() * again as f32
    }

    pub(super) fn density(&self, view: DVec3, light: DVec3) -> f64 {
        if self.is_smooth() || light.z <= 0.0 {
            return 0.0;
        }
        let half = (view + light).normalize_or(DVec3::Z);
        let facets = Ggx::stretched(self.widths).visible(view, half) / (4.0 * view.dot(half));
        let lost = self.lost(view.z);
        facets * (1.0 - lost) + light.z * FRAC_1_PI * lost
    }

    pub(super) fn sample(&self, view: DVec3, choice: f64, u: [f64; 2]) -> Option<BsdfSample> {
        if self.is_smooth() {
            let weight = schlick(self.head_on, view.z);
            return Some(BsdfSample::only(
                mirrored(view),
                weight,
                Scattering::Reflection,
            ));
        }
        let light = if choice < self.lost(view.z) {
            cosine_hemisphere(DVec3::Z, u)
        } else {
            let half = Ggx::stretched(self.widths).sample(view, u);
            (half * (2.0 * view.dot(half)) - view).normalize()
        };
        if light.z <= 0.0 {
            return None;
        }
        let density = self.density(view, light);
        (density > 0.0).then(|| BsdfSample {
            light,
            weight: self.evaluate(view, light) / density as f32,
            density,
            scattering: Scattering::Reflection,
        })
    }
}
