//! Rays and the planes that cut surfaces open: what they leave of a ray, and the caps in them.

use super::on_plane;
use crate::frame::{Frame, Geometry};
use crate::intersect::clip::Span;
use crate::intersect::{Hit, Scratch};
use crate::math::ray::{Ray, Side};

impl Frame {
    /// The hit on the cap that clip `plane` leaves on a surface.
    pub(super) fn cap(
        &self,
        surface: usize,
        ray: &Ray,
        t: f64,
        plane: usize,
        entering: bool,
    ) -> Hit {
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
}

/// An object-space ray over the part that cuts leave of its range, and the cap that it meets where it
/// enters that part: its parameter and plane. After a cap the ray is empty.
pub(super) fn cut(
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
pub(super) fn leaving_cap(
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
