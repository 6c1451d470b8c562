//! A ray as engines in f32 trace it: clipped in f64, so that f32 never sees a far origin.

use crate::accel::cells::traverse::SlabRay;
use crate::frame::Blobs;
use crate::math::aabb::Aabb;
use crate::math::ray::{Ray, Side};
use glam::DVec3;

/// A ray in local coordinates with a unit direction, moved to where it can first meet the structure.
#[derive(Debug, Clone, Copy)]
pub(in crate::intersect) struct LocalRay {
    /// Start of the stretch that is traced, local f64.
    pub(in crate::intersect) origin: DVec3,
    /// Unit direction.
    pub(in crate::intersect) direction: DVec3,
    /// Unit-length parameter of `origin` on the caller's ray.
    pub(in crate::intersect) t_start: f64,
    /// Length of the stretch.
    pub(in crate::intersect) length: f32,
    /// Whether `origin` lies at the caller's t_min (otherwise the ray came from outside the structure).
    pub(in crate::intersect) starts_at_t_min: bool,
    /// 1/|direction| of the caller's ray.
    pub(in crate::intersect) per_unit: f64,
    pub(in crate::intersect) inside: bool,
    /// Seconds relative to the frame.
    pub(in crate::intersect) time_secs: f64,
    /// Whether the field, not the caller, says that the ray starts on this side.
    pub(in crate::intersect) side_is_proven: bool,
}

impl LocalRay {
    /// The stretch as the slab test wants it.
    pub(in crate::intersect) fn slab_ray(&self) -> SlabRay {
        SlabRay::new(
            self.origin.as_vec3().to_array(),
            self.direction.as_vec3().to_array(),
            self.length,
        )
    }

    /// The caller's parameter of a point `along` the stretch.
    pub(in crate::intersect) fn parameter(&self, ray: &Ray, along: f64) -> f64 {
        ((self.t_start + along) * self.per_unit).clamp(ray.t_min, ray.t_max)
    }
}

/// A ray in a field's local coordinates with a unit direction, clipped in f64 to the box that holds all
/// surface, so that f32 never sees a far origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClippedRay {
    /// Where the clipped ray starts, local.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Unit-length parameter of `origin` on the caller's ray.
    pub t_start: f64,
    /// Length of the clipped ray.
    pub length: f32,
    /// Whether `origin` lies at the caller's t_min (otherwise the ray came from outside the box).
    pub starts_at_t_min: bool,
    /// 1/|direction| of the caller's ray.
    pub per_unit: f64,
}

impl ClippedRay {
    /// Clips a traceable ray in the object's space to the local box `bounds` of a field whose origin is
    /// `field_origin`; `None` where it misses the box.
    pub fn new(field_origin: DVec3, bounds: Aabb, ray: &Ray) -> Option<Self> {
        let length = ray.direction.length();
        let per_unit = length.recip();
        let direction = ray.direction * per_unit;
        let origin = ray.origin - field_origin;
        let (t_min, t_max) = (ray.t_min * length, ray.t_max * length);
        let (mut enter, mut leave) = (t_min, t_max);
        let inverse = direction.recip();
        for axis in 0..3 {
            let (lower, upper) = (f64::from(bounds.min[axis]), f64::from(bounds.max[axis]));
            if direction[axis] == 0.0 {
                if origin[axis] < lower || origin[axis] > upper {
                    return None;
                }
                continue;
            }
            let to_lower = (lower - origin[axis]) * inverse[axis];
            let to_upper = (upper - origin[axis]) * inverse[axis];
            enter = enter.max(to_lower.min(to_upper));
            leave = leave.min(to_lower.max(to_upper));
        }
        (enter <= leave && enter.is_finite() && per_unit.is_finite()).then(|| Self {
            origin: origin + direction * enter,
            direction,
            t_start: enter,
            length: (leave - enter) as f32,
            starts_at_t_min: enter <= t_min,
            per_unit,
        })
    }

    /// The caller's parameter of a point `along` the clipped ray.
    pub fn parameter(&self, ray: &Ray, along: f64) -> f64 {
        ((self.t_start + along) * self.per_unit).clamp(ray.t_min, ray.t_max)
    }
}

/// Clips the ray in f64 against the box that holds all surface, and asks for its side.
pub(in crate::intersect) fn local_ray(
    blobs: &Blobs,
    bounds: Option<Aabb>,
    ray: &Ray,
) -> Option<LocalRay> {
    let clipped = ClippedRay::new(blobs.field.origin, bounds?, ray)?;
    let ClippedRay {
        starts_at_t_min, ..
    } = clipped;
    let inside = match ray.side {
        Side::Inside => true,
        Side::Outside => false,
        // The box holds all surface, so outside it the field lies below the threshold.
        Side::Unknown => {
            starts_at_t_min && blobs.field.at(ray.time).side(clipped.origin) == Side::Inside
        }
    };
    Some(LocalRay {
        origin: clipped.origin,
        direction: clipped.direction,
        t_start: clipped.t_start,
        length: clipped.length,
        starts_at_t_min,
        per_unit: clipped.per_unit,
        time_secs: ray.time,
        inside,
        side_is_proven: ray.side == Side::Unknown || (!starts_at_t_min && !inside),
    })
}
