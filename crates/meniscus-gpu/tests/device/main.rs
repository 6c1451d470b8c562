//! Shaders as they run: on any adapter there is, software too. Without one these tests say that they skip;
//! where `MENISCUS_REQUIRE_GPU=1`, as in CI, they fail.

mod agreement;
mod attributes;
mod build;
mod common;
mod crossings;
mod peel;
mod pictures;
mod staged_highlights;
mod staged_meshes;
mod staged_motion;
mod stages;
