//! The boundary of two clear media, smooth or rough (Walter et al. 2007). What single scattering loses
//! at a rough one is given back by scaling (Turquin, "Practical multiple scattering compensation for
//! microfacet models", 2019), which keeps energy and gives up reciprocity of that part.

use super::albedo::AlbedoTable;
use super::fresnel::dielectric;
use super::microfacet::Ggx;
use super::{BsdfSample, SMOOTH, Scattering, mirrored, width_of};
use glam::{DVec3, Vec3};

/// What a rough boundary keeps by single scattering, seen from either side.
#[derive(Debug, Clone)]
pub(in crate::shade) struct RoughBoundary {
    pub(in crate::shade) from_thin: AlbedoTable,
    pub(in crate::shade) from_dense: AlbedoTable,
}

impl RoughBoundary {
    /// Between vacuum and a medium of index `ior`.
    pub(in crate::shade) fn new(ior: f64) -> Self {
        let table = |eta: f64| {
            AlbedoTable::tabled(
                |_| 1.0,
                |ggx, view, half| {
                    let cosine = view.dot(half).max(0.0);
                    let (reflectance, other) = dielectric(cosine, eta);
                    let mirror = half * (2.0 * cosine) - view;
                    let kept = |light: DVec3| ggx.shadowing(view, light);
                    let reflected = if mirror.z > 0.0 { kept(mirror) } else { 0.0 };
                    let through = other
                        .map(|other| refracted(view, half, cosine, other, eta))
                        .filter(|light| light.z < 0.0)
                        .map_or(0.0, kept);
                    reflectance * reflected + (1.0 - reflectance) * through
                },
            )
        };
        Self {
            from_thin: table(1.0 / ior),
            from_dense: table(ior),
        }
    }
}

/// `view` refracted at a facet: `cosine` on its side, `other` beyond; `eta` is the index on its side
/// over that beyond.
fn refracted(view: DVec3, half: DVec3, cosine: f64, other: f64, eta: f64) -> DVec3 {
    half * (eta * cosine - other) - view * eta
}

/// A boundary seen from one side.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Dielectric<'a> {
    /// Index on the viewer's side over that beyond.
    eta: f64,
    roughness: f64,
    width: f64,
    boundary: Option<&'a RoughBoundary>,
}

impl<'a> Dielectric<'a> {
    /// Between the indices `ior` on the viewer's side and `ior_beyond`. Without `boundary` it is
    /// smooth.
    pub(in crate::shade) fn new(
        [ior, ior_beyond]: [f64; 2],
        roughness: f64,
        boundary: Option<&'a RoughBoundary>,
    ) -> Self {
        let eta = ior / ior_beyond;
        let is_there = (eta - 1.0).abs() > 1e-9;
        Self {
            eta,
            roughness,
            width: match boundary {
                Some(_) if is_there => width_of(roughness),
                _ => 0.0,
            },
            boundary,
        }
    }

    pub(super) fn is_smooth(&self) -> bool {
        self.width < SMOOTH
    }

    pub(super) fn index_ratio(&self) -> f64 {
        self.eta
    }

    /// What makes up for the light that single scattering loses.
    pub(super) fn scale(&self, view: DVec3) -> f64 {
        let Some(boundary) = self.boundary else {
            return 1.0;
        };
        let table = if self.eta < 1.0 {
            &boundary.from_thin
        } else {
            &boundary.from_dense
        };
        1.0 / table.at(view.z, self.roughness).max(0.1)
    }

    /// Facet that takes `light` to `view`, with the Fresnel part and the change of solid angle from
    /// facets to light; `None` if there is none.
    fn facet(&self, view: DVec3, light: DVec3) -> Option<(DVec3, f64, f64)> {
        if light.z > 0.0 {
            let half = (view + light).try_normalize()?;
            let cosine = view.dot(half);
            let (reflectance, _) = dielectric(cosine, self.eta);
            return Some((half, reflectance, 1.0 / (4.0 * cosine)));
        }
        // Walter et al. 2007, eq. 16 and 17, with indices relative to the light's side.
        let half = (view * self.eta + light).try_normalize()?;
        let half = if half.z < 0.0 { -half } else { half };
        let [cosine, other] = [view.dot(half), light.dot(half)];
        if cosine <= 0.0 || other >= 0.0 {
            return None;
        }
        let (reflectance, _) = dielectric(cosine, self.eta);
        let denominator = self.eta * cosine + other;
        Some((
            half,
            1.0 - reflectance,
            -other / (denominator * denominator),
        ))
    }

    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> Vec3 {
        if self.is_smooth() || light.z == 0.0 {
            return Vec3::ZERO;
        }
        let ggx = Ggx::new(self.width);
        let value = self.facet(view, light).map_or(0.0, |(half, part, change)| {
            part * ggx.visible(view, half) * change * ggx.shadowing(view, light)
        });
        Vec3::splat((value * self.scale(view)) as f32)
    }

    pub(super) fn density(&self, view: DVec3, light: DVec3) -> f64 {
        if self.is_smooth() || light.z == 0.0 {
            return 0.0;
        }
        let ggx = Ggx::new(self.width);
        self.facet(view, light).map_or(0.0, |(half, part, change)| {
            part * ggx.visible(view, half) * change
        })
    }

    pub(super) fn sample(&self, view: DVec3, choice: f64, u: [f64; 2]) -> Option<BsdfSample> {
        let ggx = Ggx::new(self.width);
        let half = if self.is_smooth() {
            DVec3::Z
        } else {
            ggx.sample(view, u)
        };
        let cosine = view.dot(half);
        let (reflectance, other) = dielectric(cosine.clamp(0.0, 1.0), self.eta);
        let (light, scattering) = match other {
            Some(other) if choice >= reflectance => (
                refracted(view, half, cosine, other, self.eta),
                Scattering::Refraction,
            ),
            _ if self.is_smooth() => (mirrored(view), Scattering::Reflection),
            _ => (half * (2.0 * cosine) - view, Scattering::Reflection),
        };
        if self.is_smooth() {
            return Some(BsdfSample::only(light.normalize(), Vec3::ONE, scattering));
        }
        let is_on_its_side = (light.z > 0.0) == (scattering == Scattering::Reflection);
        if !is_on_its_side || light.z == 0.0 {
            return None;
        }
        let light = light.normalize();
        let density = self.density(view, light);
        let weight = ggx.shadowing(view, light) * self.scale(view);
        (density > 0.0).then(|| BsdfSample {
            light,
            weight: Vec3::splat(weight as f32),
            density,
            scattering,
        })
    }
}
