//! The GGX distribution of microfacets (Walter et al., "Microfacet Models for Refraction through Rough
//! Surfaces", 2007) with Smith's height-correlated shadowing.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A rough boundary of one width, or of one along x and another along y.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ggx {
    widths: [f64; 2],
}

impl Ggx {
    pub(super) fn new(width: f64) -> Self {
        Self::stretched([width; 2])
    }

    /// With widths along x and y.
    pub(super) fn stretched(widths: [f64; 2]) -> Self {
        Self { widths }
    }

    /// Density of facet normals, D(h) (Walter et al. 2007, eq. 33; with two widths Heitz 2014, eq. 85).
    fn normals(&self, half: DVec3) -> f64 {
        let [a, b] = self.widths;
        let (x, y) = (half.x / a, half.y / b);
        let d = x * x + y * y + half.z * half.z;
        1.0 / (PI * a * b * d * d)
    }

    /// Λ of Smith's shadowing (Heitz, "Understanding the Masking-Shadowing Function", 2014, eq. 72).
    fn lambda(&self, direction: DVec3) -> f64 {
        let [a, b] = self.widths;
        let (x, y) = (a * direction.x, b * direction.y);
        let slope_squared = (x * x + y * y) / (direction.z * direction.z);
        0.5 * ((1.0 + slope_squared).sqrt() - 1.0)
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
        let [a, b] = self.widths;
        let stretched = DVec3::new(a * view.x, b * view.y, view.z).normalize();
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
        DVec3::new(a * half.x, b * half.y, half.z.max(1e-12)).normalize()
    }

    /// Density of [`Ggx::sample`] per solid angle of the facet normal.
    pub(super) fn visible(&self, view: DVec3, half: DVec3) -> f64 {
        self.masking(view) * view.dot(half).max(0.0) * self.normals(half) / view.z
    }
}
