//! How a surface scatters light: a closed list of models, one file each.
//!
//! Directions are unit vectors in a frame whose z axis is the normal on the viewer's side; `view`
//! points to where the light is seen from (z > 0), `light` to where it comes from. What is
//! transported is basic radiance L/n²: so refraction needs no factor, and a camera in water sees what
//! one behind a window does.

mod albedo;
mod conductor;
mod dielectric;
mod diffuse;
mod foam;
mod fresnel;
mod microfacet;
mod plastic;
mod sheet;

pub(super) use albedo::{AlbedoTable, ENTRIES as ALBEDO_ENTRIES};
pub(super) use conductor::Conductor;
pub(super) use dielectric::{Dielectric, RoughBoundary};
pub(super) use diffuse::Diffuse;
pub(super) use foam::Foam;
pub(super) use fresnel::dielectric as dielectric_reflectance;
pub(super) use plastic::{Coat, Plastic};
pub(super) use sheet::Sheet;

use glam::{DVec3, Vec3};

/// GGX widths below this are perfectly smooth.
const SMOOTH: f64 = 1e-3;

/// GGX width of a roughness (Burley 2012).
fn width_of(roughness: f64) -> f64 {
    roughness * roughness
}

/// Whether a lobe of these widths is a mirror's.
fn is_smooth(widths: [f64; 2]) -> bool {
    widths[0].max(widths[1]) < SMOOTH
}

/// Widths of a lobe to whose squares `added` is added along x and y (Kaplanyan et al. 2016), and the
/// roughness of the round lobe of the same mean square, which stands for it in tables. What stays a
/// mirror across is made just rough there.
fn widened(widths: [f64; 2], added: [f64; 2]) -> ([f64; 2], f64) {
    let squares = [0, 1].map(|k| (widths[k] * widths[k] + added[k]).min(1.0));
    let wide = squares[0].max(squares[1]).sqrt() >= SMOOTH;
    let least = if wide { SMOOTH } else { 0.0 };
    let mean = (0.5 * (squares[0] + squares[1])).sqrt();
    (squares.map(|square| square.sqrt().max(least)), mean.sqrt())
}

/// What a scattered ray counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scattering {
    /// Spread over the hemisphere, reflected or transmitted.
    Diffuse,
    /// Reflected about the mirror direction.
    Reflection,
    /// Gone through the surface about the refracted direction.
    Refraction,
}

/// A direction drawn from a BSDF.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BsdfSample {
    /// Where the light comes from.
    pub(super) light: DVec3,
    /// BSDF times cosine over density.
    pub(super) weight: Vec3,
    /// Density per solid angle; infinite where the direction is the only possible one.
    pub(super) density: f64,
    /// What kind of ray it is.
    pub(super) scattering: Scattering,
}

impl BsdfSample {
    /// The one direction that a smooth surface sends light to.
    fn only(light: DVec3, weight: Vec3, scattering: Scattering) -> Self {
        Self {
            light,
            weight,
            density: f64::INFINITY,
            scattering,
        }
    }

    /// Whether light lists can be sampled in its place: not for mirrors.
    pub(super) fn is_only_direction(&self) -> bool {
        self.density.is_infinite()
    }
}

/// How light is scattered at one point.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bsdf<'a> {
    /// Evenly.
    Diffuse(Diffuse),
    /// By a rough or smooth metal.
    Conductor(Conductor),
    /// By a coat over a diffuse base.
    Plastic(Plastic<'a>),
    /// By the boundary of two clear media.
    Dielectric(Dielectric<'a>),
    /// To both sides.
    Foam(Foam),
    /// Straight through, or mirrored.
    Sheet(Sheet),
}

impl Bsdf<'_> {
    /// BSDF times |cos| of the light's angle, without what only one direction has.
    pub(super) fn evaluate(&self, view: DVec3, light: DVec3) -> Vec3 {
        match self {
            Self::Diffuse(model) => model.evaluate(light),
            Self::Conductor(model) => model.evaluate(view, light),
            Self::Plastic(model) => model.evaluate(view, light),
            Self::Dielectric(model) => model.evaluate(view, light),
            Self::Foam(model) => model.evaluate(light),
            Self::Sheet(_) => Vec3::ZERO,
        }
    }

    /// Density per solid angle with which [`Bsdf::sample`] draws `light`.
    pub(super) fn density(&self, view: DVec3, light: DVec3) -> f64 {
        match self {
            Self::Diffuse(model) => model.density(light),
            Self::Conductor(model) => model.density(view, light),
            Self::Plastic(model) => model.density(view, light),
            Self::Dielectric(model) => model.density(view, light),
            Self::Foam(model) => model.density(light),
            Self::Sheet(_) => 0.0,
        }
    }

    /// Draws a direction with three numbers in [0, 1); `None` where the light is lost.
    pub(super) fn sample(&self, view: DVec3, choice: f64, u: [f64; 2]) -> Option<BsdfSample> {
        match self {
            Self::Diffuse(model) => model.sample(u),
            Self::Conductor(model) => model.sample(view, choice, u),
            Self::Plastic(model) => model.sample(view, choice, u),
            Self::Dielectric(model) => model.sample(view, choice, u),
            Self::Foam(model) => model.sample(choice, u),
            Self::Sheet(model) => Some(model.sample(view, choice)),
        }
    }

    /// Whether light from any but a few single directions counts.
    pub(super) fn is_spread(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::Foam(_) => true,
            Self::Conductor(model) => !model.is_smooth(),
            Self::Plastic(model) => model.is_spread(),
            Self::Dielectric(model) => !model.is_smooth(),
            Self::Sheet(_) => false,
        }
    }

    /// The thin sheet, if it is one.
    pub(super) fn sheet(&self) -> Option<&Sheet> {
        match self {
            Self::Sheet(sheet) => Some(sheet),
            Self::Diffuse(_)
            | Self::Conductor(_)
            | Self::Plastic(_)
            | Self::Dielectric(_)
            | Self::Foam(_) => None,
        }
    }

    /// Index on the viewer's side over that beyond, where there are two media.
    pub(super) fn index_ratio(&self) -> Option<f64> {
        match self {
            Self::Dielectric(model) => Some(model.index_ratio()),
            Self::Diffuse(_)
            | Self::Conductor(_)
            | Self::Plastic(_)
            | Self::Foam(_)
            | Self::Sheet(_) => None,
        }
    }

    /// Whether light comes from behind the surface, too.
    pub(super) fn is_two_sided(&self) -> bool {
        matches!(self, Self::Foam(_) | Self::Dielectric(_))
    }
}

/// `view` mirrored about the normal.
fn mirrored(view: DVec3) -> DVec3 {
    DVec3::new(-view.x, -view.y, view.z)
}

/// Relative luminance, in f64.
fn luminance(color: Vec3) -> f64 {
    crate::frame::environment::luminance(color)
}

#[cfg(test)]
mod tests;
