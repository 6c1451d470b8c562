//! Rays in world space against all surfaces of a frame.

mod any;
mod caps;
mod crossings;

use super::clip::Span;
use super::solids::SolidHit;
use super::{BlobHit, BlobTracer, Hit, OnCpu, Scratch};
use crate::frame::{Frame, Geometry, Instance, Plane};
use crate::math::ray::{Ray, Side};
use caps::{cut, leaving_cap};
use glam::{DAffine3, DVec3};

/// Rounding of a ray's origin, relative to the coordinates that it went through.
pub(super) const ORIGIN_ERROR: f64 = 256.0 * f64::EPSILON;

/// Buffers for rays in an object's space.
#[derive(Debug, Default)]
pub(super) struct ObjectRays {
    rays: Vec<Ray>,
    closest: Vec<Option<BlobHit>>,
    occluded: Vec<bool>,
    /// Where each ray lies below the planes that cut.
    spans: Vec<Option<Span>>,
    /// Rays that have met a cap where they enter what cuts leave.
    capped: Vec<bool>,
    /// Crossings of each ray before those with the surface that is being asked.
    before: Vec<usize>,
}

impl Geometry {
    /// Whether cuts apply: whether there may be an inside to be shown.
    fn is_cut(&self) -> bool {
        match self {
            Self::Blobs(_) | Self::Mesh(_) | Self::Sphere(_) => true,
            Self::Plane(_) => false,
        }
    }

    /// Which side an object-space point lies on at a time (seconds relative to the frame); open meshes
    /// have no inside.
    pub fn side(&self, point: DVec3, time_secs: f64, scratch: &mut Scratch) -> Side {
        match self {
            Self::Blobs(blobs) => blobs.field.at(time_secs).side(point - blobs.field.origin),
            Self::Mesh(mesh) => mesh.side(point, &mut scratch.nodes),
            Self::Sphere(sphere) => sphere.side(point),
            Self::Plane(plane) if plane.height(point) < 0.0 => Side::Inside,
            Self::Plane(_) => Side::Outside,
        }
    }

    fn is_inside(&self, ray: &Ray, t: f64, scratch: &mut Scratch) -> bool {
        self.side(ray.at(t), ray.time, scratch) == Side::Inside
    }
}

impl Frame {
    /// The first surface that a world-space ray meets.
    pub fn closest_hit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
        let mut hit = [None];
        self.closest_hits(std::slice::from_ref(ray), &mut hit, scratch);
        hit[0]
    }

    /// The first surfaces that world-space rays meet, one per entry of `hits`. Rays that lie close
    /// together and follow each other, such as those of a few neighbouring pixels, are traced
    /// together.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], scratch: &mut Scratch) {
        let Ok(()) = self.closest_hits_by(&OnCpu, rays, hits, scratch);
    }

    /// [`Frame::closest_hits`], blob surfaces being traced by `tracer`.
    ///
    /// # Errors
    /// Those of `tracer`.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_hits_by<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        let mut buffers = std::mem::take(&mut scratch.object_rays);
        let together = tracer.together();
        for (rays, hits) in rays.chunks(together).zip(hits.chunks_mut(together)) {
            hits.fill(None);
            self.find_spans(rays, &mut buffers);
            for surface in 0..self.instances.len() {
                self.closest_on(tracer, surface, rays, hits, &mut buffers, scratch)?;
            }
        }
        scratch.object_rays = buffers;
        Ok(())
    }

    fn find_spans(&self, rays: &[Ray], buffers: &mut ObjectRays) {
        buffers.spans.clear();
        if !self.clips.is_empty() {
            let spans = rays.iter().map(|ray| Span::new(&self.clips, ray));
            buffers.spans.extend(spans);
        }
    }

    /// Replaces hits by nearer ones on one surface.
    fn closest_on<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        surface: usize,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        buffers: &mut ObjectRays,
        scratch: &mut Scratch,
    ) -> Result<(), T::Error> {
        let instance = &self.instances[surface];
        let geometry = &self.geometries[instance.geometry as usize];
        let is_cut = geometry.is_cut() && !self.clips.is_empty();
        let is_as_given = is_untransformed(instance)
            && hits.iter().all(Option::is_none)
            && states_side_of(rays, surface as u32)
            && !is_cut;
        let moved = if is_as_given {
            rays
        } else {
            buffers.rays.clear();
            buffers.capped.clear();
            for (index, (ray, hit)) in rays.iter().zip(&mut *hits).enumerate() {
                let nearest = hit.map_or(ray.t_max, |hit| hit.t);
                let mut moved = transformed(ray, &instance.at(ray.time).object_from_world)
                    .with_range(ray.t_min, nearest)
                    .with_side(ray.side_towards(surface as u32));
                let mut cap = None;
                if is_cut {
                    (moved, cap) = cut(geometry, moved, &buffers.spans[index], scratch);
                }
                if let Some((t, plane)) = cap {
                    *hit = Some(self.cap(surface, ray, t, plane, true));
                }
                buffers.capped.push(cap.is_some());
                buffers.rays.push(moved);
            }
            &buffers.rays
        };
        match geometry {
            Geometry::Blobs(blobs) => {
                let found = &mut buffers.closest;
                found.clear();
                found.resize(rays.len(), None);
                tracer.closest_many(instance.geometry, blobs, moved, found, scratch)?;
                let stands = is_untransformed(instance);
                for ((ray, hit), found) in rays.iter().zip(&mut *hits).zip(found) {
                    if let Some(f) = found {
                        let outward = if stands {
                            f.outward
                        } else {
                            let matrix = instance.at(ray.time).object_from_world.matrix3;
                            matrix.transpose() * f.outward
                        };
                        let normal = outward.normalize_or_zero();
                        *hit = Some(Hit {
                            t: f.t,
                            position: ray.at(f.t),
                            normal,
                            shading_normal: normal,
                            surface: surface as u32,
                            blob: Some(f.strongest),
                            entering: f.entering,
                        });
                    }
                }
            }
            Geometry::Mesh(mesh) => {
                for (hit, moved) in hits.iter_mut().zip(moved) {
                    let instance = &*instance.at(moved.time);
                    let error = origin_error(instance, moved) + ORIGIN_ERROR * mesh.size;
                    if let Some(found) = mesh.closest(moved, error, &mut scratch.nodes) {
                        *hit = Some(placed(surface, instance, &found));
                    }
                }
            }
            Geometry::Sphere(sphere) => {
                for (hit, moved) in hits.iter_mut().zip(moved) {
                    let instance = &*instance.at(moved.time);
                    if let Some(found) = sphere.closest(moved, origin_error(instance, moved)) {
                        *hit = Some(placed(surface, instance, &found));
                    }
                }
            }
            Geometry::Plane(plane) => {
                for (hit, moved) in hits.iter_mut().zip(moved) {
                    let instance = &*instance.at(moved.time);
                    let error = plane_error(instance, moved, plane);
                    if let Some((t, entering)) = plane.closest(moved, error) {
                        let found = plane_hit(plane, moved.at(t), t, entering);
                        *hit = Some(placed(surface, instance, &found));
                    }
                }
            }
        }
        if !is_cut {
            return Ok(());
        }
        // A ray that is still inside where it leaves the kept part comes out through a cap.
        for (index, (ray, hit)) in rays.iter().zip(&mut *hits).enumerate() {
            let moved = &buffers.rays[index];
            let is_here = hit.is_some_and(|hit| hit.surface as usize == surface);
            if buffers.capped[index] || is_here {
                continue;
            }
            if let Some((t, plane)) = leaving_cap(geometry, moved, &buffers.spans[index], scratch) {
                *hit = Some(self.cap(surface, ray, t, plane, false));
            }
        }
        Ok(())
    }

    /// On which side of surface `surface` a world point lies at a time (seconds relative to the frame);
    /// what is cut away is outside.
    pub fn side(&self, surface: u32, point: DVec3, time_secs: f64, scratch: &mut Scratch) -> Side {
        let instance = self.instances[surface as usize].at(time_secs);
        let geometry = &self.geometries[instance.geometry as usize];
        if geometry.is_cut() && self.clips.iter().any(|plane| plane.height(point) > 0.0) {
            return Side::Outside;
        }
        let object = instance.object_from_world.transform_point3(point);
        geometry.side(object, time_secs, scratch)
    }

    /// Whether a ray's point at `t_min` lies inside a blob surface, a closed mesh or a sphere, and is
    /// not cut away.
    pub fn starts_inside(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        let start = ray.at(ray.t_min);
        (0_u32..).zip(&self.instances).any(|(surface, instance)| {
            self.geometries[instance.geometry as usize].is_cut()
                && self.side(surface, start, ray.time, scratch) == Side::Inside
        })
    }
}

/// A hit on a plane at `point` in its own space.
pub(super) fn plane_hit(plane: &Plane, point: DVec3, t: f64, entering: bool) -> SolidHit {
    SolidHit {
        t,
        position: on_plane(plane, point),
        outward: plane.normal,
        shading: plane.normal,
        entering,
    }
}

/// A hit on a mesh, sphere or plane in world space.
pub(super) fn placed(surface: usize, instance: &Instance, found: &SolidHit) -> Hit {
    let matrix = instance.object_from_world.matrix3.transpose();
    Hit {
        t: found.t,
        position: instance.world_from_object.transform_point3(found.position),
        normal: (matrix * found.outward).normalize_or_zero(),
        shading_normal: (matrix * found.shading).normalize_or_zero(),
        surface: surface as u32,
        blob: None,
        entering: found.entering,
    }
}

/// How far rounding may have moved the origin of an object-space ray.
pub(super) fn origin_error(instance: &Instance, moved: &Ray) -> f64 {
    let size = moved.at(moved.t_min).abs().max_element();
    let shift = instance.object_from_world.translation.abs().max_element();
    ORIGIN_ERROR * (size + shift)
}

/// [`origin_error`] for a plane, whose own coordinates may be larger.
pub(super) fn plane_error(instance: &Instance, moved: &Ray, plane: &Plane) -> f64 {
    origin_error(instance, moved) + ORIGIN_ERROR * plane.point.abs().max_element()
}

/// The point of a plane below or above `point`.
fn on_plane(plane: &Plane, point: DVec3) -> DVec3 {
    point - plane.normal * plane.height(point)
}

/// Whether what the rays state about sides holds for `surface` as it stands.
fn states_side_of(rays: &[Ray], surface: u32) -> bool {
    rays.iter().all(|ray| ray.side_towards(surface) == ray.side)
}

/// Whether rays in the world's space are rays in the object's.
fn is_untransformed(instance: &Instance) -> bool {
    instance.path.is_none() && instance.object_from_world == DAffine3::IDENTITY
}

pub(super) fn transformed(ray: &Ray, object_from_world: &DAffine3) -> Ray {
    Ray {
        origin: object_from_world.transform_point3(ray.origin),
        direction: object_from_world.transform_vector3(ray.direction),
        ..*ray
    }
}

#[cfg(test)]
mod tests;
