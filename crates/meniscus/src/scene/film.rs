//! The film's settings: size, samples, exposure, background.

use super::Color;
use super::color::ColorError;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::str::FromStr;

/// Most pixels along one side.
pub const MAX_SIDE: u32 = 65_536;
/// Most pixels in a picture.
pub const MAX_PIXELS: u64 = 1 << 30;
/// Most samples per pixel.
pub const MAX_SPP: u32 = 1 << 20;

/// `[film]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FilmSettings {
    /// Pixels across, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Pixels down, 1 to [`MAX_SIDE`].
    pub height: u32,
    /// Samples per pixel; 1 samples pixel centres.
    pub spp: u32,
    /// Exposure in stops: radiance is multiplied by 2^exposure before the tone curve.
    pub exposure: f64,
    /// What light counts as white; unset, that of the screen (D65, 6504 K).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white_balance: Option<WhiteBalance>,
    /// Adaptive sampling: the noise at which a part of the picture is done, as the standard error of
    /// its pixels relative to their brightness (plus a twentieth of white). `spp` is the most that a
    /// pixel gets then; unset, every pixel gets `spp`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// What is behind the surfaces; unset, PNG shows the sky and EXR is transparent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<Background>,
}

impl Default for FilmSettings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            spp: 16,
            exposure: 0.0,
            white_balance: None,
            noise: None,
            background: None,
        }
    }
}

/// The light that a developed picture shows as white: a colour temperature in kelvin (a number) or a
/// colour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum WhiteBalance {
    /// Daylight or incandescent light of this correlated colour temperature, [`MIN_KELVIN`] to
    /// [`MAX_KELVIN`].
    Kelvin(f64),
    /// A colour; its brightness does not matter.
    Color(Color),
}

/// Lowest colour temperature of [`WhiteBalance::Kelvin`].
pub const MIN_KELVIN: f64 = 1667.0;
/// Highest colour temperature of [`WhiteBalance::Kelvin`].
pub const MAX_KELVIN: f64 = 25_000.0;

/// What a ray that hits nothing sees.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Background {
    /// The sky that lights the scene.
    #[default]
    Sky,
    /// Nothing: alpha 0.
    Transparent,
    /// One colour.
    Color(Color),
}

/// A background that is none of `sky`, `transparent`, `#rrggbb`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a background; use sky, transparent or #rrggbb")]
pub struct BackgroundError(pub String);

impl FromStr for Background {
    type Err = BackgroundError;

    fn from_str(text: &str) -> Result<Self, BackgroundError> {
        match text {
            "sky" => Ok(Self::Sky),
            "transparent" => Ok(Self::Transparent),
            _ => text
                .parse()
                .map(Self::Color)
                .map_err(|ColorError(text)| BackgroundError(text)),
        }
    }
}

impl Serialize for Background {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Sky => serializer.serialize_str("sky"),
            Self::Transparent => serializer.serialize_str("transparent"),
            Self::Color(color) => color.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Background {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(BackgroundVisitor)
    }
}

struct BackgroundVisitor;

impl<'de> serde::de::Visitor<'de> for BackgroundVisitor {
    type Value = Background;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a background (\"sky\", \"transparent\", \"#rrggbb\" or three linear numbers)")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Background, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: serde::de::SeqAccess<'de>>(self, items: A) -> Result<Background, A::Error> {
        Color::deserialize(serde::de::value::SeqAccessDeserializer::new(items))
            .map(Background::Color)
    }
}
