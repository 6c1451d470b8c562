//! Motion under gravity alone, and the columns that describe it.

use crate::particles::{Column, Particles};
use glam::DVec3;

/// Gravity in m/s², +Y up.
pub(super) const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A particle's state at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    /// Position in metres.
    pub(super) position: DVec3,
    /// Velocity in m/s.
    pub(super) velocity: DVec3,
    /// Acceleration in m/s².
    pub(super) acceleration: DVec3,
}

impl Motion {
    /// At rest.
    pub(super) fn resting(position: DVec3) -> Self {
        Self {
            position,
            velocity: DVec3::ZERO,
            acceleration: DVec3::ZERO,
        }
    }

    /// `flight_secs` after the launch from `origin` with `velocity`.
    pub(super) fn launched(origin: DVec3, velocity: DVec3, flight_secs: f64) -> Self {
        Self {
            position: origin + (velocity + GRAVITY * (0.5 * flight_secs)) * flight_secs,
            velocity: velocity + GRAVITY * flight_secs,
            acceleration: GRAVITY,
        }
    }
}

/// Seconds from a launch at height 0 with upward velocity `rise` until it is back at height 0.
pub(super) fn flight_time(rise: f64) -> f64 {
    -2.0 * rise / GRAVITY.y
}

/// Particles in these states with `id`, `velocity` and `acceleration`.
pub(super) fn particles(motions: &[Motion], ids: Vec<u32>) -> Particles {
    let vectors = |of: fn(&Motion) -> DVec3| -> Vec<f32> {
        motions
            .iter()
            .flat_map(|motion| of(motion).as_vec3().to_array())
            .collect()
    };
    let mut particles =
        Particles::from_positions(motions.iter().map(|motion| motion.position).collect());
    particles.columns = vec![
        Column::new("id", 1, ids),
        Column::new("velocity", 3, vectors(|motion| motion.velocity)),
        Column::new("acceleration", 3, vectors(|motion| motion.acceleration)),
    ];
    particles
}
