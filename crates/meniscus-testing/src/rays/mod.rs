//! Ray sets: ordinary, grazing, inside and evil.
//!
//! All come from counter-based random numbers, so a set is the same on every machine.

mod evil;

pub use evil::evil;

use crate::oracle::Oracle;
use crate::random::Stream;
use glam::DVec3;
use meniscus::math::ray::{Ray, Side};

/// A point on the surface with its unit outward normal, object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// The point, rounded to f32 relative to the field's origin, as an engine's hit would be.
    pub position: DVec3,
    /// −∇F/|∇F|.
    pub normal: DVec3,
}

/// Box around the field's supports in object space: centre and diagonal.
pub fn extent(oracle: &Oracle) -> (DVec3, f64) {
    let bounds = oracle.field().bounds();
    if bounds.is_empty() {
        return (oracle.field().origin, 1.0);
    }
    let center = 0.5 * (bounds.min.as_dvec3() + bounds.max.as_dvec3());
    (oracle.field().origin + center, oracle.diameter())
}

/// Pixel centres of a square picture of the whole field, seen from the direction `towards_eye`.
pub fn primary(oracle: &Oracle, side: usize, towards_eye: DVec3) -> Vec<Ray> {
    let (center, diagonal) = extent(oracle);
    let eye = center + towards_eye.normalize() * (1.2 * diagonal);
    let forward = (center - eye).normalize();
    let right = forward.cross(forward.any_orthonormal_vector()).normalize();
    let up = right.cross(forward);
    let step = 1.0 / side as f64;
    (0..side * side)
        .map(|pixel| {
            let x = (pixel % side) as f64 * step + 0.5 * step - 0.5;
            let y = (pixel / side) as f64 * step + 0.5 * step - 0.5;
            Ray::new(eye, (forward + (right * x - up * y) * 0.8).normalize())
        })
        .collect()
}

/// Points where random lines through the supports cross the surface.
pub fn surface_points(oracle: &Oracle, count: usize, seed: u64) -> Vec<SurfacePoint> {
    let field = oracle.field();
    let mut points = Vec::new();
    if field.is_empty() {
        return points;
    }
    for i in 0..4 * count as u64 {
        let mut random = Stream::new(seed, i);
        let blob = random.index(field.len());
        let center = field.origin + field.center(blob).as_dvec3();
        let radius = field.shapes.mean_radius(blob);
        let target = center + random.direction() * radius * random.unit();
        let direction = random.direction();
        let ray =
            Ray::new(target - direction * (2.0 * radius), direction).with_range(0.0, 4.0 * radius);
        points.extend(
            oracle
                .crossings(&ray)
                .iter()
                .map(|crossing| point_at(oracle, ray.at(crossing.t))),
        );
        if points.len() >= count {
            points.truncate(count);
            break;
        }
    }
    points
}

/// The surface point at `position`, which lies on the surface.
pub fn point_at(oracle: &Oracle, position: DVec3) -> SurfacePoint {
    let origin = oracle.field().origin;
    SurfacePoint {
        position: (position - origin).as_vec3().as_dvec3() + origin,
        normal: oracle.sample(position).outward.normalize_or(DVec3::Y),
    }
}

/// One ray per point into the hemisphere about its normal, distributed by the cosine.
pub fn hemisphere(points: &[SurfacePoint], seed: u64) -> Vec<Ray> {
    let leave = |(i, point): (usize, &SurfacePoint)| {
        let direction = Stream::new(seed, i as u64).cosine_direction(point.normal);
        Ray::new(point.position, direction).with_side(Side::Outside)
    };
    points.iter().enumerate().map(leave).collect()
}

/// One ray per point that faces the light, towards it.
pub fn shadow(points: &[SurfacePoint], towards_light: DVec3) -> Vec<Ray> {
    points
        .iter()
        .filter(|point| point.normal.dot(towards_light) > 0.0)
        .map(|point| Ray::new(point.position, towards_light).with_side(Side::Outside))
        .collect()
}

/// Rays that touch the surface, almost touch it or cut it a little, at each point.
pub fn grazing(oracle: &Oracle, points: &[SurfacePoint], seed: u64) -> Vec<Ray> {
    let spacing = f64::from(oracle.field().spacing);
    let (_, diagonal) = extent(oracle);
    let graze = |(i, point): (usize, &SurfacePoint)| {
        let mut random = Stream::new(seed, i as u64);
        let direction = point
            .normal
            .cross(random.direction())
            .normalize_or(DVec3::X);
        let off = match i % 5 {
            0 => 0.0,
            1 | 2 => random.log_range(1e-8, 1e-1),
            _ => -random.log_range(1e-8, 1e-1),
        };
        let start = point.position + point.normal * (off * spacing);
        let back = diagonal * random.range(0.2, 1.5);
        Ray::new(start - direction * back, direction)
    };
    points.iter().enumerate().map(graze).collect()
}

/// Rays per bundle of [`bundles`].
pub const BUNDLE: usize = 16;

/// Every ray with fifteen companions from the same start that point almost the same way, between
/// nearly parallel and a few degrees apart.
pub fn bundles(rays: &[Ray], seed: u64) -> Vec<Ray> {
    let turned = |i: usize, k: usize| {
        let mut random = Stream::new(seed, (i * BUNDLE + k) as u64);
        let spread = Stream::new(seed + 1, i as u64).log_range(1e-7, 5e-2);
        let direction = rays[i].direction;
        let off = random.direction() * (direction.length() * spread * random.unit());
        Ray {
            direction: if k == 0 { direction } else { direction + off },
            ..rays[i]
        }
    };
    (0..rays.len() * BUNDLE)
        .map(|index| turned(index / BUNDLE, index % BUNDLE))
        .collect()
}

/// Rays from inside the surface in all directions, every second one with its side stated.
pub fn inside(oracle: &Oracle, points: &[SurfacePoint], seed: u64) -> Vec<Ray> {
    let spacing = f64::from(oracle.field().spacing);
    let threshold = f64::from(oracle.field().threshold);
    let start = |(i, point): (usize, &SurfacePoint)| {
        let mut random = Stream::new(seed, i as u64);
        let depth = random.log_range(1e-4, 1.0);
        let start = point.position - point.normal * (depth * spacing);
        let ray = Ray::new(start, random.direction());
        let is_inside = oracle.sample(start).value > threshold * (1.0 + 1e-4);
        let stated = if i % 2 == 0 {
            Side::Inside
        } else {
            Side::Unknown
        };
        is_inside.then_some(ray.with_side(stated))
    };
    points.iter().enumerate().filter_map(start).collect()
}

/// The same rays in random order (Fisher and Yates).
pub fn shuffled(mut rays: Vec<Ray>, seed: u64) -> Vec<Ray> {
    for i in (1..rays.len()).rev() {
        rays.swap(i, Stream::new(seed, i as u64).index(i + 1));
    }
    rays
}
