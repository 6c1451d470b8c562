use super::*;
use crate::math::sampling::{PixelSampler, uniform_sphere};

fn sampled(emitter: &Emitter, point: DVec3, normal: DVec3, count: u32) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for i in 0..count {
        let u = PixelSampler::new([3, 4], i, 0).next_2d();
        if let Some(sample) = emitter.sample(point, u) {
            assert!((sample.towards.length() - 1.0).abs() < 1e-9);
            let cosine = sample.towards.dot(normal).max(0.0);
            sum += sample.weight * cosine as f32;
            if sample.density.is_finite() {
                let density = emitter.density(point, sample.towards);
                assert!(
                    (density / sample.density - 1.0).abs() < 1e-6,
                    "{emitter:?}: {density} for {}",
                    sample.density
                );
            }
        }
    }
    sum / count as f32
}

/// Irradiance by uniform directions and what they meet.
fn met(emitter: &Emitter, point: DVec3, normal: DVec3, count: u32) -> f64 {
    let mut sum = 0.0;
    for i in 0..count {
        let direction = uniform_sphere(PixelSampler::new([8, 1], i, 0).next_2d());
        let near = emitter
            .met(point, direction, f64::INFINITY)
            .map_or(Vec3::ZERO, |(_, radiance)| radiance);
        let light = near + emitter.escaped(direction, DVec3::Y);
        sum += f64::from(light.x) * direction.dot(normal).max(0.0);
    }
    sum * 4.0 * PI / f64::from(count)
}

#[test]
fn irradiances_have_their_closed_forms_by_sampling_and_by_meeting() {
    let point = DVec3::new(1.0, 2.0, 3.0);
    let up = DVec3::Y;
    // A sun of 40° overhead: E = π · 2.
    let sun = Emitter::Sun(Sun::new(up, Vec3::splat(2.0), 20_f64.to_radians()));
    // A ball whose centre is 4 above, of radius 1: E = π L r²/d².
    let ball = Emitter::Sphere(Sphere::new(point + up * 4.0, 1.0, Vec3::splat(3.0)));
    // A square of side 2, 1 above: the view factor of a parallel square over a point is
    // 4/(2π)·2·(a/√(1+a²))·atan(a/√(1+a²)) with a = 1 for each of its quarters.
    let square = Emitter::Rectangle(Rectangle::new(
        point + up,
        [DVec3::X * 2.0, DVec3::Z * 2.0],
        Vec3::splat(1.0),
    ));
    let x = 1.0 / 2.0_f64.sqrt();
    let quarter = x * x.atan() * 2.0 / (2.0 * PI);
    for (emitter, expected) in [
        (&sun, 2.0 * PI),
        (&ball, 3.0 * PI / 16.0),
        (&square, 4.0 * quarter * PI),
    ] {
        let drawn = f64::from(sampled(emitter, point, up, 4096).x);
        assert!(
            (drawn / expected - 1.0).abs() < 0.01,
            "{emitter:?}: {drawn} for {expected}"
        );
        let seen = met(emitter, point, up, 65_536);
        assert!(
            (seen / expected - 1.0).abs() < 0.03,
            "{emitter:?}: {seen} for {expected}"
        );
    }
    // Behind its back a rectangle is dark.
    let Emitter::Rectangle(rectangle) = &square else {
        unreachable!()
    };
    assert_eq!(rectangle.irradiance(point + up * 2.0), Vec3::ZERO);
}

#[test]
fn a_sun_without_size_is_one_direction_of_the_same_strength() {
    let towards = DVec3::new(0.6, 0.8, 0.0);
    for angle in [0.0, 1e-3, 0.02] {
        let sun = Emitter::Sun(Sun::new(towards, Vec3::splat(1.5), angle));
        let light = sampled(&sun, DVec3::ZERO, towards, 256);
        assert!(
            (f64::from(light.x) / (1.5 * PI) - 1.0).abs() < 1e-3,
            "{angle}: {light}"
        );
    }
    let point = Sun::new(towards, Vec3::ONE, 0.0);
    assert_eq!(point.radiance(towards), Vec3::ZERO);
}

#[test]
fn lights_are_drawn_by_what_they_give_and_their_sum_is_right() {
    let lights = Lights {
        emitters: vec![
            Emitter::Sun(Sun::new(DVec3::Y, Vec3::splat(1.0), 0.1)),
            Emitter::Point(DVec3::new(0.0, 2.0, 0.0), Vec3::splat(8.0)),
            Emitter::Sphere(Sphere::new(DVec3::Y * 5.0, 1.0, Vec3::splat(50.0))),
            Emitter::Constant(Vec3::ONE),
        ],
        up: DVec3::Y,
    };
    // E over π: 1 + 8/4 + 50/25.
    let expected = 5.0 * PI;
    let count = 4096;
    let mut sum = 0.0;
    for i in 0..count {
        let mut sampler = PixelSampler::new([0, 0], i, 0);
        let (choice, u) = (sampler.next_1d(), sampler.next_2d());
        let (emitter, sample) = lights.sample(DVec3::ZERO, choice, u).unwrap();
        sum += f64::from(sample.weight.x) * sample.towards.y.max(0.0);
        if sample.density.is_finite() {
            let density = lights.density(emitter, DVec3::ZERO, sample.towards);
            assert!((density / sample.density - 1.0).abs() < 1e-6);
        }
    }
    let found = sum / f64::from(count);
    assert!(
        (found / expected - 1.0).abs() < 0.01,
        "{found} for {expected}"
    );
    assert_eq!(lights.hard(DVec3::ZERO).count(), 3);
    assert_eq!(lights.surroundings(DVec3::X), Vec3::ONE);
}
