//! What turns particles into a surface: support, kernel, threshold, weights.

use crate::kernel::Kernel;
use serde::{Deserialize, Serialize};

/// How much each particle counts in the field.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Weights {
    /// 1 for every particle.
    Unit,
    /// The SPH particle volume: wᵢ = 1/Σⱼ k(qⱼ(xᵢ))·det Aⱼ/det Aᵢ, so that F ≈ 1 in the bulk.
    #[default]
    Volume,
    /// The values of a column; negative ones cut holes.
    Column(String),
}

impl Weights {
    /// The form used in files and flags: `unit`, `volume` or the column's name.
    pub fn name(&self) -> &str {
        match self {
            Self::Unit => "unit",
            Self::Volume => "volume",
            Self::Column(name) => name,
        }
    }
}

impl From<String> for Weights {
    fn from(name: String) -> Self {
        match name.as_str() {
            "unit" => Self::Unit,
            "volume" => Self::Volume,
            _ => Self::Column(name),
        }
    }
}

impl Serialize for Weights {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for Weights {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self::from)
    }
}

/// The numbers that define the isosurface F(x) = Σ wᵢ k(qᵢ(x)) = T of a particle set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BlobSettings {
    /// Particle radius, in the file's unit; replaces the file's own radii. Meaning: half the spacing
    /// with volume weights, the surface of a lone particle otherwise.
    pub radius: Option<f64>,
    /// Support radius R for every particle; overrides all radii.
    pub support: Option<f64>,
    /// R over the radius with volume weights (4: SPH's usual support).
    pub smoothing: f64,
    /// Kernel.
    pub kernel: Kernel,
    /// Threshold T > 0.
    pub threshold: f64,
    /// Weights.
    pub weights: Weights,
    /// Keep only particles for which this expression over columns holds.
    pub filter: Option<String>,
    /// Columns carried along for blending on the surface.
    pub attributes: Vec<String>,
}

impl Default for BlobSettings {
    fn default() -> Self {
        Self {
            radius: None,
            support: None,
            smoothing: 4.0,
            kernel: Kernel::Sextic,
            threshold: 0.6,
            weights: Weights::Volume,
            filter: None,
            attributes: Vec::new(),
        }
    }
}
