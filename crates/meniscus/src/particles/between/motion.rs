//! How particles move from one frame to the next.

use super::keys::Keys;
use super::{Moment, Place};
use crate::particles::{Particles, Role};
use glam::DVec3;

/// Velocities that disagree with displacements by more than this in the median are not used.
const MOST_DISAGREEMENT: f64 = 2.0;

/// How a particle moves over the interval, in intervals instead of time.
#[derive(Debug, Clone, Copy)]
pub(super) enum Motion {
    /// From `start` to `end`, leaving and arriving with these displacements per interval.
    Through {
        start: DVec3,
        end: DVec3,
        leaving: DVec3,
        arriving: DVec3,
    },
    /// At `position` when `at`, from there on or up to there with this velocity and acceleration.
    Alone {
        at: f64,
        position: DVec3,
        velocity: DVec3,
        acceleration: DVec3,
    },
}

impl Motion {
    pub(super) fn position(&self, fraction: f64) -> DVec3 {
        match *self {
            Self::Through {
                start,
                end,
                leaving,
                arriving,
            } => {
                let (u, rest) = (fraction, 1.0 - fraction);
                // Relative to the start, so that coordinates far from 0 lose nothing.
                let step = u * u * (3.0 - 2.0 * u);
                start + (end - start) * step + leaving * (u * rest * rest)
                    - arriving * (u * u * rest)
            }
            Self::Alone {
                at,
                position,
                velocity,
                acceleration,
            } => {
                let away = fraction - at;
                position + (velocity + acceleration * (0.5 * away)) * away
            }
        }
    }
}

/// The frames around the pair, for velocities from differences.
pub(super) struct Around<'a> {
    pub(super) before: Option<(&'a Moment, Keys)>,
    pub(super) earlier: &'a Moment,
    pub(super) later: &'a Moment,
    pub(super) after: Option<(&'a Moment, Keys)>,
}

impl Around<'_> {
    pub(super) fn interval(&self) -> f64 {
        self.later.time - self.earlier.time
    }

    pub(super) fn found(around: Option<&(&Moment, Keys)>, key: u64) -> Option<(DVec3, f64)> {
        let (moment, keys) = around?;
        let index = *keys.index_of.get(&key)?;
        Some((moment.particles.positions[index], moment.time))
    }

    /// Displacements per interval at both ends of a particle's way: the slopes of the parabolas through
    /// three frames each.
    pub(super) fn displacements(&self, key: u64, start: DVec3, end: DVec3) -> (DVec3, DVec3) {
        let here = end - start;
        let leaving = Self::found(self.before.as_ref(), key).map(|(position, time)| {
            let share = (self.earlier.time - time) / self.interval();
            let before = (start - position) / share;
            // Weighed by the other interval's length.
            (here * share + before) / (1.0 + share)
        });
        let arriving = Self::found(self.after.as_ref(), key).map(|(position, time)| {
            let share = (time - self.later.time) / self.interval();
            let after = (position - end) / share;
            (here * share + after) / (1.0 + share)
        });
        match (leaving, arriving) {
            (None, None) => (here, here),
            // At the end of a sequence or a life: the parabola that the other end belongs to.
            (None, Some(arriving)) => (here * 2.0 - arriving, arriving),
            (Some(leaving), None) => (leaving, here * 2.0 - leaving),
            (Some(leaving), Some(arriving)) => (leaving, arriving),
        }
    }

    /// Displacement per interval of a particle that is about to go.
    pub(super) fn velocity_before(&self, key: u64, position: DVec3) -> DVec3 {
        Self::found(self.before.as_ref(), key).map_or(DVec3::ZERO, |(before, time)| {
            (position - before) * (self.interval() / (self.earlier.time - time))
        })
    }

    /// Displacement per interval of a particle that has just come.
    pub(super) fn velocity_after(&self, key: u64, position: DVec3) -> DVec3 {
        Self::found(self.after.as_ref(), key).map_or(DVec3::ZERO, |(after, time)| {
            (after - position) * (self.interval() / (time - self.later.time))
        })
    }
}

/// A role's vectors, scaled; `None` where the role is not there or not finite.
pub(super) fn vectors(particles: &Particles, role: Role, scale: f64) -> Option<Vec<DVec3>> {
    let role = particles.role(role)?;
    let vector = |row| {
        let vector = DVec3::new(role.get(row, 0), role.get(row, 1), role.get(row, 2)) * scale;
        vector.is_finite().then_some(vector)
    };
    (0..particles.len()).map(vector).collect()
}

/// Accelerations are of use beside velocities alone.
pub(super) fn usable(
    velocities: &Option<Vec<DVec3>>,
    accelerations: &Option<Vec<DVec3>>,
    index: usize,
) -> DVec3 {
    match (velocities, accelerations) {
        (Some(_), Some(accelerations)) => accelerations[index],
        _ => DVec3::ZERO,
    }
}

/// The median of velocity over displacement, where it is far from 1.
pub(super) fn disagreement(
    a: &Particles,
    b: &Particles,
    places: &[Place],
    velocities: &[Option<Vec<DVec3>>; 2],
) -> Option<f64> {
    let [Some(leaving), Some(arriving)] = velocities else {
        return None;
    };
    let mut ratios: Vec<f64> = places
        .iter()
        .filter_map(|place| {
            let Place::Both(i, j) = *place else {
                return None;
            };
            let moved = (b.positions[j] - a.positions[i]).length();
            let meant = 0.5 * (leaving[i] + arriving[j]).length();
            let ratio = meant / moved;
            (moved > 0.0 && ratio.is_finite()).then_some(ratio)
        })
        .collect();
    if ratios.is_empty() {
        return None;
    }
    let middle = ratios.len() / 2;
    let (_, median, _) = ratios.select_nth_unstable_by(middle, f64::total_cmp);
    let fits = (1.0 / MOST_DISAGREEMENT..=MOST_DISAGREEMENT).contains(median);
    (!fits && *median > 0.0).then_some(*median)
}
