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
mod rays;
mod world;

pub use attributes::{AttributeLayout, frame_attributes};
pub use integrator::{ShadeSettings, Shader};
pub use light::Sky;
pub use rays::{EyeRays, RayCounts, Seen, ShadeScratch};
