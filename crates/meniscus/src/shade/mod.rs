//! What surfaces look like: how they scatter light, where light comes from, and ways to gather it.

mod antialias;
mod asking;
mod attributes;
mod bsdf;
mod gloss;
mod integrator;
mod interaction;
mod light;
mod medium;
mod probe;
mod rays;
mod stages;
mod world;

pub use attributes::{AttributeLayout, frame_attributes};
pub use integrator::{ShadeSettings, Shader};
pub use light::Sky;
pub use probe::Drawn;
pub use rays::{EyeRays, RayCounts, Seen, ShadeScratch};
pub use stages::{
    ALBEDO_ENTRIES, AMBIENT_WORDS, EMITTER_WORDS, MAP_ENTRIES, MATERIAL_WORDS, MOST_COLUMNS,
    MOST_SURFACES, NO_NUMBER, SURFACE_WORDS, StagedColumns, StagedField, StagedShading, Unstaged,
};
