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

    /// Whether this version can render with it.
    pub fn is_supported(self) -> bool {
        matches!(self, Self::Shaded)
    }
}

/// `[integrator]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IntegratorSettings {
    /// The way light is gathered.
    #[serde(rename = "type")]
    pub kind: IntegratorKind,
    /// Longest path in surfaces met, at least 1; `shaded` never needs more than 1.
    pub depth: u32,
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            kind: IntegratorKind::default(),
            depth: 8,
        }
    }
}
