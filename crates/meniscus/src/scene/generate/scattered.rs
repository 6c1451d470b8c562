//! Uniformly random centres in the unit cube; each support meets about 4.5 others' centres of half
//! its size (Gourmel et al. 2010, figure 8f).

use super::Generated;
use super::random::Random;
use super::staging::Staging;
use crate::kernel::Kernel;
use crate::math::aabb::DAabb;
use crate::particles::Particles;
use crate::scene::{BlobSettings, Weights};
use glam::DVec3;
use std::f64::consts::PI;

/// Expected number of centres within twice the support.
const NEIGHBOURS: f64 = 4.5;

/// `count` centres.
pub(super) fn generate(count: usize, seed: u64) -> Generated {
    let mut random = Random::new(seed);
    let positions = (0..count)
        .map(|_| DVec3::splat(0.5) + random.in_cube(0.5))
        .collect();
    let support = (NEIGHBOURS / (count as f64 * 4.0 / 3.0 * PI * 8.0)).cbrt();
    let blobs = BlobSettings {
        support: Some(support),
        kernel: Kernel::Quartic,
        threshold: 0.2,
        weights: Weights::Unit,
        ..BlobSettings::default()
    };
    let bounds = DAabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    };
    Generated {
        particles: Particles::from_positions(positions),
        scene: Staging {
            blobs,
            bounds,
            towards_eye: DVec3::new(0.6, -1.0, 0.55),
            up: DVec3::Z,
            light: DVec3::new(0.45, -0.55, 0.75),
            preset: "clay",
            ground: false,
        }
        .scene(),
    }
}
