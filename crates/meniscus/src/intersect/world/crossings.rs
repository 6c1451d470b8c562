//! All crossings of a ray in world space.

use super::caps::cut;
use super::{ORIGIN_ERROR, origin_error, plane_error, transformed};
use crate::frame::{Frame, Geometry};
use crate::intersect::clip::Span;
use crate::intersect::{Crossing, Scratch};
use crate::math::ray::{Ray, Side};

impl Frame {
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
}
