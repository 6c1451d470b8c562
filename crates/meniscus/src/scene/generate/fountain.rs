//! A fountain: one tall jet within two rings of arcs, each particle on its own parabola
//! (the scene of Kanamori et al. 2008, figure 12).

use super::Generated;
use super::ballistic::{self, Motion};
use super::random::Random;
use super::staging::Staging;
use crate::math::aabb::DAabb;
use crate::scene::BlobSettings;
use glam::DVec3;
use std::f64::consts::TAU;

/// A circle of equal nozzles.
struct Ring {
    nozzles: usize,
    radius: f64,
    /// Speeds at the nozzle, m/s, outward and upward.
    outward: f64,
    upward: f64,
    /// Standard width of the random part of the velocity, m/s.
    turbulence: f64,
    /// Share of all particles.
    share: f64,
}

const RINGS: [Ring; 3] = [
    Ring {
        nozzles: 1,
        radius: 0.0,
        outward: 0.0,
        upward: 6.4,
        turbulence: 0.24,
        share: 0.4,
    },
    Ring {
        nozzles: 12,
        radius: 0.25,
        outward: 0.85,
        upward: 4.4,
        turbulence: 0.07,
        share: 0.36,
    },
    Ring {
        nozzles: 18,
        radius: 1.35,
        outward: -0.75,
        upward: 3.0,
        turbulence: 0.04,
        share: 0.24,
    },
];

/// Radius of a nozzle in metres.
const NOZZLE_RADIUS: f64 = 0.022;

/// When a still picture is taken: any moment will do, the fountain is in a steady state.
const STILL_SECS: f64 = 0.0;

/// `count` particles at `time_secs`. A particle that falls back to height 0 starts again from its
/// nozzle under a new id.
pub(super) fn generate(count: usize, seed: u64, time_secs: Option<f64>) -> Generated {
    let time_secs = time_secs.unwrap_or(STILL_SECS);
    let mut random = Random::new(seed);
    let mut motions = Vec::with_capacity(count);
    let mut ids = Vec::with_capacity(count);
    for particle in 0..count {
        let mut pick = random.unit();
        let ring = RINGS
            .iter()
            .find(|ring| {
                pick -= ring.share;
                pick < 0.0
            })
            .unwrap_or(&RINGS[0]);
        let angle = TAU * random.below(ring.nozzles) as f64 / ring.nozzles as f64;
        let outward = DVec3::new(angle.cos(), 0.0, angle.sin());
        let nozzle = random.in_ball() * NOZZLE_RADIUS;
        let origin = outward * ring.radius + DVec3::new(nozzle.x, 0.0, nozzle.z);
        let velocity = outward * ring.outward
            + DVec3::Y * ring.upward
            + random.in_ball() * DVec3::new(1.0, 0.7, 1.0) * ring.turbulence;
        let life_secs = ballistic::flight_time(velocity.y);
        let age_secs = random.unit() * life_secs + time_secs;
        let lives = (age_secs / life_secs).floor();
        motions.push(Motion::launched(
            origin,
            velocity,
            age_secs - lives * life_secs,
        ));
        ids.push((particle as u32).wrapping_add((lives as u32).wrapping_mul(count as u32)));
    }
    // Lengths shrink with the cube root of the count, as a finer simulation of the same water would.
    let radius = 0.0075 * (100_000.0 / count as f64).cbrt();
    let blobs = BlobSettings {
        radius: Some(radius),
        ..BlobSettings::default()
    };
    let bounds = DAabb {
        min: DVec3::new(-1.4, 0.0, -1.4),
        max: DVec3::new(1.4, 2.25, 1.4),
    };
    let scene = Staging {
        blobs,
        bounds,
        towards_eye: DVec3::new(0.3, 0.32, 1.0),
        up: DVec3::Y,
        light: DVec3::new(0.45, 0.75, 0.55),
        preset: "water",
        ground: true,
    }
    .scene();
    Generated {
        particles: ballistic::particles(&motions, ids),
        scene,
    }
}
