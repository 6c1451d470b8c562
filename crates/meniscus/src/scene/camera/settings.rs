//! The camera as data: `[camera]` and the up direction.

use super::CameraKey;
use glam::DVec3;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// `[camera]`. What is unset frames the objects; see [`Camera::framing`](super::Camera::framing).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSettings {
    /// Where the camera stands, world space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<DVec3>,
    /// What it looks at, world space; the centre of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<DVec3>,
    /// Which way is up.
    pub up: Up,
    /// Vertical field of view in degrees, between 0 and 180.
    pub fov: f64,
    /// `[[camera.key]]`: where it is at several times, in place of `eye` and `target`; it moves in between
    /// and rests before and after.
    #[serde(rename = "key", skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<CameraKey>,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            eye: None,
            target: None,
            up: Up::default(),
            fov: 40.0,
            keys: Vec::new(),
        }
    }
}

impl CameraSettings {
    /// Whether nothing is set.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The direction that is up: `x`, `y`, `z`, `-x`, `-y`, `-z` or three numbers. A unit vector after
/// [`Up::vector`], kept as given here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Up(pub DVec3);

impl Default for Up {
    fn default() -> Self {
        Self(DVec3::Y)
    }
}

/// An up direction that is none of the six axes nor three numbers.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a direction; use x, y, z, -x, -y, -z or three numbers")]
pub struct UpError(pub String);

const AXES: [(&str, DVec3); 6] = [
    ("x", DVec3::X),
    ("y", DVec3::Y),
    ("z", DVec3::Z),
    ("-x", DVec3::NEG_X),
    ("-y", DVec3::NEG_Y),
    ("-z", DVec3::NEG_Z),
];

impl Up {
    /// The unit vector (+Y where the stored one has no direction).
    pub fn vector(self) -> DVec3 {
        self.0.normalize_or(DVec3::Y)
    }
}

impl FromStr for Up {
    type Err = UpError;

    fn from_str(text: &str) -> Result<Self, UpError> {
        if let Some((_, axis)) = AXES.iter().find(|(name, _)| *name == text) {
            return Ok(Self(*axis));
        }
        let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(Self(DVec3::new(x, y, z))),
            _ => Err(UpError(text.to_owned())),
        }
    }
}

impl Serialize for Up {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match AXES.iter().find(|(_, axis)| *axis == self.0) {
            Some((name, _)) => serializer.serialize_str(name),
            None => self.0.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Up {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(UpVisitor)
    }
}

struct UpVisitor;

impl<'de> Visitor<'de> for UpVisitor {
    type Value = Up;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a direction (\"x\", \"y\", \"z\", \"-x\", \"-y\", \"-z\" or three numbers)")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Up, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, items: A) -> Result<Up, A::Error> {
        <[f64; 3]>::deserialize(serde::de::value::SeqAccessDeserializer::new(items))
            .map(|up| Up(up.into()))
    }
}
