//! Meniscus on a graphics card, by wgpu: the same fields and trees as on the CPU, traced by compute
//! shaders that are named as their CPU twins.
//!
//! [`Device::open`] chooses a card, [`BlobTracer`](meniscus::intersect::BlobTracer) is what renderers ask:
//! [`FrameTracer`] uploads the fields of a frame and answers rays on them. Rays that f32 cannot decide
//! are marked by the shaders and answered by the CPU engine, so that every answer is one.

mod batch;
mod build;
mod chunks;
mod crossings;
mod device;
mod error;
mod frame;
#[cfg(test)]
mod gather_tests;
#[cfg(test)]
mod leaf_math_tests;
mod pack;
mod peel;
mod program;
mod readback;
mod shader;
mod stage;
mod stages;
#[cfg(test)]
mod test_device;
mod tracer;
mod uploaded;

pub use device::{AdapterChoice, Device, OpenOptions};
pub use error::GpuError;
pub use frame::{FrameTracer, Takeover};
pub use peel::{
    Clipping, PeelField, PeelKind, PeelModule, PeelOptions, PeelTracer, PeelWork, StageSecs, View,
    peel_sources,
};
pub use shader::{BuildKind, BuildStep, FieldMotion, ShaderKind, sources};
pub use stages::{FieldStage, StageModule};
pub use tracer::{FieldTracer, TraceWork, TracerOptions, TreeUpdate};
