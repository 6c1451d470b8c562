//! What surfaces and lights of a shader do, one question at a time: for those who compare devices with it.

use super::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Foam, Plastic};
use super::integrator::Shader;
use super::world::Prepared;
use crate::frame::BaseColor;
use glam::{DVec3, Vec3};

/// A drawn direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// Unit vector to where light comes from.
    pub towards: DVec3,
    /// What its radiance is multiplied by, or its radiance, over `density`.
    pub weight: Vec3,
    /// Per solid angle; infinite where it is the only direction.
    pub density: f64,
    /// How far the light is.
    pub distance: f64,
}

impl Shader<'_> {
    /// How a surface of constant look scatters between media of these indices (on the viewer's side,
    /// beyond); `None` for thin sheets, and by shaders that scatter no rays. Directions are in a frame
    /// whose z is the normal on the viewer's side.
    fn scattering(&self, surface: u32, indices: [f64; 2]) -> Option<Bsdf<'_>> {
        let (material, index) = self.world.material(surface);
        let color = match material.base {
            BaseColor::Constant(color) => Vec3::from_array(color),
            BaseColor::Attribute(_) | BaseColor::Direct(_) => return None,
        };
        let roughness = f64::from(material.roughness);
        Some(match self.world.prepared.get(index)? {
            Prepared::Diffuse => Bsdf::Diffuse(Diffuse { color }),
            Prepared::Conductor => Bsdf::Conductor(Conductor::new(color, roughness)),
            Prepared::Coated(coat) => Bsdf::Plastic(Plastic::new(coat, color, roughness)),
            Prepared::Clear(boundary) => {
                Bsdf::Dielectric(Dielectric::new(indices, roughness, boundary.as_deref()))
            }
            Prepared::Sheet => return None,
            Prepared::Foam => Bsdf::Foam(Foam {
                color,
                translucency: f64::from(material.translucency),
            }),
        })
    }

    /// BSDF times |cos| of the light's angle, and the density with which `light` is drawn.
    pub fn scattered(
        &self,
        surface: u32,
        indices: [f64; 2],
        [view, light]: [DVec3; 2],
    ) -> Option<(Vec3, f64)> {
        let bsdf = self.scattering(surface, indices)?;
        Some((bsdf.evaluate(view, light), bsdf.density(view, light)))
    }

    /// A direction drawn with three numbers in [0, 1); `None` where the light is lost.
    pub fn draw_scattered(
        &self,
        surface: u32,
        indices: [f64; 2],
        view: DVec3,
        choice: f64,
        u: [f64; 2],
    ) -> Option<Drawn> {
        let sample = (self.scattering(surface, indices)?).sample(view, choice, u)?;
        Some(Drawn {
            towards: sample.light,
            weight: sample.weight,
            density: sample.density,
            distance: f64::INFINITY,
        })
    }

    /// A light drawn at a point, for all lights.
    pub fn draw_light(&self, point: DVec3, choice: f64, u: [f64; 2]) -> Option<Drawn> {
        let (_, sample) = self.world.lights.sample(point, choice, u)?;
        Some(Drawn {
            towards: sample.towards,
            weight: sample.weight,
            density: sample.density,
            distance: sample.distance,
        })
    }

    /// Radiance from all that surrounds the scene, suns included.
    pub fn escaped(&self, direction: DVec3) -> Vec3 {
        let lights = self.world.lights.escaped(direction);
        lights.map(|found| found.radiance).sum()
    }
}
