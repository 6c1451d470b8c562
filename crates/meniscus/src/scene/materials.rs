//! Materials as data.

use super::Color;
use serde::{Deserialize, Serialize};

/// A kind of material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MaterialKind {
    /// A diffuse base under a soft highlight.
    #[default]
    Glossy,
    /// A diffuse base alone.
    Diffuse,
    /// A diffuse base under a clear coat of a stated index.
    Plastic,
    /// A conductor; its colour is its reflectance head on.
    Metal,
    /// A perfect mirror.
    Mirror,
    /// A clear dielectric of a stated index.
    Dielectric,
    /// Window glass.
    Glass,
    /// Water, which takes red light away with depth.
    Water,
    /// Thin froth that scatters light to both sides.
    Foam,
}

impl MaterialKind {
    /// Every kind.
    pub const ALL: [Self; 9] = [
        Self::Glossy,
        Self::Diffuse,
        Self::Plastic,
        Self::Metal,
        Self::Mirror,
        Self::Dielectric,
        Self::Glass,
        Self::Water,
        Self::Foam,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glossy => "glossy",
            Self::Diffuse => "diffuse",
            Self::Plastic => "plastic",
            Self::Metal => "metal",
            Self::Mirror => "mirror",
            Self::Dielectric => "dielectric",
            Self::Glass => "glass",
            Self::Water => "water",
            Self::Foam => "foam",
        }
    }

    /// Whether light passes through it into a medium.
    pub fn is_clear(self) -> bool {
        matches!(self, Self::Dielectric | Self::Glass | Self::Water)
    }

    /// Whether its surface can be rough; thin sheets cannot.
    pub fn takes_roughness(self) -> bool {
        matches!(self, Self::Glossy | Self::Plastic | Self::Metal) || self.is_clear()
    }

    /// Whether it has an index of refraction.
    pub fn takes_ior(self) -> bool {
        self == Self::Plastic || self.is_clear()
    }

    /// The colour of a material that states none.
    fn default_color(self) -> Color {
        match self {
            Self::Glossy | Self::Diffuse | Self::Plastic => Color([0.52, 0.56, 0.60]),
            // Silver, from its measured n and k (Johnson & Christy 1972), as Rec. 709 reflectance.
            Self::Metal => Color([0.962, 0.949, 0.922]),
            Self::Mirror => Color::WHITE,
            Self::Dielectric | Self::Glass => Color([0.62, 0.66, 0.68]),
            Self::Water => Color([0.045, 0.23, 0.42]),
            Self::Foam => Color([0.9, 0.9, 0.9]),
        }
    }
}

/// `[material.NAME]`. Which keys a material takes depends on its type; the others must be absent.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// The kind of material.
    #[serde(rename = "type")]
    pub kind: MaterialKind,
    /// Base colour, each component in [0, 1]: diffuse albedo; of metals and mirrors the reflectance
    /// head on; of foam all that it scatters. Clear materials show it under `shaded` alone, which
    /// does not look through them. A surface's `color_by` replaces it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Glossy: strength of the highlight, 0 none, 1 that of a dielectric of index 1.5 (reflectance
    /// 0.04 head on).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular: Option<f64>,
    /// Glossy, plastic, metal, clear: width of the highlight, 0 (sharp) to 1 (spread out); the GGX
    /// width is its square.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
    /// Plastic and clear: index of refraction, [`MIN_IOR`] to [`MAX_IOR`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ior: Option<f64>,
    /// Clear: the colour that white light has behind `absorption_depth` of it, each component above
    /// 0 and at most 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption: Option<Color>,
    /// Clear: the depth, in the scene's unit, at which light has the colour `absorption`; unset, half
    /// the largest side of what the scene shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption_depth: Option<f64>,
    /// Clear: which one fills a place that lies inside several, the largest wins (Schmidt & Budge
    /// 2002). A liquid in a glass has less than the glass, and its surface reaches into the wall.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub priority: Option<i32>,
    /// Clear: whether the surface is a thin sheet with the same on both sides, as a window or the wall
    /// of a bubble, instead of the boundary of a body. Light goes straight through it, shadows are as
    /// light as what it lets through, and it may have holes. `absorption` is the colour left by the
    /// sheet head on (by default white); it takes no `absorption_depth`, `priority` or `roughness`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thin: Option<bool>,
    /// Foam: part of the scattered light that goes through, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub translucency: Option<f64>,
}

/// Smallest index of refraction: that of vacuum.
pub const MIN_IOR: f64 = 1.0;
/// Largest index of refraction that makes sense for light; germanium has 4.
pub const MAX_IOR: f64 = 5.0;

impl Material {
    /// [`Material::specular`] of a glossy material that states none.
    pub const DEFAULT_SPECULAR: f64 = 1.0;
    /// [`Material::roughness`] of a glossy material that states none.
    pub const DEFAULT_ROUGHNESS: f64 = 0.35;

    /// A glossy material.
    pub const fn glossy(color: Color, specular: f64, roughness: f64) -> Self {
        Self {
            specular: Some(specular),
            roughness: Some(roughness),
            ..Self::of(MaterialKind::Glossy, Some(color))
        }
    }

    /// A diffuse material.
    pub const fn diffuse(color: Color) -> Self {
        Self::of(MaterialKind::Diffuse, Some(color))
    }

    /// A material of a kind and colour, everything else by default.
    pub const fn of(kind: MaterialKind, color: Option<Color>) -> Self {
        Self {
            kind,
            color,
            specular: None,
            roughness: None,
            ior: None,
            absorption: None,
            absorption_depth: None,
            priority: None,
            thin: None,
            translucency: None,
        }
    }

    /// Whether it is a thin sheet.
    pub fn is_thin(&self) -> bool {
        self.thin == Some(true)
    }

    /// Base colour.
    pub fn effective_color(&self) -> Color {
        self.color.unwrap_or_else(|| self.kind.default_color())
    }

    /// Strength of the highlight that integrator `shaded` shows: 0 for what has none.
    pub fn effective_specular(&self) -> f64 {
        match self.kind {
            MaterialKind::Diffuse | MaterialKind::Foam => 0.0,
            _ => self.specular.unwrap_or(Self::DEFAULT_SPECULAR),
        }
    }

    /// Width of the highlight.
    pub fn effective_roughness(&self) -> f64 {
        self.roughness.unwrap_or(match self.kind {
            MaterialKind::Glossy | MaterialKind::Diffuse | MaterialKind::Foam => {
                Self::DEFAULT_ROUGHNESS
            }
            MaterialKind::Plastic => 0.15,
            MaterialKind::Metal => 0.2,
            MaterialKind::Mirror
            | MaterialKind::Dielectric
            | MaterialKind::Glass
            | MaterialKind::Water => 0.0,
        })
    }

    /// Index of refraction at the sodium line (589 nm): of acrylic glass for plastic 1.491, of crown
    /// glass BK7 1.517, of water at 20 °C 1.333.
    pub fn effective_ior(&self) -> f64 {
        self.ior.unwrap_or(match self.kind {
            MaterialKind::Plastic => 1.491,
            MaterialKind::Glass => 1.517,
            MaterialKind::Water => 1.333,
            // The index whose reflectance head on is 0.04.
            _ => 1.5,
        })
    }

    /// The colour of white light behind [`Material::absorption_depth`]. Pure water absorbs 0.2644,
    /// 0.0565 and 0.0092 per metre at 600, 550 and 450 nm (Pope & Fry, Applied Optics 36(33), 1997):
    /// the default of water has that ratio and leaves 0.3 of the red.
    pub fn effective_absorption(&self) -> Color {
        self.absorption.unwrap_or(match self.kind {
            MaterialKind::Water if !self.is_thin() => Color([0.3, 0.773, 0.959]),
            _ => Color::WHITE,
        })
    }

    /// Rank among media that overlap; glass stands above liquids.
    pub fn effective_priority(&self) -> i32 {
        self.priority.unwrap_or(match self.kind {
            MaterialKind::Glass => 10,
            _ => 0,
        })
    }

    /// Part of the light scattered by foam that goes through.
    pub fn effective_translucency(&self) -> f64 {
        self.translucency.unwrap_or(0.5)
    }
}
