//! Integrator `shaded`: direct light with hard shadows, soft light from all around, a highlight and
//! the reflection of what is around; one shadow ray per light and hit.

use super::{Gathered, Shader};
use crate::intersect::{BlobTracer, Hit};
use crate::math::ray::{Ray, Side};
use crate::shade::light::LightSample;
use crate::shade::{EyeRays, ShadeScratch};
use glam::{DVec3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// How much of the light on its outer side a wall shows to an eye inside the fluid.
const WALL_TRANSMISSION: f32 = 0.6;

impl Shader<'_> {
    /// Looks for what stands between the hits and the lights, light by light. A shadow ray starts at
    /// the hit itself, on the stated outer side; no offset is needed.
    pub(super) fn find_shadows<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        eye: &mut EyeRays,
        scratch: &mut ShadeScratch,
    ) -> Result<(), T::Error> {
        let count = eye.rays.len();
        eye.shadowed.clear();
        eye.shadowed
            .resize(count * self.world.lights.count(), false);
        let mut bundle = std::mem::take(&mut scratch.bundle);
        for light in 0..self.world.lights.count() {
            bundle.rays.clear();
            bundle.owners.clear();
            for (owner, (ray, hit)) in eye.rays.iter().zip(&eye.hits).enumerate() {
                let Some(hit) = hit else {
                    continue;
                };
                let sample = self.world.lights.hard_of(light, hit.position);
                let Some(sample) = sample.filter(|sample| faces(hit, sample)) else {
                    continue;
                };
                bundle.rays.push(Ray {
                    time: ray.time,
                    t_max: sample.distance,
                    ..Ray::new(hit.position, sample.towards).with_side(Side::Outside)
                });
                bundle.owners.push(owner);
            }
            bundle.hits.clear();
            bundle.hits.resize(bundle.rays.len(), false);
            self.world.frame.any_hits_by(
                tracer,
                &bundle.rays,
                &mut bundle.hits,
                &mut scratch.trace,
            )?;
            for (&owner, &is_blocked) in bundle.owners.iter().zip(&bundle.hits) {
                eye.shadowed[light * count + owner] = is_blocked;
            }
        }
        scratch.bundle = bundle;
        Ok(())
    }

    /// What ray `index` sees; [`Shader::find_shadows`] has run.
    pub(super) fn shaded(
        &self,
        eye: &EyeRays,
        index: usize,
        scratch: &mut ShadeScratch,
    ) -> Gathered {
        let ray = &eye.rays[index];
        let Some(hit) = eye.hits[index] else {
            return Gathered::nothing(self.world.behind(ray.direction));
        };
        let (color, _) = self.world.look(&hit, scratch);
        let lit = self.lit(ray, &hit, color, (eye, index), scratch);
        Gathered::surface(lit, hit, color)
    }

    /// Light from a hit towards the eye.
    ///
    /// Seen from inside the fluid, a wall shows part of the diffuse light on its outer side: so an
    /// eye in the fluid sees shapes and shadows, and nothing shines there that is lit from nowhere.
    fn lit(
        &self,
        ray: &Ray,
        hit: &Hit,
        albedo: Vec3,
        (eye, index): (&EyeRays, usize),
        scratch: &mut ShadeScratch,
    ) -> Vec3 {
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
        let spread = gloss.and_then(|_| self.world.spread_at(ray, hit, normal));

        let mut diffuse = Vec3::ZERO;
        let mut specular = Vec3::ZERO;
        for (number, light) in self.world.lights.hard(hit.position) {
            if !faces(hit, &light) {
                continue;
            }
            scratch.rays.shadow += 1;
            if eye.shadowed[number * eye.rays.len() + index] {
                continue;
            }
            let nl = normal.dot(light.towards) as f32;
            let radiance = light.weight * FRAC_1_PI;
            diffuse += radiance * nl;
            if let Some(gloss) = gloss {
                let half = (light.towards + towards_eye).normalize_or_zero();
                let nh = (normal.dot(half) as f32).max(0.0);
                let vh = (towards_eye.dot(half) as f32).max(0.0);
                let highlight = match &spread {
                    None => gloss.highlight(nl, facing, nh, vh),
                    Some(spread) => {
                        let [x, y] = spread.tangents;
                        let local = |direction: DVec3, z: f32| {
                            Vec3::new(direction.dot(x) as f32, direction.dot(y) as f32, z)
                        };
                        let directions = [
                            local(light.towards, nl),
                            local(towards_eye, facing),
                            local(half, nh),
                        ];
                        let added = spread.added.map(|added| added as f32);
                        gloss.widened_highlight(added, directions, vh)
                    }
                };
                specular += radiance * highlight;
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
}

/// Whether a hit is turned towards a light.
fn faces(hit: &Hit, light: &LightSample) -> bool {
    hit.shading_normal.dot(light.towards) > 0.0 && hit.normal.dot(light.towards) > 0.0
}
