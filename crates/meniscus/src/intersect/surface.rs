//! What a surface does around a hit: how it is curved, and how it moves.

use super::Hit;
use crate::frame::{Frame, Geometry};
use crate::math::level_set::{AT_REST, LevelSet};
use glam::{DMat3, DVec3};

impl Frame {
    /// The surface around a hit of a ray of this time (seconds relative to the frame) as a level set in
    /// world space, positive inside: normal, curvatures, and how they and the hit change over space and
    /// time. Meshes, planes and caps of cuts are flat.
    pub fn level_set(&self, hit: &Hit, time_secs: f64) -> LevelSet {
        if self.is_on_cap(hit) {
            return LevelSet::flat(hit.normal);
        }
        let instance = &self.instances[hit.surface as usize];
        let object_from_world = &instance.object_from_world;
        let object = object_from_world.transform_point3(hit.position);
        let level_set = match &self.geometries[instance.geometry as usize] {
            Geometry::Blobs(blobs) => {
                let field = blobs.field.at(time_secs);
                field.level_set(object - blobs.field.origin)
            }
            // F = −|x − c|².
            Geometry::Sphere(sphere) => LevelSet {
                gradient: (sphere.center - object) * 2.0,
                hessian: DMat3::IDENTITY * -2.0,
                rate: 0.0,
                gradient_rate: DVec3::ZERO,
            },
            Geometry::Mesh(_) | Geometry::Plane(_) => {
                let world_from_object = instance.world_from_object.matrix3;
                LevelSet::flat(world_from_object.transpose() * hit.normal)
            }
        };
        level_set.seen_through(object_from_world, &AT_REST, hit.position)
    }

    /// Velocity of what the surface is made of at a hit, in world units per second: that of its
    /// particles, blended by field weight.
    pub fn velocity(&self, hit: &Hit, time_secs: f64) -> DVec3 {
        let instance = &self.instances[hit.surface as usize];
        match &self.geometries[instance.geometry as usize] {
            Geometry::Blobs(blobs) => {
                let object = instance.object_from_world.transform_point3(hit.position);
                let velocity = blobs
                    .field
                    .at(time_secs)
                    .velocity(object - blobs.field.origin);
                instance.world_from_object.transform_vector3(velocity)
            }
            Geometry::Sphere(_) | Geometry::Mesh(_) | Geometry::Plane(_) => DVec3::ZERO,
        }
    }

    fn is_on_cap(&self, hit: &Hit) -> bool {
        self.clips.iter().any(|plane| plane.normal == hit.normal)
    }
}

#[cfg(test)]
mod tests;
