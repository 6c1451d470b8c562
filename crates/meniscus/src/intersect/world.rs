//! Rays in world space against all surfaces of a frame.

use super::clip::Span;
use super::solids::SolidHit;
use super::{BlobHit, BlobTracer, Crossing, Hit, OnCpu, Scratch};
use crate::frame::{Frame, Geometry, Instance, Plane};
use crate::math::ray::{Ray, Side};
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
    /// Rays that have been answered by a cap.
    capped: Vec<bool>,
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
                for ((ray, hit), found) in rays.iter().zip(&mut *hits).zip(found) {
                    if let Some(f) = found {
                        let matrix = instance.at(ray.time).object_from_world.matrix3;
                        let normal = (matrix.transpose() * f.outward).normalize_or_zero();
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

    /// The hit on the cap that clip `plane` leaves on a surface.
    fn cap(&self, surface: usize, ray: &Ray, t: f64, plane: usize, entering: bool) -> Hit {
        let instance = self.instances[surface].at(ray.time);
        let plane = &self.clips[plane];
        let position = on_plane(plane, ray.at(t));
        let object = instance.object_from_world.transform_point3(position);
        let blobs = self.geometries[instance.geometry as usize].blobs();
        Hit {
            t,
            position,
            normal: plane.normal,
            shading_normal: plane.normal,
            surface: surface as u32,
            blob: blobs.and_then(|blobs| {
                let local = object - blobs.field.origin;
                blobs.field.at(ray.time).strongest(local)
            }),
            entering,
        }
    }

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

    /// Every crossing of a world-space ray with every surface, by t, appended to `crossings`.
    pub fn crossings(&self, ray: &Ray, scratch: &mut Scratch, crossings: &mut Vec<Crossing>) {
        if !ray.is_traceable() {
            return;
        }
        let first = crossings.len();
        let span = match self.clips.is_empty() {
            true => None,
            false => Some(Span::new(&self.clips, ray)),
        };
        for instance in &self.instances {
            let instance = &*instance.at(ray.time);
            let geometry = &self.geometries[instance.geometry as usize];
            let mut moved = transformed(ray, &instance.object_from_world);
            let cutting = span.as_ref().filter(|_| geometry.is_cut());
            let mut start = None;
            if let Some(span) = cutting {
                let cap;
                (moved, cap) = cut(geometry, moved, span, scratch);
                if let Some((t, _)) = cap {
                    start = Some(t);
                    let end = span.as_ref().and_then(|span| span.exit);
                    let end = end.map_or(ray.t_max, |(leave, _)| leave.min(ray.t_max));
                    moved = transformed(ray, &instance.object_from_world)
                        .with_range(t, end)
                        .with_side(Side::Inside);
                    crossings.push(Crossing { t, entering: true });
                }
            }
            let here = crossings.len();
            match geometry {
                Geometry::Blobs(blobs) => blobs.crossings(&moved, scratch, crossings),
                Geometry::Mesh(mesh) => {
                    let error = origin_error(instance, &moved) + ORIGIN_ERROR * mesh.size;
                    mesh.crossings(&moved, error, &mut scratch.nodes, crossings);
                }
                Geometry::Sphere(sphere) => {
                    let found = sphere.crossings(&moved, origin_error(instance, &moved));
                    let found = found.into_iter().flatten();
                    crossings.extend(found.map(|(t, entering)| Crossing { t, entering }));
                }
                Geometry::Plane(plane) => {
                    let found = plane.closest(&moved, plane_error(instance, &moved, plane));
                    crossings.extend(found.map(|(t, entering)| Crossing { t, entering }));
                }
            }
            let Some(Some((leave, _))) = cutting.map(|span| span.and_then(|span| span.exit)) else {
                continue;
            };
            let ends_inside = match crossings[here..].last() {
                Some(last) => last.entering,
                None => start.is_some() || geometry.is_inside(&moved, leave, scratch),
            };
            if ends_inside && leave <= ray.t_max {
                crossings.push(Crossing {
                    t: leave,
                    entering: false,
                });
            }
        }
        crossings[first..].sort_by(|a, b| a.t.total_cmp(&b.t));
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

/// An object-space ray over the part that cuts leave of its range, and the cap that it meets where it
/// enters that part: its parameter and plane. After a cap the ray is empty.
fn cut(
    geometry: &Geometry,
    moved: Ray,
    span: &Option<Span>,
    scratch: &mut Scratch,
) -> (Ray, Option<(f64, usize)>) {
    let nothing = moved.with_range(0.0, -1.0);
    let Some(span) = span else {
        return (nothing, None);
    };
    let end = span
        .exit
        .map_or(moved.t_max, |(leave, _)| leave.min(moved.t_max));
    let Some((enter, plane)) = span.entry else {
        return (moved.with_range(moved.t_min, end), None);
    };
    if enter > end || !moved.is_traceable() {
        return (nothing, None);
    }
    if geometry.is_inside(&moved, enter, scratch) {
        return (nothing, Some((enter, plane)));
    }
    (moved.with_range(enter, end).with_side(Side::Outside), None)
}

/// The cap through which an object-space ray that crossed nothing leaves: its parameter and plane.
fn leaving_cap(
    geometry: &Geometry,
    moved: &Ray,
    span: &Option<Span>,
    scratch: &mut Scratch,
) -> Option<(f64, usize)> {
    let (leave, plane) = span.as_ref()?.exit?;
    let is_reached = moved.is_traceable() && leave <= moved.t_max;
    let may_be_inside = is_reached && moved.side != Side::Outside;
    (may_be_inside && geometry.is_inside(moved, leave, scratch)).then_some((leave, plane))
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
