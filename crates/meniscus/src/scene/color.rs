//! Colours: linear Rec. 709 inside, `#rrggbb` or three linear numbers in files.

use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// A colour: linear Rec. 709 red, green, blue. In files and flags either three linear numbers or
/// an sRGB hex code `#rrggbb` (or `#rgb`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Color(pub [f64; 3]);

/// A colour that is not `#rrggbb`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a colour; write #rrggbb or three linear numbers")]
pub struct ColorError(pub String);

impl Color {
    /// White.
    pub const WHITE: Self = Self([1.0; 3]);

    /// From 8-bit sRGB codes.
    pub fn from_srgb8(code: [u8; 3]) -> Self {
        Self(code.map(|c| linear_from_srgb(f64::from(c) / 255.0)))
    }

    /// Red, green, blue as f32.
    pub fn to_f32(self) -> [f32; 3] {
        self.0.map(|c| c as f32)
    }
}

/// The linear value of an sRGB component in [0, 1] (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

impl FromStr for Color {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, ColorError> {
        let wrong = || ColorError(text.to_owned());
        let digits = text
            .strip_prefix('#')
            .and_then(|hex| {
                hex.chars()
                    .map(|c| c.to_digit(16))
                    .collect::<Option<Vec<_>>>()
            })
            .ok_or_else(wrong)?;
        let code = |i: usize| match digits.len() {
            3 => Some(digits[i] * 17),
            6 => Some(digits[2 * i] * 16 + digits[2 * i + 1]),
            _ => None,
        };
        match (code(0), code(1), code(2)) {
            (Some(r), Some(g), Some(b)) => Ok(Self::from_srgb8([r as u8, g as u8, b as u8])),
            _ => Err(wrong()),
        }
    }
}

impl Serialize for Color {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColorVisitor)
    }
}

struct ColorVisitor;

impl<'de> Visitor<'de> for ColorVisitor {
    type Value = Color;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a colour (\"#rrggbb\" or three linear numbers)")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Color, E> {
        text.parse().map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Color, A::Error> {
        let mut color = [0.0; 3];
        for (i, component) in color.iter_mut().enumerate() {
            *component = items
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        Ok(Color(color))
    }
}
