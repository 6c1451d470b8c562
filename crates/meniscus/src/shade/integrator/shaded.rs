//! Integrator `shaded`: direct light with hard shadows, soft light from all around, a highlight and
//! the reflection of what is around; one shadow ray per light and hit.

use super::{Gathered, Shader};
use crate::intersect::Hit;
use crate::math::ray::{Ray, Side};
use crate::shade::ShadeScratch;
use crate::shade::light::LightSample;
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// How much of the light on its outer side a wall shows to an eye inside the fluid.
const WALL_TRANSMISSION: f32 = 0.6;

impl Shader<'_> {
    pub(super) fn shaded(&self, ray: &Ray, scratch: &mut ShadeScratch) -> Gathered {
        let Some(hit) = self.world.frame.closest_hit(ray, &mut scratch.trace) else {
            return Gathered::nothing(self.world.behind(ray.direction));
        };
        let (color, _) = self.world.look(&hit, scratch);
        let lit = self.lit(ray, &hit, color, scratch);
        Gathered::surface(lit, hit, color)
    }

    /// Light from a hit towards the eye.
    ///
    /// Seen from inside the fluid, a wall shows part of the diffuse light on its outer side: so an
    /// eye in the fluid sees shapes and shadows, and nothing shines there that is lit from nowhere.
    fn lit(&self, ray: &Ray, hit: &Hit, albedo: Vec3, scratch: &mut ShadeScratch) -> Vec3 {
        let towards_eye = -ray.direction;
        let from_inside = hit.normal.dot(towards_eye) < 0.0;
        // A shading normal may turn away from the eye where the face does not.
        let normal = hit.shading_normal;
        let facing = normal.dot(towards_eye) as f32;
        let facing = if from_inside {
            facing
        } else {
            facing.max(1e-3)
        };
        let (_, material) = self.world.material(hit.surface);
        let gloss = self.gloss[material].filter(|_| !from_inside);
        let coat = gloss.map_or(0.0, |gloss| gloss.reflectance(facing));

        let mut diffuse = Vec3::ZERO;
        let mut specular = Vec3::ZERO;
        for light in self.world.lights.hard(hit.position) {
            let nl = normal.dot(light.towards) as f32;
            let is_behind_face = hit.normal.dot(light.towards) <= 0.0;
            if nl <= 0.0 || is_behind_face || self.is_shadowed(ray, hit, &light, scratch) {
                continue;
            }
            let radiance = light.weight * FRAC_1_PI;
            diffuse += radiance * nl;
            if let Some(gloss) = gloss {
                let half = (light.towards + towards_eye).normalize_or_zero();
                let nh = (normal.dot(half) as f32).max(0.0);
                let vh = (towards_eye.dot(half) as f32).max(0.0);
                specular += radiance * gloss.highlight(nl, facing, nh, vh);
            }
        }
        diffuse += self.ambient.diffuse(normal);
        let mirrored = ray.direction - normal * (2.0 * normal.dot(ray.direction));
        specular += self.world.lights.surroundings(mirrored) * coat;
        if from_inside {
            return albedo * diffuse * WALL_TRANSMISSION;
        }
        albedo * diffuse * (1.0 - coat) + specular
    }

    /// Whether something stands between a hit and a light. The shadow ray starts at the hit itself, on
    /// the stated outer side; no offset is needed.
    fn is_shadowed(
        &self,
        ray: &Ray,
        hit: &Hit,
        light: &LightSample,
        scratch: &mut ShadeScratch,
    ) -> bool {
        scratch.rays.shadow += 1;
        let shadow_ray = Ray {
            time: ray.time,
            t_max: light.distance,
            ..Ray::new(hit.position, light.towards).with_side(Side::Outside)
        };
        self.world.frame.any_hit(&shadow_ray, &mut scratch.trace)
    }
}
