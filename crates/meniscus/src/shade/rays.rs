//! Counts of rays, what the eye saw, and what a thread reuses.

use super::attributes::SurfaceAttributes;
use crate::intersect::{Hit, Scratch};
use crate::math::ray::Ray;

/// Rays traced, by purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// From the eye.
    pub primary: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Refracted.
    pub refraction: u64,
    /// For ambient occlusion.
    pub ambient_occlusion: u64,
    /// Scattered diffusely.
    pub diffuse: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
        self.ambient_occlusion += other.ambient_occlusion;
        self.diffuse += other.diffuse;
    }
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary
            + self.shadow
            + self.reflection
            + self.refraction
            + self.ambient_occlusion
            + self.diffuse
    }
}

/// What a primary ray saw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Linear Rec. 709 radiance, premultiplied by coverage; with the sky if that is the background.
    pub radiance: [f32; 3],
    /// 1 on a surface, else 0.
    pub coverage: f32,
    /// Share of the background that shows: 1 beside surfaces, and more and more of it on the ground
    /// towards the horizon.
    pub backdrop: f32,
    /// Base colour, before any light; 0 beside surfaces.
    pub albedo: [f32; 3],
    /// What denoisers may take for it: white where light goes through.
    pub denoising_albedo: [f32; 3],
    /// What was hit.
    pub hit: Option<Hit>,
    /// Row in its file of the strongest particle.
    pub row: Option<u32>,
}

/// Rays of the eye that are traced together: samples of neighbouring pixels.
///
/// What one of them finds may depend on the others in its last bits. So that pictures do not depend
/// on regions, tiles or threads, the same rays always have to go together.
#[derive(Debug, Default)]
pub struct EyeRays {
    /// The rays, unit directions.
    pub rays: Vec<Ray>,
    /// What they hit first.
    pub(super) hits: Vec<Option<Hit>>,
    /// Of integrator `shaded`: whether something stands before light l at hit i, at l·rays + i.
    pub(super) shadowed: Vec<bool>,
}

/// Buffers that one thread reuses from ray to ray, and its counts.
#[derive(Debug, Default)]
pub struct ShadeScratch {
    /// Of the engines.
    pub trace: Scratch,
    /// Rays so far.
    pub rays: RayCounts,
    /// Of integrators `ao` and `shaded`.
    pub(super) bundle: Bundle,
    pub(super) attributes: SurfaceAttributes,
    /// Of faces that coincide.
    pub(super) coinciding: Vec<Hit>,
}

impl ShadeScratch {
    /// All attributes of the frame at the last hit, in the order of [`super::frame_attributes`];
    /// empty after a miss or if the shader was made without them.
    pub fn attributes(&self) -> &[f32] {
        &self.attributes.all
    }
}

/// Rays that start together, what became of them, and whose they are.
#[derive(Debug, Default)]
pub(super) struct Bundle {
    pub(super) rays: Vec<Ray>,
    pub(super) hits: Vec<bool>,
    pub(super) owners: Vec<usize>,
}
