//! How light is gathered.

use serde::{Deserialize, Serialize};

/// A way of gathering light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum IntegratorKind {
    /// Direct light with hard shadows, and soft light from the sky.
    #[default]
    Shaded,
    /// Mirror and refraction trees (Whitted 1980).
    Whitted,
    /// Ambient occlusion alone.
    Ao,
    /// Path tracing.
    Path,
}

impl IntegratorKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Shaded, Self::Whitted, Self::Ao, Self::Path];

    /// The name in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Whitted => "whitted",
            Self::Ao => "ao",
            Self::Path => "path",
        }
    }

    /// The kind of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// `[integrator]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IntegratorSettings {
    /// The way light is gathered.
    #[serde(rename = "type")]
    pub kind: IntegratorKind,
    /// Longest path in surfaces met, at least 1: `path` counts every bounce, `whitted` the levels of
    /// its tree; `shaded` and `ao` never need more than 1.
    pub depth: u32,
    /// `path`: most diffuse bounces among them; unset, `depth` alone counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffuse_depth: Option<u32>,
    /// `path`: most reflections, mirrored or glossy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub glossy_depth: Option<u32>,
    /// `path`: most passages through surfaces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmission_depth: Option<u32>,
    /// `ao`: rays per camera sample, 1 to [`MAX_AO_SAMPLES`]; unset, as many as make 64 per pixel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<u32>,
    /// `ao`: how far occluders count, in the scene's unit; unset, any distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance: Option<f64>,
    /// `path`: largest radiance (of any component) that one light path may add behind its first
    /// surface. It takes fireflies away and energy with them; unset, nothing is clamped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clamp: Option<f64>,
    /// `path`: whether lights reach rough surfaces through and over clear ones as they do in nature,
    /// bent into caustics, which takes many samples where lights are small. If false, suns, lamps
    /// and environment images shine straight through clear surfaces onto rough ones, weakened but not
    /// bent, and what rough surfaces see of mirrors and metals is blurred.
    #[serde(skip_serializing_if = "is_true")]
    pub caustics: bool,
    /// `shaded`, `whitted`, `path`: whether highlights of coats and metals are as wide as the normals
    /// differ within what a sample stands for, a part of its pixel and of the shutter. Small highlights
    /// on curved and on turning surfaces then need fewer samples; the picture is that of sharper ones in
    /// the limit of many.
    #[serde(skip_serializing_if = "is_false")]
    pub specular_antialiasing: bool,
}

/// Most rays of `ao` per camera sample.
pub const MAX_AO_SAMPLES: u32 = 65_536;

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_true(value: &bool) -> bool {
    *value
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_false(value: &bool) -> bool {
    !*value
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            kind: IntegratorKind::default(),
            depth: 8,
            diffuse_depth: None,
            glossy_depth: None,
            transmission_depth: None,
            samples: None,
            distance: None,
            clamp: None,
            caustics: true,
            specular_antialiasing: false,
        }
    }
}

impl IntegratorSettings {
    /// Rays of `ao` for each of `spp` camera samples of a pixel.
    pub fn ao_samples(&self, spp: u32) -> u32 {
        const PER_PIXEL: u32 = 64;
        self.samples
            .unwrap_or_else(|| PER_PIXEL.div_ceil(spp.max(1)))
            .max(1)
    }
}
