//! Rays against spheres and planes, in object space.

use crate::frame::{Plane, Sphere};
use crate::math::ray::{Ray, Side};
use glam::DVec3;

/// Where a ray meets a surface that is no field, in the object's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidHit {
    /// Ray parameter, in lengths of the ray's direction.
    pub t: f64,
    /// The point, nearer to the surface than the ray's own at `t`.
    pub position: DVec3,
    /// Unit normal that points outside.
    pub outward: DVec3,
    /// Unit normal for shading, on the same side.
    pub shading: DVec3,
    /// Whether the ray goes from outside to inside here.
    pub entering: bool,
}

/// Whether a crossing goes to the side on which the ray says to start.
pub(super) fn contradicts(side: Side, entering: bool) -> bool {
    match side {
        Side::Unknown => false,
        Side::Outside => !entering,
        Side::Inside => entering,
    }
}

impl Plane {
    /// Crossing of an object-space ray: its parameter and whether it enters. A plane that a ray with a
    /// stated side starts on, up to `origin_error`, is not hit from the other side, and hit at once
    /// from the stated one: between it and what stands on it there is no gap.
    pub fn closest(&self, ray: &Ray, origin_error: f64) -> Option<(f64, bool)> {
        let rate = ray.direction.dot(self.normal);
        let t = (self.point - ray.origin).dot(self.normal) / rate;
        let entering = rate < 0.0;
        if !ray.is_traceable() || !t.is_finite() {
            return None;
        }
        let is_at_start =
            ray.side != Side::Unknown && self.height(ray.at(ray.t_min)).abs() <= origin_error;
        let t = match is_at_start {
            true if contradicts(ray.side, entering) => return None,
            true => t.max(ray.t_min),
            false => t,
        };
        (t >= ray.t_min && t <= ray.t_max).then_some((t, entering))
    }

    /// Height of a point above the plane.
    pub fn height(&self, point: DVec3) -> f64 {
        (point - self.point).dot(self.normal)
    }
}

impl Sphere {
    /// First crossing of an object-space ray. The surface that a ray with a stated side starts on is
    /// not hit where the ray would come from the other side.
    pub fn closest(&self, ray: &Ray, origin_error: f64) -> Option<SolidHit> {
        let crossings = self.crossings(ray, origin_error);
        let (t, entering) = crossings.into_iter().flatten().next()?;
        let outward = (ray.at(t) - self.center).normalize_or_zero();
        Some(SolidHit {
            t,
            position: self.center + outward * self.radius,
            outward,
            shading: outward,
            entering,
        })
    }

    /// Both crossings within the ray's range, the first one first.
    pub fn crossings(&self, ray: &Ray, origin_error: f64) -> [Option<(f64, bool)>; 2] {
        if !ray.is_traceable() {
            return [None; 2];
        }
        // In units of the radius; the ray's middle is where it comes nearest to the centre, and the
        // distance there keeps its digits however far the ray comes from (E. Haines et al., Ray
        // Tracing Gems, ch. 7).
        let origin = (ray.origin - self.center) / self.radius;
        let direction = ray.direction / self.radius;
        let speed = direction.length();
        let along = direction / speed;
        let middle = -origin.dot(along);
        let nearest = origin + along * middle;
        let discriminant = 1.0 - nearest.length_squared();
        if discriminant.is_nan() || discriminant < 0.0 {
            return [None; 2];
        }
        let half = discriminant.sqrt();
        let start = origin + along * (ray.t_min * speed);
        let is_own_start = (start.length() - 1.0).abs() <= origin_error / self.radius;
        let crossing = |t: f64, entering: bool| {
            let t = t / speed;
            let is_left = is_own_start && contradicts(ray.side, entering);
            (t >= ray.t_min && t <= ray.t_max && !is_left).then_some((t, entering))
        };
        [
            crossing(middle - half, true),
            crossing(middle + half, false),
        ]
    }

    /// Which side an object-space point lies on.
    pub fn side(&self, point: DVec3) -> Side {
        if point.distance(self.center) < self.radius {
            Side::Inside
        } else {
            Side::Outside
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_crossed_twice_from_any_distance() {
        for (distance, radius) in [(3.0, 1.0), (1e6, 1e-3), (1e-7, 1e-9), (1e12, 1e9)] {
            let sphere = Sphere {
                center: DVec3::new(0.5 * radius, 0.0, distance),
                radius,
            };
            let ray = Ray::new(DVec3::ZERO, DVec3::Z * 0.5);
            let [Some((near, true)), Some((far, false))] = sphere.crossings(&ray, 0.0) else {
                panic!("{distance} {radius}: {:?}", sphere.crossings(&ray, 0.0));
            };
            let half = radius * 0.75_f64.sqrt();
            assert!((near * 0.5 - (distance - half)).abs() <= 4.0 * f64::EPSILON * distance);
            assert!((far * 0.5 - (distance + half)).abs() <= 4.0 * f64::EPSILON * distance);
        }
    }

    #[test]
    fn a_plane_is_met_by_rays_within_something_else() {
        let plane = Plane {
            point: DVec3::new(5.0, -3.0, 1e6),
            normal: DVec3::new(0.6, 0.8, 0.0),
        };
        let error = 256.0 * f64::EPSILON * 1e6;
        let along = DVec3::new(0.8, -0.6, 0.3);
        let start = plane.point + along * 7.0;
        for lift in [1.0, 1e-4, 1e-8] {
            let up = Ray::new(start, along + plane.normal * lift).with_side(Side::Outside);
            assert_eq!(plane.closest(&up, error), None);
            let down = Ray::new(start, along - plane.normal * lift).with_side(Side::Inside);
            assert_eq!(plane.closest(&down, error), None);
        }
        // Out of something that stands on the plane: no gap, whatever rounding does.
        for lift in [0.0, 0.5, -0.5] {
            let touching = start + plane.normal * (lift * error);
            let down = Ray::new(touching, along - plane.normal).with_side(Side::Outside);
            let (t, entering) = plane.closest(&down, error).unwrap();
            assert!((0.0..=error).contains(&t) && entering, "{lift}: {t}");
        }
        // A ray inside water above the plane says so of every surface.
        let from_above = Ray::new(start + plane.normal, -plane.normal).with_side(Side::Inside);
        let (t, entering) = plane.closest(&from_above, error).unwrap();
        assert!((t - 1.0).abs() < 1e-9 && entering);
    }

    #[test]
    fn a_ray_that_leaves_does_not_hit_what_it_leaves() {
        let sphere = Sphere {
            center: DVec3::new(1e3, -2e3, 5e2),
            radius: 0.25,
        };
        let error = 256.0 * f64::EPSILON * 4e3;
        let mut far = 0;
        for k in 0..1000 {
            let angle = f64::from(k);
            let out = DVec3::new(angle.cos(), angle.sin(), (angle * 0.37).sin()).normalize();
            let start = sphere.center + out * sphere.radius;
            // Also almost along the surface.
            let tangent = out.any_orthonormal_vector();
            for lift in [1.0, 1e-3, 1e-9] {
                let up = Ray::new(start, tangent + out * lift).with_side(Side::Outside);
                assert_eq!(sphere.closest(&up, error), None, "{k} {lift}");
                let down = Ray::new(start, tangent - out * lift).with_side(Side::Inside);
                far += usize::from(
                    sphere
                        .closest(&down, error)
                        .is_some_and(|hit| !hit.entering),
                );
            }
        }
        assert!(
            far >= 2000,
            "{far} rays through the inside found the other wall"
        );
    }
}
