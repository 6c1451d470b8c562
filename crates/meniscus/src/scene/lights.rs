//! Lights as data.

use super::Color;
use super::camera::horizontal_axes;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A kind of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightKind {
    /// Parallel light from `direction`.
    #[default]
    Sun,
    /// Soft light from everywhere above.
    Sky,
    /// A point at `position`.
    Point,
    /// A ball at `position` of `radius`.
    Sphere,
    /// An environment image from `file`.
    Environment,
}

impl LightKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sun => "sun",
            Self::Sky => "sky",
            Self::Point => "point",
            Self::Sphere => "sphere",
            Self::Environment => "environment",
        }
    }

    /// Whether this version can render it.
    pub fn is_supported(self) -> bool {
        matches!(self, Self::Sun | Self::Sky)
    }
}

/// `[[light]]`. Which keys a light needs and takes depends on its type; the others must be absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// The kind of light.
    #[serde(rename = "type")]
    pub kind: LightKind,
    /// Sun: world direction from the scene towards the light, any length but 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<DVec3>,
    /// Point and sphere: world position.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<DVec3>,
    /// Sphere: radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Colour, multiplied by `intensity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Strength ≥ 0. Sun: a white diffuse surface that faces it has radiance `intensity`. Sky: the
    /// mean radiance of the upper half.
    pub intensity: f64,
    /// Environment: image file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Sun,
            direction: None,
            position: None,
            radius: None,
            color: None,
            intensity: 1.0,
            file: None,
        }
    }
}

impl Light {
    /// A sun; `towards` points from the scene to it.
    pub fn sun(towards: DVec3) -> Self {
        Self {
            direction: Some(towards),
            intensity: 1.5,
            color: Some(Color([1.0, 0.95, 0.87])),
            ..Self::default()
        }
    }

    /// What lights a scene that names no light: a sun that stands high to the left behind the
    /// default camera, and a sky. `up` is the camera's.
    pub fn defaults(up: DVec3) -> Vec<Self> {
        let [side, back] = horizontal_axes(up);
        vec![Self::sun(1.1 * up + 0.35 * side + 0.9 * back), Self::sky()]
    }

    /// A soft, slightly blue sky.
    pub fn sky() -> Self {
        Self {
            kind: LightKind::Sky,
            color: Some(Color([0.82, 0.91, 1.0])),
            intensity: 0.5,
            ..Self::default()
        }
    }
}
