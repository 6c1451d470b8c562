//! What turns particles into a surface: support, kernel, threshold, weights.

use super::attribute::ELEMENT_COLOR;
use super::colormap::ColorMap;
use crate::kernel::Kernel;
use crate::particles::io::Format;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How much each particle counts in the field.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Weights {
    /// 1 for every particle.
    Unit,
    /// The SPH particle volume: wᵢ = 1/Σⱼ k(qⱼ(xᵢ))·det Aⱼ/det Aᵢ, so that F ≈ 1 in the bulk.
    #[default]
    Volume,
    /// The same of the balls that `--anisotropy estimate` stretched, times det A·R³: each particle keeps
    /// the volume that it has among balls, as in the field of Yu & Turk 2013. Without the estimate it is
    /// [`Weights::Volume`].
    BallVolume,
    /// The values of a column; negative ones cut holes.
    Column(String),
}

impl Weights {
    /// Whether they are particle volumes; then radii are half the spacing.
    pub fn are_volumes(&self) -> bool {
        matches!(self, Self::Volume | Self::BallVolume)
    }

    /// The form used in files and flags: `unit`, `volume`, `ball-volume` or the column's name.
    pub fn name(&self) -> &str {
        match self {
            Self::Unit => "unit",
            Self::Volume => "volume",
            Self::BallVolume => "ball-volume",
            Self::Column(name) => name,
        }
    }
}

impl From<String> for Weights {
    fn from(name: String) -> Self {
        match name.as_str() {
            "unit" => Self::Unit,
            "volume" => Self::Volume,
            "ball-volume" => Self::BallVolume,
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

/// Where the shapes of supports come from, unless a setting names the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Anisotropy {
    /// Columns of usual names that hold metrics, ellipsoids or deformation gradients; balls where there
    /// are none.
    #[default]
    Auto,
    /// Nowhere: they are balls.
    None,
    /// The arrangement of the neighbours, which also smooths the centres (Yu & Turk 2013).
    Estimate,
    /// The anisotropic displacements of atoms.
    Thermal,
}

impl Anisotropy {
    /// Every kind with its name in files and flags.
    pub const ALL: [(&'static str, Self); 4] = [
        ("auto", Self::Auto),
        ("none", Self::None),
        ("estimate", Self::Estimate),
        ("thermal", Self::Thermal),
    ];
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
    /// Column with the metric M of q = dᵀMd, in the file's unit: six components (xx xy xz yy yz zz, or
    /// VTK's xx yy zz xy yz xz) or nine. It makes ellipsoids and takes the place of all radii; without
    /// this setting a column of a usual name (`metric`, …) does.
    pub metric: Option<String>,
    /// Column with an ellipsoid's three radii along its axes; they mean what [`BlobSettings::radius`]
    /// does. This and the following three may be several columns parted by commas.
    pub radii: Option<String>,
    /// Columns with an ellipsoid's axes, three vectors; without `radii` their lengths are the radii.
    pub axes: Option<String>,
    /// Column with the quaternion x y z w that turns an ellipsoid with `radii` (w x y z where the
    /// column's usual name says so).
    pub orientation: Option<String>,
    /// Column with the deformation gradient F, row by row: the support is F's image of the ball that the
    /// radius gives.
    pub deformation: Option<String>,
    /// Where shapes come from, if none of the five names a column.
    pub anisotropy: Anisotropy,
    /// Share of the time that an atom spends within its thermal ellipsoid, above 0 and below 1.
    pub probability: f64,
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
            metric: None,
            radii: None,
            axes: None,
            orientation: None,
            deformation: None,
            anisotropy: Anisotropy::Auto,
            probability: 0.5,
            smoothing: 4.0,
            kernel: Kernel::Sextic,
            threshold: 0.6,
            weights: Weights::Volume,
            filter: None,
            attributes: Vec::new(),
        }
    }
}

impl BlobSettings {
    /// What a file of this format starts from.
    pub fn of_format(format: Format) -> Self {
        if format.is_molecule() {
            Self::molecule()
        } else {
            Self::default()
        }
    }

    /// What molecules start from: unit weights, quartic kernel, T = 0.2.
    pub fn molecule() -> Self {
        Self {
            kernel: Kernel::Quartic,
            threshold: 0.2,
            weights: Weights::Unit,
            ..Self::default()
        }
    }
}

/// How a surface is defined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SurfaceKind {
    /// The isosurface of particles.
    #[default]
    Blobs,
    /// The isosurface around bones.
    Skeleton,
    /// A surface through points with normals.
    Points,
}

impl SurfaceKind {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blobs => "blobs",
            Self::Skeleton => "skeleton",
            Self::Points => "points",
        }
    }

    /// Whether this version can render it.
    pub fn is_supported(self) -> bool {
        matches!(self, Self::Blobs)
    }
}

/// `[[surface]]`. Settings that are unset take the defaults of the file's format: those of fluids
/// ([`BlobSettings::default`]) or of molecules ([`BlobSettings::molecule`]).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Surface {
    /// Name that instances refer to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How the surface is defined.
    #[serde(rename = "type")]
    pub kind: SurfaceKind,
    /// Particle file; relative to the scene file.
    pub file: PathBuf,
    /// See [`BlobSettings::radius`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// See [`BlobSettings::support`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support: Option<f64>,
    /// See [`BlobSettings::metric`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metric: Option<String>,
    /// See [`BlobSettings::radii`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radii: Option<String>,
    /// See [`BlobSettings::axes`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<String>,
    /// See [`BlobSettings::orientation`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation: Option<String>,
    /// See [`BlobSettings::deformation`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deformation: Option<String>,
    /// See [`BlobSettings::anisotropy`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anisotropy: Option<Anisotropy>,
    /// See [`BlobSettings::probability`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// See [`BlobSettings::smoothing`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<f64>,
    /// See [`BlobSettings::kernel`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<Kernel>,
    /// See [`BlobSettings::threshold`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// See [`BlobSettings::weights`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<Weights>,
    /// See [`BlobSettings::filter`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub filter: Option<String>,
    /// See [`BlobSettings::attributes`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub attributes: Vec<String>,
    /// Column that colours the surface: `speed`, `velocity` (its magnitude), `velocity.x`; or `color`
    /// for the particles' own colours and `element` for those of the elements. Unset, a molecule
    /// format without a material shows elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_by: Option<String>,
    /// Colour map; unset, viridis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_map: Option<ColorMap>,
    /// Values at the two ends of the colour map; unset, those of the frame without the
    /// lowest and highest hundredth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color_range: Option<[f64; 2]>,
    /// Column that gives the material its roughness, written as for `color_by`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness_by: Option<String>,
    /// Values of that column that mean roughness 0 and 1; unset, 0 and 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness_range: Option<[f64; 2]>,
    /// Column that multiplies the absorption of a clear material, wherever light goes through it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption_by: Option<String>,
    /// Values of that column that mean no absorption and the material's own; unset, 0 and 1. Beyond
    /// them it goes on in proportion, never below 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorption_range: Option<[f64; 2]>,
    /// Name of the material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl Surface {
    /// A surface of the particles in `file`, everything else by default.
    pub fn from_file(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            ..Self::default()
        }
    }

    /// What colours the surface of a file of this format, see [`Surface::color_by`].
    pub fn color_by_of(&self, format: Format) -> Option<&str> {
        let shows_elements = format.is_molecule() && self.material.is_none();
        let default = shows_elements.then_some(ELEMENT_COLOR);
        self.color_by.as_deref().or(default)
    }

    /// The settings of the field: what is unset comes from `base`. Columns that the colour or the
    /// weights need are not added to the attributes here.
    pub fn settings(&self, base: &BlobSettings) -> BlobSettings {
        let base = base.clone();
        BlobSettings {
            radius: self.radius.or(base.radius),
            support: self.support.or(base.support),
            metric: self.metric.clone().or(base.metric),
            radii: self.radii.clone().or(base.radii),
            axes: self.axes.clone().or(base.axes),
            orientation: self.orientation.clone().or(base.orientation),
            deformation: self.deformation.clone().or(base.deformation),
            anisotropy: self.anisotropy.unwrap_or(base.anisotropy),
            probability: self.probability.unwrap_or(base.probability),
            smoothing: self.smoothing.unwrap_or(base.smoothing),
            kernel: self.kernel.unwrap_or(base.kernel),
            threshold: self.threshold.unwrap_or(base.threshold),
            weights: self.weights.clone().unwrap_or(base.weights),
            filter: self.filter.clone().or(base.filter),
            attributes: if self.attributes.is_empty() {
                base.attributes
            } else {
                self.attributes.clone()
            },
        }
    }
}
