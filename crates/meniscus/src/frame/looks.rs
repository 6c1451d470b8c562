//! What shading needs of a scene, resolved: lights, materials, colouring.

use super::Environment;
use crate::scene::MaterialKind;
use crate::scene::attribute::Component;
use crate::scene::colormap::ColorTable;
use glam::DVec3;
use std::sync::Arc;

/// A light at one shutter, everything in world space, colours linear Rec. 709.
#[derive(Debug, Clone, PartialEq)]
pub enum Light {
    /// Light from a disk so far away that its rays are parallel but for the disk's size.
    Sun {
        /// Unit vector from the scene towards the middle of the disk.
        towards: DVec3,
        /// Radiance of a white diffuse surface that faces the light: its irradiance over π.
        radiance: [f32; 3],
        /// Half the apparent diameter in radians; 0: parallel rays.
        half_angle: f64,
    },
    /// Soft light from the upper half space (along [`super::Frame::up`]) and its reflection from
    /// below.
    Sky {
        /// Mean radiance of the upper half.
        radiance: [f32; 3],
    },
    /// The same light from every direction.
    Constant {
        /// Radiance.
        radiance: [f32; 3],
    },
    /// A point.
    Point {
        /// Where it is.
        position: DVec3,
        /// Radiance of a white diffuse surface that faces it at distance 1.
        radiance: [f32; 3],
    },
    /// A ball that shines.
    Sphere {
        /// Its centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
        /// Radiance of its surface.
        radiance: [f32; 3],
    },
    /// A rectangle (or parallelogram) that shines on one side.
    Rectangle {
        /// Its centre.
        center: DVec3,
        /// Its edges at full length; it shines towards first × second.
        edges: [DVec3; 2],
        /// Radiance of its surface.
        radiance: [f32; 3],
    },
    /// An image all around.
    Environment {
        /// The image.
        environment: Arc<Environment>,
        /// What it is multiplied by.
        scale: [f32; 3],
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

/// A number from an attribute, stretched linearly.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    /// Index into the field's `attributes`.
    pub attribute: usize,
    /// Which number of it.
    pub component: Component,
    /// Values that become 0 and 1, the first smaller.
    pub range: [f32; 2],
}

impl Scaling {
    /// The number for a blended attribute value (all its components); not clamped.
    pub fn number(&self, value: &[f32]) -> f32 {
        let [low, high] = self.range;
        (self.component.of(value) - low) / (high - low)
    }
}

/// How light fades in a clear medium (Beer and Lambert): what is left of white light behind a depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Absorption {
    /// The colour left, from an attribute or not; above 0.
    pub left: BaseColor,
    /// Behind this distance, in world units.
    pub depth: f64,
    /// Multiplies the absorption from place to place.
    pub density: Option<Scaling>,
}

impl Absorption {
    /// Darkest colour left that is told from black.
    const DARKEST: f32 = 1e-6;

    /// The absorption coefficients, per world unit, where this colour is left.
    pub fn coefficients(&self, left: [f32; 3]) -> [f32; 3] {
        left.map(|c| -c.clamp(Self::DARKEST, 1.0).ln() / self.depth as f32)
    }

    /// The coefficients where they are the same everywhere.
    pub fn constant(&self) -> Option<[f32; 3]> {
        match (&self.left, &self.density) {
            (BaseColor::Constant(left), None) => Some(self.coefficients(*left)),
            _ => None,
        }
    }
}

/// A material as instances use it.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its kind.
    pub kind: MaterialKind,
    /// Base colour: see [`crate::scene::Material::color`].
    pub base: BaseColor,
    /// Strength of the highlight in [0, 1]: 1 is a dielectric of index 1.5; 0 switches it off.
    pub specular: f32,
    /// Width of the highlight in [0, 1].
    pub roughness: f32,
    /// Takes the place of `roughness`.
    pub roughness_by: Option<Scaling>,
    /// Index of refraction.
    pub ior: f64,
    /// Of clear materials.
    pub absorption: Absorption,
    /// Clear: whether it is a thin sheet instead of the boundary of a body; the optical depth of its
    /// thickness is that of `absorption` behind a distance of 1.
    pub thin: bool,
    /// Which clear material fills a place that lies in several: the largest.
    pub priority: i32,
    /// Foam: part of the scattered light that goes through.
    pub translucency: f32,
}

impl Material {
    /// Whether its inside is a clear medium.
    pub fn is_medium(&self) -> bool {
        self.kind.is_clear() && !self.thin
    }
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
