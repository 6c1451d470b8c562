//! Rays through the half spaces that cuts leave.

use crate::frame::Plane;
use crate::math::ray::Ray;

/// Rounding of a point on a plane, relative to its coordinates.
const ON_PLANE: f64 = 1e-12;

/// The part of a ray that lies below all planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    /// Where the ray enters, and through which plane; `None` where it starts below all of them.
    pub(super) entry: Option<(f64, usize)>,
    /// Where it leaves, and through which plane; `None` where it never does.
    pub(super) exit: Option<(f64, usize)>,
}

impl Span {
    /// The part of `ray` from `t_min` on that lies below all `planes`; `None` where nothing does. A
    /// ray that starts on a plane leaves it at once or is below it from the start: a cap is not hit
    /// by the rays that leave it.
    pub(super) fn new(planes: &[Plane], ray: &Ray) -> Option<Self> {
        let mut span = Self {
            entry: None,
            exit: None,
        };
        let start = ray.at(ray.t_min);
        for (index, plane) in planes.iter().enumerate() {
            let height = plane.height(start);
            let size = start.abs().max_element() + plane.point.abs().max_element();
            let is_on_plane = height.abs() <= ON_PLANE * size;
            let rate = ray.direction.dot(plane.normal);
            let t = ray.t_min - height / rate;
            if rate > 0.0 {
                if is_on_plane || height > 0.0 {
                    return None;
                }
                if span.exit.is_none_or(|(leave, _)| t < leave) {
                    span.exit = Some((t, index));
                }
            } else if rate < 0.0 {
                if !is_on_plane && height > 0.0 && span.entry.is_none_or(|(enter, _)| t > enter) {
                    span.entry = Some((t, index));
                }
            } else if height > 0.0 && !is_on_plane {
                return None;
            }
        }
        let is_empty = matches!((span.entry, span.exit), (Some(a), Some(b)) if a.0 >= b.0);
        (!is_empty).then_some(span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_ray_passes_a_slab() {
        let slab = [
            Plane {
                point: DVec3::X * 2.0,
                normal: DVec3::X,
            },
            Plane {
                point: DVec3::X,
                normal: -DVec3::X,
            },
        ];
        let span = |origin: f64, direction: f64| {
            Span::new(&slab, &Ray::new(DVec3::X * origin, DVec3::X * direction))
        };
        let through = Span {
            entry: Some((1.0, 1)),
            exit: Some((2.0, 0)),
        };
        assert_eq!(span(0.0, 1.0), Some(through));
        let from_inside = Span {
            entry: None,
            exit: Some((0.25, 0)),
        };
        assert_eq!(span(1.5, 2.0), Some(from_inside));
        assert_eq!(span(3.0, 1.0), None);
        // From the cap outwards nothing, inwards no cap.
        assert_eq!(span(2.0, 1.0), None);
        assert_eq!(
            span(2.0, -1.0),
            Some(Span {
                entry: None,
                exit: Some((1.0, 1))
            })
        );
        let beside = Ray::new(DVec3::ZERO, DVec3::Y);
        assert_eq!(Span::new(&slab, &beside), None);
    }
}
