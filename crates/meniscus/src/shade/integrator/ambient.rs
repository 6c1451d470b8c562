//! Unshadowed light from all around, for integrators that do not trace it.

use crate::frame::{Environment, Frame, Light};
use crate::shade::light::Sky;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// Directions by which an environment image is projected.
const DIRECTIONS: u32 = 4096;

/// What surrounds a scene, as surfaces see it that nothing shades.
pub(in crate::shade) struct Ambient {
    pub(in crate::shade) sky: Option<Sky>,
    pub(in crate::shade) constant: Vec3,
    /// Irradiance over π of the environment images: spherical harmonics up to degree 2, convolved
    /// with the cosine (Ramamoorthi & Hanrahan 2001).
    pub(in crate::shade) harmonics: Option<[Vec3; 9]>,
    up: DVec3,
}

impl Ambient {
    pub(super) fn new(frame: &Frame) -> Self {
        let mut sky_mean: Option<Vec3> = None;
        let mut constant = Vec3::ZERO;
        let mut harmonics: Option<[Vec3; 9]> = None;
        for light in &frame.lights {
            match light {
                Light::Sky { radiance } => {
                    let more = Vec3::from_array(*radiance);
                    sky_mean = Some(sky_mean.map_or(more, |sum| sum + more));
                }
                Light::Constant { radiance } => constant += Vec3::from_array(*radiance),
                Light::Environment { environment, scale } => {
                    let sums = harmonics.get_or_insert([Vec3::ZERO; 9]);
                    project(environment, Vec3::from_array(*scale), sums);
                }
                Light::Sun { .. }
                | Light::Point { .. }
                | Light::Sphere { .. }
                | Light::Rectangle { .. } => {}
            }
        }
        Self {
            sky: sky_mean.map(|mean| Sky::new(mean.to_array())),
            constant,
            harmonics,
            up: frame.up,
        }
    }

    /// Radiance of a white diffuse surface with this unit normal.
    pub(super) fn diffuse(&self, normal: DVec3) -> Vec3 {
        let mut light = self.constant;
        if let Some(sky) = &self.sky {
            light += sky.diffuse(normal.dot(self.up) as f32);
        }
        if let Some(harmonics) = &self.harmonics {
            let sum: Vec3 = harmonics
                .iter()
                .zip(basis(normal))
                .map(|(&coefficient, value)| coefficient * value as f32)
                .sum();
            light += sum.max(Vec3::ZERO);
        }
        light
    }
}

/// The real spherical harmonics of degrees 0 to 2.
fn basis(direction: DVec3) -> [f64; 9] {
    let DVec3 { x, y, z } = direction;
    let [c0, c1, c2, c20] = [
        (0.25 / PI).sqrt(),
        (0.75 / PI).sqrt(),
        (3.75 / PI).sqrt(),
        (0.3125 / PI).sqrt(),
    ];
    [
        c0,
        c1 * y,
        c1 * z,
        c1 * x,
        c2 * x * y,
        c2 * y * z,
        c20 * (3.0 * z * z - 1.0),
        c2 * x * z,
        0.5 * c2 * (x * x - y * y),
    ]
}

/// Adds the harmonics of an image; the factors of the cosine over π are 1, 2/3 and 1/4.
fn project(environment: &Environment, scale: Vec3, sums: &mut [Vec3; 9]) {
    for i in 0..DIRECTIONS {
        let u = [
            (f64::from(i) + 0.5) / f64::from(DIRECTIONS),
            f64::from(i.reverse_bits()) / 4_294_967_296.0,
        ];
        let Some((direction, density)) = environment.sample(u) else {
            return;
        };
        let light = environment.radiance(direction) * scale;
        let part = light / (density * f64::from(DIRECTIONS)) as f32;
        for (k, value) in basis(direction).into_iter().enumerate() {
            let factor = match k {
                0 => 1.0,
                1..=3 => 2.0 / 3.0,
                _ => 0.25,
            };
            sums[k] += part * (value * factor) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn an_even_image_lights_like_a_constant_and_a_bright_half_by_its_cosine() {
        let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let of = |texels: Vec<[f32; 3]>| {
            Ambient::new(&Frame {
                lights: vec![Light::Environment {
                    environment: Arc::new(Environment::new(8, texels, axes, 0.0)),
                    scale: [2.0; 3],
                }],
                ..Frame::default()
            })
        };
        let even = of(vec![[0.5, 1.0, 1.5]; 32]);
        for normal in [DVec3::X, DVec3::NEG_Y, DVec3::ONE.normalize()] {
            let light = even.diffuse(normal);
            assert!(
                (light - Vec3::new(1.0, 2.0, 3.0)).length() < 0.03,
                "{light}"
            );
        }
        let mut upper = vec![[1.0; 3]; 8 * 32];
        upper[8 * 16..].fill([0.0; 3]);
        let upper = of(upper);
        // (1 + cos θ)/2 of a bright upper half, exact in these harmonics.
        for (normal, part) in [(DVec3::Y, 1.0), (DVec3::X, 0.5), (DVec3::NEG_Y, 0.0)] {
            let light = upper.diffuse(normal).x;
            assert!((light - 2.0 * part).abs() < 0.05, "{light} for {part}");
        }
    }
}
