//! A bent funnel of helical arms with a foot of dust (Gourmel et al. 2010, figure 8a).

use super::Generated;
use super::random::Random;
use super::staging::Staging;
use crate::kernel::Kernel;
use crate::math::aabb::DAabb;
use crate::particles::{Column, Particles};
use crate::scene::{BlobSettings, Weights};
use glam::DVec3;
use std::f64::consts::TAU;

/// Helical arms around the funnel.
const ARMS: usize = 6;
/// Turns of an arm from foot to top.
const TURNS: f64 = 3.5;

/// Radius of the funnel at height `s` in [0, 1].
fn funnel_radius(s: f64) -> f64 {
    0.035 + 0.05 * s + 0.27 * s * s * s
}

/// The funnel's bent axis at height `s`.
fn axis(s: f64) -> DVec3 {
    DVec3::new(
        0.10 * (2.9 * s).sin() * (1.0 - 0.4 * s),
        s,
        0.07 * (4.1 * s + 0.5).sin() * (1.0 - 0.5 * s),
    )
}

/// Surface of the funnel, by the midpoint rule.
fn funnel_area() -> f64 {
    (0..1000)
        .map(|i| TAU * funnel_radius((f64::from(i) + 0.5) / 1000.0) / 1000.0)
        .sum()
}

/// `count` centres with their velocity.
pub(super) fn generate(count: usize, seed: u64) -> Generated {
    let mut random = Random::new(seed);
    let spacing = (funnel_area() / count as f64).sqrt();
    let mut positions = Vec::with_capacity(count);
    let mut velocities = Vec::with_capacity(count * 3);
    while positions.len() < count {
        let dust = random.unit() < 0.12;
        let s = if dust {
            0.06 * random.unit() * random.unit()
        } else {
            // Heights with a density in proportion to the funnel's girth.
            let s = random.unit();
            if random.unit() * funnel_radius(1.0) > funnel_radius(s) {
                continue;
            }
            s
        };
        let arm = random.below(ARMS) as f64 / ARMS as f64;
        // The sum of three uniform numbers gathers the particles towards the middle of an arm.
        let spread = (random.unit() + random.unit() + random.unit() - 1.5) / 1.5;
        let angle = TAU * (arm + TURNS * s.sqrt() + 0.55 * spread / ARMS as f64);
        let radius = if dust {
            funnel_radius(s) * (0.6 + 2.2 * random.unit())
        } else {
            funnel_radius(s) * (0.86 + 0.2 * random.unit()) + spacing * random.range(-0.5, 0.5)
        };
        let outward = DVec3::new(angle.cos(), 0.0, angle.sin());
        let tangent = DVec3::new(-angle.sin(), 0.0, angle.cos());
        positions.push(axis(s) + outward * radius);
        let velocity = tangent * (0.12 / (radius + 0.05)) + DVec3::Y * (0.2 + 0.5 * s);
        velocities.extend(velocity.as_vec3().to_array());
    }
    let mut particles = Particles::from_positions(positions);
    particles
        .columns
        .push(Column::new("velocity", 3, velocities));
    let blobs = BlobSettings {
        support: Some(2.6 * spacing),
        kernel: Kernel::Quartic,
        threshold: 0.5,
        weights: Weights::Unit,
        ..BlobSettings::default()
    };
    let bounds = DAabb {
        min: DVec3::new(-0.34, -0.02, -0.34),
        max: DVec3::new(0.42, 1.02, 0.34),
    };
    Generated {
        particles,
        scene: Staging {
            blobs,
            bounds,
            towards_eye: DVec3::new(0.35, 0.18, 1.0),
            up: DVec3::Y,
            light: DVec3::new(0.45, 0.75, 0.55),
            preset: "clay",
            ground: false,
        }
        .scene(),
    }
}
