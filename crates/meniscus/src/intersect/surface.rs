//! What a surface does around a hit: how it is curved, and how it moves.

use super::Hit;
use crate::frame::{Frame, Geometry};
use crate::math::level_set::LevelSet;
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
        let placement = instance.placement(time_secs);
        let object_from_world = &placement.object_from_world;
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
                let world_from_object = placement.world_from_object.matrix3;
                LevelSet::flat(world_from_object.transpose() * hit.normal)
            }
        };
        let rate = &placement.object_from_world_rate;
        level_set.seen_through(object_from_world, rate, hit.position)
    }

    /// Velocity of what the surface is made of at a hit, in world units per second: that of its
    /// particles, blended by field weight, and of its instance.
    pub fn velocity(&self, hit: &Hit, time_secs: f64) -> DVec3 {
        let instance = &self.instances[hit.surface as usize];
        let placement = instance.placement(time_secs);
        let object = placement.object_from_world.transform_point3(hit.position);
        let own = self.object_velocity(instance.geometry, object, time_secs);
        placement.world_from_object.transform_vector3(own)
            + placement.world_from_object_rate.transform_point3(object)
    }

    /// Velocity of a geometry's particles at an object-space point.
    fn object_velocity(&self, geometry: u32, object: DVec3, time_secs: f64) -> DVec3 {
        match &self.geometries[geometry as usize] {
            Geometry::Blobs(blobs) => {
                let field = blobs.field.at(time_secs);
                field.velocity(object - blobs.field.origin)
            }
            Geometry::Sphere(_) | Geometry::Mesh(_) | Geometry::Plane(_) => DVec3::ZERO,
        }
    }

    /// Where what was hit at time `hit_secs` is at another time: with its instance all the way, and with
    /// its particles to first order.
    pub fn carried(&self, hit: &Hit, hit_secs: f64, secs: f64) -> DVec3 {
        let instance = &self.instances[hit.surface as usize];
        if instance.path.is_none() {
            return hit.position + self.velocity(hit, hit_secs) * (secs - hit_secs);
        }
        let object_from_world = instance.at(hit_secs).object_from_world;
        let object = object_from_world.transform_point3(hit.position);
        let own = self.object_velocity(instance.geometry, object, hit_secs);
        let there = instance.at(secs).world_from_object;
        there.transform_point3(object + own * (secs - hit_secs))
    }

    fn is_on_cap(&self, hit: &Hit) -> bool {
        self.clips.iter().any(|plane| plane.normal == hit.normal)
    }
}

#[cfg(test)]
mod tests;
