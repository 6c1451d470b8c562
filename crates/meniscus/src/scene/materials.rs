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
    /// A perfect mirror.
    Mirror,
    /// A conductor.
    Metal,
    /// A clear dielectric.
    Glass,
    /// A clear liquid with absorption.
    Water,
}

impl MaterialKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glossy => "glossy",
            Self::Diffuse => "diffuse",
            Self::Mirror => "mirror",
            Self::Metal => "metal",
            Self::Glass => "glass",
            Self::Water => "water",
        }
    }

    /// Whether this version can render it.
    pub fn is_supported(self) -> bool {
        matches!(self, Self::Glossy | Self::Diffuse)
    }
}

/// `[material.NAME]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// The kind of material.
    #[serde(rename = "type")]
    pub kind: MaterialKind,
    /// Base colour (diffuse albedo), each component in [0, 1]. A surface's `color_by` replaces it.
    pub color: Color,
    /// Glossy: strength of the highlight, 0 none, 1 that of a dielectric of index 1.5 (reflectance
    /// 0.04 head on).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular: Option<f64>,
    /// Glossy: width of the highlight, 0 (sharp) to 1 (spread out).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            kind: MaterialKind::Glossy,
            color: Color([0.52, 0.56, 0.60]),
            specular: None,
            roughness: None,
        }
    }
}

impl Material {
    /// [`Material::specular`] of a glossy material that states none.
    pub const DEFAULT_SPECULAR: f64 = 1.0;
    /// [`Material::roughness`] of a glossy material that states none.
    pub const DEFAULT_ROUGHNESS: f64 = 0.35;

    /// A glossy material.
    pub fn glossy(color: Color, specular: f64, roughness: f64) -> Self {
        Self {
            kind: MaterialKind::Glossy,
            color,
            specular: Some(specular),
            roughness: Some(roughness),
        }
    }

    /// A diffuse material.
    pub fn diffuse(color: Color) -> Self {
        Self {
            kind: MaterialKind::Diffuse,
            color,
            specular: None,
            roughness: None,
        }
    }

    /// Strength of the highlight: 0 for a diffuse material.
    pub fn effective_specular(&self) -> f64 {
        match self.kind {
            MaterialKind::Diffuse => 0.0,
            _ => self.specular.unwrap_or(Self::DEFAULT_SPECULAR),
        }
    }

    /// Width of the highlight.
    pub fn effective_roughness(&self) -> f64 {
        self.roughness.unwrap_or(Self::DEFAULT_ROUGHNESS)
    }
}
