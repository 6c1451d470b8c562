//! Meniscus ray traces the smooth surface that particles define.
//!
//! Particle file → [`particles::Particles`] → [`scene`] → [`frame::Frame`] → [`math::ray::Ray`] →
//! [`intersect::Hit`] → radiance → [`film`] → image file. The modules below stand in that order,
//! and each uses only those above it (`tests/pipeline_order.rs` checks it).

pub mod math;
pub mod particles;
pub mod mesh;
pub mod kernel;
pub mod primitive;
pub mod scene;
pub mod field;
pub mod accel;
pub mod frame;
pub mod intersect;
pub mod shade;
pub mod film;
pub mod render;
