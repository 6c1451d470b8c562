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
    /// Light from a small disk in `direction`.
    #[default]
    Sun,
    /// Soft light from everywhere above, paler towards the horizon.
    Sky,
    /// The same light from every direction.
    Constant,
    /// A point at `position`.
    Point,
    /// A ball at `position` of `radius`.
    Sphere,
    /// A rectangle at `position` with `edges`.
    Rectangle,
    /// An environment image from `file`.
    Environment,
}

impl LightKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sun => "sun",
            Self::Sky => "sky",
            Self::Constant => "constant",
            Self::Point => "point",
            Self::Sphere => "sphere",
            Self::Rectangle => "rectangle",
            Self::Environment => "environment",
        }
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
    /// Sun: apparent diameter in degrees, 0 (hard shadows) to below 180; unset, that of our sun.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Point, sphere, rectangle: world position of the centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<DVec3>,
    /// Sphere: radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Rectangle: its two edges, world vectors of full length. It shines towards first × second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edges: Option<[DVec3; 2]>,
    /// Colour, multiplied by `intensity`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Strength ≥ 0. Sun: a white diffuse surface that faces it has radiance `intensity`; point: so
    /// at distance 1. Sky: the mean radiance of the upper half. Constant, sphere, rectangle: the
    /// radiance itself. Environment: the image is multiplied by it.
    pub intensity: f64,
    /// Environment: image file (.hdr or .exr), twice as wide as high: latitude and longitude, its
    /// middle towards the direction that `rotation` turns.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Environment: degrees by which it is turned around the world's up direction, counterclockwise
    /// seen from above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<f64>,
}

impl Default for Light {
    fn default() -> Self {
        Self {
            kind: LightKind::Sun,
            direction: None,
            angle: None,
            position: None,
            radius: None,
            edges: None,
            color: None,
            intensity: 1.0,
            file: None,
            rotation: None,
        }
    }
}

impl Light {
    /// The mean apparent diameter of our sun, in degrees.
    pub const DEFAULT_ANGLE: f64 = 0.533;

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
