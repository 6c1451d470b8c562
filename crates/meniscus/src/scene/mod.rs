//! The scene at rest: plain serialisable data, as scene files and the command line describe it.
//!
//! [`Scene`] follows the scene file key by key; [`file`](mod@file) reads and writes it,
//! [`Scene::validate`] says what is wrong with it. Angles are degrees here, radians from
//! [`camera::Camera`] on. To add a key: one field in the struct of its table, and its check in
//! `validate.rs`.

pub mod attribute;
pub mod camera;
pub mod color;
pub mod colormap;
pub mod cues;
pub mod engine;
pub mod file;
pub mod film;
pub mod generate;
pub mod integrator;
pub mod lights;
pub mod materials;
pub mod motion;
pub mod placement;
pub mod preset;
pub mod surface;
mod validate;

pub use camera::{CameraKey, CameraSettings, Up};
pub use color::Color;
pub use colormap::ColorMap;
pub use cues::CueSettings;
pub use engine::{
    Builder, Clipping, EngineSettings, LeafCost, Leaves, MOST_TIME_SLABS, MotionBounds, PeelVariant,
};
pub use file::{SceneError, SceneErrorKind};
pub use film::{Background, FilmSettings, WhiteBalance};
pub use integrator::{IntegratorKind, IntegratorSettings};
pub use lights::{Light, LightKind};
pub use materials::{Material, MaterialKind};
pub use motion::MotionSettings;
pub use placement::{Clip, ClipError, Ground, Instance, Matrix, Mesh, PlacementKey, Plane, Sphere};
pub use preset::Preset;
pub use surface::{Anisotropy, BlobSettings, Surface, SurfaceKind, Weights};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Everything that a picture is made of, as written in a scene file (TOML or JSON).
///
/// The default is an empty scene with the default camera, film and integrator. An empty list of
/// lights stands for [`Light::defaults`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// `[camera]`: where the picture is taken from.
    #[serde(skip_serializing_if = "CameraSettings::is_default")]
    pub camera: CameraSettings,
    /// `[film]`: size, samples and development of the picture.
    pub film: FilmSettings,
    /// `[motion]`: motion blur.
    #[serde(skip_serializing_if = "MotionSettings::is_default")]
    pub motion: MotionSettings,
    /// `[cues]`: silhouettes and depth shading.
    #[serde(skip_serializing_if = "CueSettings::is_default")]
    pub cues: CueSettings,
    /// `[integrator]`: how light is gathered.
    pub integrator: IntegratorSettings,
    /// `[engine]`: switches of the papers' engines.
    #[serde(skip_serializing_if = "EngineSettings::is_default")]
    pub engine: EngineSettings,
    /// `[[surface]]`: implicit surfaces, each from a particle file.
    #[serde(rename = "surface", skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<Surface>,
    /// `[[instance]]`: placements of surfaces. A surface that none of them names stands once, where
    /// its file puts it.
    #[serde(rename = "instance", skip_serializing_if = "Vec::is_empty")]
    pub instances: Vec<Instance>,
    /// `[[mesh]]`: triangle meshes.
    #[serde(rename = "mesh", skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    /// `[[sphere]]`: balls.
    #[serde(rename = "sphere", skip_serializing_if = "Vec::is_empty")]
    pub spheres: Vec<Sphere>,
    /// `[[plane]]`: infinite planes.
    #[serde(rename = "plane", skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<Plane>,
    /// `[[clip]]`: cuts through everything that has an inside.
    #[serde(rename = "clip", skip_serializing_if = "Vec::is_empty")]
    pub clips: Vec<Clip>,
    /// `[ground]`: a plane right under the objects; present or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<Ground>,
    /// `[[light]]`: lights; none stands for [`Light::defaults`].
    #[serde(rename = "light", skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<Light>,
    /// `[material.NAME]`: materials by name.
    #[serde(rename = "material", skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, Material>,
}
