//! A clear coat on a diffuse base; the base gets the light that the coat does not reflect (Kelemen &
//! Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model", 2001; Kulla & Conty 2017).

use super::albedo::AlbedoTable;
use super::fresnel::dielectric;
use super::microfacet::Ggx;
use super::{BsdfSample, Scattering, is_smooth, luminance, mirrored, widened, width_of};
use crate::math::sampling::cosine_hemisphere;
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_PI;

/// A coat: its index and strength, and what it reflects in all.
#[derive(Debug, Clone)]
pub(in crate::shade) struct Coat {
    pub(in crate::shade) ior: f64,
    pub(in crate::shade) strength: f64,
    pub(in crate::shade) albedo: AlbedoTable,
}

impl Coat {
    /// `strength` in [0, 1] multiplies the reflectance.
    pub(in crate::shade) fn new(ior: f64, strength: f64) -> Self {
        Self {
            ior,
            strength,
            albedo: AlbedoTable::of_reflectance(|cosine| {
                strength * dielectric(cosine.max(0.0), 1.0 / ior).0
            }),
        }
    }

    /// Reflectance of a facet.
    fn reflectance(&self, cosine: f64) -> f64 {
        self.strength * dielectric(cosine.clamp(0.0, 1.0), 1.0 / self.ior).0
    }
}

/// A coated surface of one base colour and roughness.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Plastic<'a> {
    coat: &'a Coat,
    base: Vec3,
    roughness: f64,
    widths: [f64; 2],
}

impl<'a> Plastic<'a> {
    pub(in crate::shade) fn new(coat: &'a Coat, base: Vec3, roughness: f64) -> Self {
        Self {
            coat,
            base,
            roughness,
            widths: [width_of(roughness); 2],
        }
    }

    /// With a highlight wider by what [`widened`] adds.
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

    pub(super) fn is_spread(&self) -> bool {
        self.base != Vec3::ZERO || !self.is_smooth()
    }

    /// What the coat reflects at a cosine.
    fn reflected(&self, cosine: f64) -> f64 {
        self.coat.albedo.at(cosine, self.roughness).clamp(0.0, 1.0)
    }

    /// Reflectance of the coat as a mirror.
    pub(in crate::shade) fn coat_reflectance(&self, cosine: f64) -> f64 {
        self.coat.reflectance(cosine)
    }

    /// Probability that a sample goes to the coat.
    fn coat_share(&self, view: DVec3) -> f64 {
        let coat = self.reflected(view.z);
        let base = luminance(self.base) * (1.0 - coat);
        if coat + base > 0.0 {
            coat / (coat + base)
        } else {
            0.0
        }
    }

    /// The base alone, times cosine.
    fn base(&self, view: DVec3, light: DVec3) -> Vec3 {
        let rest = 1.0 - self.coat.albedo.mean(self.roughness);
        if rest < 1e-6 {
            return Vec3::ZERO;
        }
        let through = (1.0 - self.reflected(view.z)) * (1.0 - self.reflected(light.z)) / rest;
        self.base * (through * light.z * FRAC_1_PI) as f32
    }

    /// Density of facets that mirror `light`.
    fn facets(&self, view: DVec3, half: DVec3) -> f64 {
        Ggx::stretched(self.widths).visible(view, half) / (4.0 * view.dot(half))
    }

    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> Vec3 {
        if light.z <= 0.0 {
            return Vec3::ZERO;
        }
        let base = self.base(view, light);
        if self.is_smooth() {
            return base;
        }
        let half = (view + light).normalize_or(DVec3::Z);
        let coat = self.coat.reflectance(view.dot(half))
            * self.facets(view, half)
            * Ggx::stretched(self.widths).shadowing(view, light);
        base + Vec3::splat(coat as f32)
    }

    pub(super) fn density(&self, view: DVec3, light: DVec3) -> f64 {
        if light.z <= 0.0 {
            return 0.0;
        }
        let share = self.coat_share(view);
        let base = (1.0 - share) * light.z * FRAC_1_PI;
        if self.is_smooth() {
            return base;
        }
        let half = (view + light).normalize_or(DVec3::Z);
        base + share * self.facets(view, half)
    }

    pub(super) fn sample(&self, view: DVec3, choice: f64, u: [f64; 2]) -> Option<BsdfSample> {
        let share = self.coat_share(view);
        let goes_to_coat = choice < share;
        let light = match (goes_to_coat, self.is_smooth()) {
            (true, true) => {
                let weight = self.coat.reflectance(view.z) / share;
                return Some(BsdfSample::only(
                    mirrored(view),
                    Vec3::splat(weight as f32),
                    Scattering::Reflection,
                ));
            }
            (true, false) => {
                let half = Ggx::stretched(self.widths).sample(view, u);
                (half * (2.0 * view.dot(half)) - view).normalize()
            }
            (false, _) => cosine_hemisphere(DVec3::Z, u),
        };
        if light.z <= 0.0 {
            return None;
        }
        let density = self.density(view, light);
        (density > 0.0).then(|| BsdfSample {
            light,
            weight: self.evaluate(view, light) / density as f32,
            density,
            scattering: if goes_to_coat {
                Scattering::Reflection
            } else {
                Scattering::Diffuse
            },
        })
    }
}
