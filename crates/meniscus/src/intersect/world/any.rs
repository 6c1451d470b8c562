//! Whether rays in world space meet anything.

use super::caps::{cut, leaving_cap};
use super::{
    ORIGIN_ERROR, ObjectRays, is_untransformed, origin_error, plane_error, states_side_of,
    transformed,
};
use crate::frame::{Frame, Geometry};
use crate::intersect::{BlobTracer, OnCpu, Scratch};
use crate::math::ray::Ray;

impl Frame {
    /// Whether a world-space ray meets any surface.
    pub fn any_hit(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        let mut hit = [false];
        self.any_hits(std::slice::from_ref(ray), &mut hit, scratch);
        hit[0]
    }

    /// Whether world-space rays meet any surface, one per entry of `hits`, as
    /// [`Frame::closest_hits`].
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn any_hits(&self, rays: &[Ray], hits: &mut [bool], scratch: &mut Scratch) {
        let Ok(()) = self.any_hits_by(&OnCpu, rays, hits, scratch);
    }

    /// [`Frame::any_hits`], blob surfaces being traced by `tracer`.
    ///
    /// # Errors
    /// Those of `tracer`.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn any_hits_by<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        rays: &[Ray],
        hits: &mut [bool],
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        let mut buffers = std::mem::take(&mut scratch.object_rays);
        let together = tracer.together();
        for (rays, hits) in rays.chunks(together).zip(hits.chunks_mut(together)) {
            hits.fill(false);
            self.find_spans(rays, &mut buffers);
            for surface in 0..self.instances.len() {
                self.any_on(tracer, surface, rays, hits, &mut buffers, scratch)?;
            }
        }
        scratch.object_rays = buffers;
        Ok(())
    }

    fn any_on<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        surface: usize,
        rays: &[Ray],
        hits: &mut [bool],
        buffers: &mut ObjectRays,
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        let instance = &self.instances[surface];
        let geometry = &self.geometries[instance.geometry as usize];
        let is_cut = geometry.is_cut() && !self.clips.is_empty();
        let is_as_given =
            is_untransformed(instance) && states_side_of(rays, surface as u32) && !is_cut;
        let moved = if is_as_given {
            rays
        } else {
            buffers.rays.clear();
            for (index, (ray, hit)) in rays.iter().zip(&mut *hits).enumerate() {
                let mut moved = transformed(ray, &instance.at(ray.time).object_from_world)
                    .with_side(ray.side_towards(surface as u32));
                if is_cut && !*hit {
                    let cap;
                    (moved, cap) = cut(geometry, moved, &buffers.spans[index], scratch);
                    *hit = cap.is_some();
                }
                buffers.rays.push(moved);
            }
            &buffers.rays
        };
        match geometry {
            Geometry::Blobs(blobs) => {
                let found = &mut buffers.occluded;
                found.clear();
                found.resize(rays.len(), false);
                tracer.occluded_many(instance.geometry, blobs, moved, found, scratch)?;
                for (hit, found) in hits.iter_mut().zip(found) {
                    *hit |= *found;
                }
            }
            Geometry::Mesh(mesh) => {
                for (hit, ray) in hits.iter_mut().zip(moved) {
                    let instance = &*instance.at(ray.time);
                    let error = origin_error(instance, ray) + ORIGIN_ERROR * mesh.size;
                    *hit = *hit || mesh.occluded(ray, error, &mut scratch.nodes);
                }
            }
            Geometry::Sphere(sphere) => {
                for (hit, ray) in hits.iter_mut().zip(moved) {
                    let error = origin_error(&instance.at(ray.time), ray);
                    *hit = *hit || sphere.closest(ray, error).is_some();
                }
            }
            Geometry::Plane(plane) => {
                for (hit, ray) in hits.iter_mut().zip(moved) {
                    let error = plane_error(&instance.at(ray.time), ray, plane);
                    *hit |= plane.closest(ray, error).is_some();
                }
            }
        }
        if is_cut {
            for (index, hit) in hits.iter_mut().enumerate() {
                let span = &buffers.spans[index];
                *hit = *hit || leaving_cap(geometry, &buffers.rays[index], span, scratch).is_some();
            }
        }
        Ok(())
    }
}
