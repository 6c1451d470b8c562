//! Faces that coincide: what else a ray crosses where it meets a surface. Rounding decides which of such
//! crossings a ray finds first, and a ray that goes on from there may miss the others.

use super::world::{ORIGIN_ERROR, origin_error, placed, plane_error, plane_hit, transformed};
use super::{Hit, Scratch};
use crate::frame::{Frame, Geometry};
use crate::math::ray::{Ray, Side};

/// Rounding margins between two crossings of one place.
const MARGINS: f64 = 4.0;
/// Least cosine for which faces are looked for: along them nothing can be told.
const LEAST_COSINE: f64 = 1e-6;

impl Frame {
    /// Appends the crossings of a world-space ray with other meshes, spheres and planes that rounding
    /// cannot tell from `hit`, which lies on the ray. Particle surfaces coincide with nothing. Returns
    /// how far apart, in the ray's parameter, rounding can bring such crossings.
    pub fn coinciding(
        &self,
        ray: &Ray,
        hit: &Hit,
        scratch: &mut Scratch,
        found: &mut Vec<Hit>,
    ) -> f64 {
        let mut largest_margin = 0.0_f64;
        let is_cut_away = self
            .clips
            .iter()
            .any(|plane| plane.height(hit.position) > 0.0);
        for (surface, instance) in self.instances.iter().enumerate() {
            let instance = &*instance.at(ray.time);
            let geometry = &self.geometries[instance.geometry as usize];
            if matches!(geometry, Geometry::Blobs(_)) {
                continue;
            }
            if is_cut_away && !matches!(geometry, Geometry::Plane(_)) {
                continue;
            }
            let whole = transformed(ray, &instance.object_from_world);
            let own_error = match geometry {
                Geometry::Plane(plane) => plane_error(instance, &whole, plane),
                Geometry::Mesh(mesh) => origin_error(instance, &whole) + ORIGIN_ERROR * mesh.size,
                Geometry::Sphere(_) | Geometry::Blobs(_) => origin_error(instance, &whole),
            };
            let speed = whole.direction.length();
            let error = own_error + ORIGIN_ERROR * whole.at(hit.t).abs().max_element();
            let cosine = hit.normal.dot(ray.direction).abs() / ray.direction.length();
            let margin = MARGINS * error / (speed * cosine.max(LEAST_COSINE));
            largest_margin = largest_margin.max(margin);
            if surface as u32 == hit.surface {
                continue;
            }
            let near = Ray {
                side: Side::Unknown,
                ..whole.with_range((hit.t - margin).max(ray.t_min), hit.t + margin)
            };
            let crossing = match geometry {
                Geometry::Blobs(_) => None,
                Geometry::Mesh(mesh) => mesh.closest(&near, 0.0, &mut scratch.nodes),
                Geometry::Sphere(sphere) => sphere.closest(&near, 0.0),
                Geometry::Plane(plane) => plane
                    .closest(&near, 0.0)
                    .map(|(t, entering)| plane_hit(plane, near.at(t), t, entering)),
            };
            found.extend(crossing.map(|crossing| placed(surface, instance, &crossing)));
        }
        largest_margin
    }
}
