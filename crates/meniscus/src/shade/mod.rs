//! What surfaces look like: materials, direct light, sky.

mod attributes;
mod gloss;
mod shaded;
mod sky;

pub use attributes::{AttributeLayout, frame_attributes};
pub use shaded::{RayCounts, Seen, ShadeScratch, Shader};
pub use sky::Sky;
