//! All crossings of rays in world space.

use super::caps::cut;
use super::{ORIGIN_ERROR, ObjectRays, origin_error, plane_error, transformed};
use crate::frame::{Frame, Geometry};
use crate::intersect::{BlobTracer, Crossing, OnCpu, Scratch};
use crate::math::ray::{Ray, Side};

impl Frame {
    /// Every crossing of a world-space ray with every surface, by t, in place of what `crossings` held.
    pub fn crossings(&self, ray: &Ray, scratch: &mut Scratch, crossings: &mut Vec<Crossing>) {
        let lists = std::slice::from_mut(crossings);
        let Ok(()) = self.crossings_by(&OnCpu, std::slice::from_ref(ray), lists, scratch);
    }

    /// [`Frame::crossings`] of many rays, a list each, blob surfaces being traced by `tracer`.
    ///
    /// # Errors
    /// Those of `tracer`.
    ///
    /// # Panics
    /// If `crossings` is not as long as `rays`.
    pub fn crossings_by<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        assert_eq!(rays.len(), crossings.len(), "one list per ray");
        let mut buffers = std::mem::take(&mut scratch.object_rays);
        let together = tracer.together();
        let parts = rays.chunks(together);
        for (rays, crossings) in parts.zip(crossings.chunks_mut(together)) {
            crossings.iter_mut().for_each(Vec::clear);
            self.find_spans(rays, &mut buffers);
            for surface in 0..self.instances.len() {
                self.crossings_on(tracer, surface, rays, crossings, &mut buffers, scratch)?;
            }
            for list in crossings {
                list.sort_by(|a, b| a.t.total_cmp(&b.t));
            }
        }
        scratch.object_rays = buffers;
        Ok(())
    }

    /// Appends the crossings with one surface.
    fn crossings_on<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        surface: usize,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        buffers: &mut ObjectRays,
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        let instance = &self.instances[surface];
        let geometry = &self.geometries[instance.geometry as usize];
        let is_cut = geometry.is_cut() && !self.clips.is_empty();
        buffers.rays.clear();
        buffers.capped.clear();
        buffers.before.clear();
        for (index, (ray, list)) in rays.iter().zip(&mut *crossings).enumerate() {
            let whole = transformed(ray, &instance.at(ray.time).object_from_world)
                .with_side(ray.side_towards(surface as u32));
            let mut moved = whole;
            let mut cap = None;
            if is_cut {
                let span = &buffers.spans[index];
                (moved, cap) = cut(geometry, whole, span, scratch);
                if let Some((t, _)) = cap {
                    let exit = span.as_ref().and_then(|span| span.exit);
                    let end = exit.map_or(ray.t_max, |(leave, _)| leave.min(ray.t_max));
                    moved = whole.with_range(t, end).with_side(Side::Inside);
                    list.push(Crossing { t, entering: true });
                }
            }
            buffers.capped.push(cap.is_some());
            buffers.rays.push(moved);
            buffers.before.push(list.len());
        }
        let moved = &buffers.rays;
        let traceable = |(_, ray): &(_, &Ray)| ray.is_traceable();
        match geometry {
            Geometry::Blobs(blobs) => {
                tracer.crossings_many(instance.geometry, blobs, moved, crossings, scratch)?;
            }
            Geometry::Mesh(mesh) => {
                for (list, moved) in crossings.iter_mut().zip(moved).filter(traceable) {
                    let instance = &*instance.at(moved.time);
                    let error = origin_error(instance, moved) + ORIGIN_ERROR * mesh.size;
                    mesh.crossings(moved, error, &mut scratch.nodes, list);
                }
            }
            Geometry::Sphere(sphere) => {
                for (list, moved) in crossings.iter_mut().zip(moved).filter(traceable) {
                    let error = origin_error(&instance.at(moved.time), moved);
                    let found = sphere.crossings(moved, error).into_iter().flatten();
                    list.extend(found.map(|(t, entering)| Crossing { t, entering }));
                }
            }
            Geometry::Plane(plane) => {
                for (list, moved) in crossings.iter_mut().zip(moved).filter(traceable) {
                    let error = plane_error(&instance.at(moved.time), moved, plane);
                    let found = plane.closest(moved, error);
                    list.extend(found.map(|(t, entering)| Crossing { t, entering }));
                }
            }
        }
        if !is_cut {
            return Ok(());
        }
        // A ray that is still inside where it leaves the kept part comes out through a cap.
        for (index, (ray, list)) in rays.iter().zip(&mut *crossings).enumerate() {
            let exit = buffers.spans[index].as_ref().and_then(|span| span.exit);
            let Some((leave, _)) = exit.filter(|&(leave, _)| leave <= ray.t_max) else {
                continue;
            };
            let moved = &buffers.rays[index];
            let ends_inside = match list[buffers.before[index]..].last() {
                Some(last) => last.entering,
                None => {
                    let is_asked = ray.is_traceable();
                    buffers.capped[index] || is_asked && geometry.is_inside(moved, leave, scratch)
                }
            };
            if ends_inside {
                list.push(Crossing {
                    t: leave,
                    entering: false,
                });
            }
        }
        Ok(())
    }
}
