//! Numbers, vectors, boxes, rays and SIMD lanes: no knowledge of particles or scenes.

pub mod aabb;
pub mod cubics;
pub mod differential;
pub mod dual;
pub mod keyframes;
pub mod level_set;
pub mod morton;
pub mod number;
pub mod ray;
pub mod sampling;
pub mod simd;
pub mod symmetric;
pub mod turning;

pub use glam::{DAffine3, DMat3, DVec3, Mat3, Vec3};
