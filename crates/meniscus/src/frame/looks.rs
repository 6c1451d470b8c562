//! What shading needs of a scene, resolved: lights, materials, colouring.

use crate::scene::attribute::Component;
use crate::scene::colormap::ColorTable;
use glam::DVec3;

/// A light at one shutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Light {
    /// Parallel light with a hard edge.
    Sun {
        /// Unit vector from the scene towards the light, world space.
        towards: DVec3,
        /// Linear radiance of a white diffuse surface that faces the light: its irradiance over π.
        radiance: [f32; 3],
    },
    /// Soft light from the upper half space (along [`super::Frame::up`]) and its reflection from
    /// below.
    Sky {
        /// Mean linear radiance of the upper half.
        radiance: [f32; 3],
    },
}

/// Colour by attribute.
#[derive(Debug, Clone, PartialEq)]
pub struct Coloring {
    /// Index into the field's `attributes`.
    pub attribute: usize,
    /// Which number of it.
    pub component: Component,
    /// Values at the two ends of the table; the first is never larger than the second.
    pub range: [f32; 2],
    /// The colour map.
    pub table: ColorTable,
    /// What the legend says: the attribute as the user wrote it.
    pub label: String,
}

impl Coloring {
    /// The linear colour of a blended attribute value (all its components).
    pub fn color(&self, value: &[f32]) -> [f32; 3] {
        let [low, high] = self.range;
        let number = self.component.of(value);
        let t = if high > low {
            (number - low) / (high - low)
        } else {
            0.5
        };
        self.table.at(t)
    }
}

/// What a surface's base colour is.
#[derive(Debug, Clone, PartialEq)]
pub enum BaseColor {
    /// The same everywhere, linear Rec. 709.
    Constant([f32; 3]),
    /// From an attribute through a colour map.
    Attribute(Box<Coloring>),
    /// An attribute that is a linear colour itself: its index in the field's `attributes`.
    Direct(usize),
}

/// A material as instances use it.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Diffuse albedo.
    pub base: BaseColor,
    /// Strength of the highlight in [0, 1]: 1 is a dielectric of index 1.5; 0 switches it off.
    pub specular: f32,
    /// Width of the highlight in [0, 1].
    pub roughness: f32,
}

/// The ground plane under the objects. It is infinite for rays; its look fades with distance so that
/// no horizon line appears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundLook {
    /// Its instance.
    pub surface: u32,
    /// The point under the middle of the objects.
    pub center: DVec3,
    /// Distance from `center` up to which the ground shows its own colour; from there it fades into
    /// the background, wholly at [`GroundLook::FADE_END`] times this.
    pub radius: f64,
}

impl GroundLook {
    /// Where the fade ends, in radii.
    pub const FADE_END: f64 = 4.0;

    /// How much of the ground's own colour is left at a world point on it: 1 near, 0 far.
    pub fn opacity(&self, point: DVec3) -> f32 {
        let far = (point - self.center).length() / self.radius;
        let t = ((Self::FADE_END - far) / (Self::FADE_END - 1.0)).clamp(0.0, 1.0);
        (t * t * (3.0 - 2.0 * t)) as f32
    }
}
