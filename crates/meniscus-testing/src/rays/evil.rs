//! Rays that break assumptions.

use super::{SurfacePoint, extent};
use crate::oracle::Oracle;
use crate::random::Stream;
use glam::DVec3;
use meniscus::math::ray::{Ray, Side};

/// Rays on axes, with zero, denormal, huge and tiny components, NaN and infinity, from a million sizes
/// away, with ranges that are empty, reversed, negative, a point, or end inside; and rays that start
/// on the surface with either side stated or none.
pub fn evil(oracle: &Oracle, points: &[SurfacePoint], seed: u64) -> Vec<Ray> {
    let field = oracle.field();
    let (center, size) = extent(oracle);
    let mut rays = not_rays(center);
    for i in 0..field.len().min(40) {
        let mut random = Stream::new(seed, i as u64);
        let blob = random.index(field.len());
        let p = field.origin + field.center(blob).as_dvec3();
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][i % 3] * [1.0, -1.0][i / 3 % 2];
        let from = p - axis * (2.0 * size);
        let oblique = random.direction();
        let far = p - oblique * (size * 1e6);
        rays.extend([
            Ray::new(from, axis),
            Ray::new(from, axis + DVec3::splat(1e-310)),
            Ray::new(from, axis + DVec3::splat(-1e-30)),
            Ray::new(from, axis * 1e-140),
            Ray::new(from, axis * 1e140),
            Ray::new(p, axis),
            Ray::new(center - axis * size, axis),
            // Along the faces of a box around everything.
            Ray::new(
                center + DVec3::splat(0.5 * size) - axis * (2.0 * size),
                axis,
            ),
            Ray::new(far, oblique),
            Ray::new(far, oblique).with_range(size * 1e6 - size, size * 1e6),
            Ray::new(p, oblique).with_range(-3.0 * size, 0.0),
            Ray::new(p, oblique).with_range(-3.0 * size, 3.0 * size),
            Ray::new(p, oblique).with_range(1.0, -1.0),
            Ray::new(p, oblique).with_range(0.0, 0.0),
            Ray::new(p, oblique).with_range(-f64::MAX, f64::MAX),
            Ray::new(p, oblique).with_range(random.unit() * size, random.unit() * size),
            Ray::new(p - oblique * size, oblique).with_side(Side::Inside),
        ]);
    }
    for (i, point) in points.iter().enumerate() {
        let mut random = Stream::new(seed + 1, i as u64);
        let out = random.cosine_direction(point.normal);
        let start =
            |direction: DVec3, side: Side| Ray::new(point.position, direction).with_side(side);
        rays.extend([
            start(out, Side::Outside),
            start(-out, Side::Inside),
            start(out, Side::Inside),
            start(-out, Side::Unknown),
            start(point.normal, Side::Outside),
            // Ends at the surface, or just before, or in the middle of the inside.
            Ray::new(point.position + out * size, -out).with_range(0.0, size),
            Ray::new(point.position + out * size, -out).with_range(0.0, size * 0.999),
            Ray::new(point.position + out * size, -out).with_range(0.0, size * 1.01),
        ]);
    }
    rays
}

/// Everything that is no ray: an engine must answer "no hit".
fn not_rays(center: DVec3) -> Vec<Ray> {
    let mut rays = Vec::new();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut vector = DVec3::ONE;
            vector[axis] = bad;
            rays.push(Ray::new(vector, DVec3::X));
            rays.push(Ray::new(center, vector));
        }
        rays.push(Ray::new(center, DVec3::X).with_range(bad, f64::INFINITY));
    }
    rays.push(Ray::new(center, DVec3::X).with_range(0.0, f64::NAN));
    rays.push(Ray::new(center, DVec3::X).with_range(0.0, f64::NEG_INFINITY));
    rays.push(Ray::new(center, DVec3::ZERO));
    rays.push(Ray::new(center, DVec3::splat(f64::MAX)));
    rays
}
