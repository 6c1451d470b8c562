//! The GGX distribution of microfacets (Walter et al., "Microfacet Models for Refraction through Rough
//! Surfaces", 2007) with Smith's height-correlated shadowing.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A rough boundary of one width.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ggx {
    width: f64,
}

impl Ggx {
    pub(super) fn new(width: f64) -> Self {
        Self { width }
    }

    /// Density of facet normals, D(h) (Walter et al. 2007, eq. 33).
    fn normals(&self, half: DVec3) -> f64 {
        let a2 = self.width * self.width;
        let d = half.z * half.z * (a2 - 1.0) + 1.0;
        a2 / (PI * d * d)
    }

    /// Λ of Smith's shadowing (Heitz, "Understanding the Masking-Shadowing Function", 2014, eq. 72).
    fn lambda(&self, direction: DVec3) -> f64 {
        let z2 = direction.z * direction.z;
        let tangent_squared = (1.0 - z2).max(0.0) / z2;
        0.5 * ((1.0 + self.width * self.width * tangent_squared).sqrt() - 1.0)
    }

    /// Part of the facets that `direction` sees, G₁.
    pub(super) fn masking(&self, direction: DVec3) -> f64 {
        1.0 / (1.0 + self.lambda(direction))
    }

    /// Part of the facets that both directions see, over the part that `view` sees: G₂/G₁ (Heitz
    /// 2014, eq. 99).
    pub(super) fn shadowing(&self, view: DVec3, light: DVec3) -> f64 {
        let view = self.lambda(view);
        (1.0 + view) / (1.0 + view + self.lambda(light))
    }

    /// Draws a facet normal as `view` sees them (Heitz, "Sampling the GGX Distribution of Visible
    /// Normals", JCGT 7(4), 2018).
    pub(super) fn sample(&self, view: DVec3, u: [f64; 2]) -> DVec3 {
        let stretched = DVec3::new(self.width * view.x, self.width * view.y, view.z).normalize();
        let flat = stretched.x * stretched.x + stretched.y * stretched.y;
        let first = if flat > 0.0 {
            DVec3::new(-stretched.y, stretched.x, 0.0) / flat.sqrt()
        } else {
            DVec3::X
        };
        let second = stretched.cross(first);
        let radius = u[0].sqrt();
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let x = radius * cos;
        let s = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * radius * sin;
        let z = (1.0 - x * x - y * y).max(0.0).sqrt();
        let half = first * x + second * y + stretched * z;
        DVec3::new(self.width * half.x, self.width * half.y, half.z.max(1e-12)).normalize()
    }

    /// Density of [`Ggx::sample`] per solid angle of the facet normal.
    pub(super) fn visible(&self, view: DVec3, half: DVec3) -> f64 {
        self.masking(view) * view.dot(half).max(0.0) * self.normals(half) / view.z
    }
}
