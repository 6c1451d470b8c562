//! Velocities and accelerations from columns.

use super::build::Build;
use super::{FieldError, Motion};
use crate::particles::{Attribute, Role};
use rayon::prelude::*;

/// Particles that one task handles at least.
const PARALLEL: usize = 1 << 14;

impl Build<'_> {
    /// How the particles that are left move while the shutter is open; `None` where it never is, the file
    /// has no velocities, or all are 0. Rates that are not finite count as 0.
    pub(super) fn motion(
        &self,
        shutter_secs: [f64; 2],
        velocity_scale: f64,
    ) -> Result<Option<Motion>, FieldError> {
        let [open, close] = shutter_secs;
        if !(open <= close && open.is_finite() && close.is_finite()) {
            return Err(FieldError::Setting {
                name: "shutter",
                value: close - open,
                expected: "a finite time between opening and closing",
            });
        }
        let velocity = self.particles.role(Role::Velocity);
        let acceleration = self.particles.role(Role::Acceleration);
        if open == close || (velocity.is_none() && acceleration.is_none()) {
            return Ok(None);
        }
        let motion = Motion {
            velocities: self.rates(velocity, velocity_scale),
            half_accelerations: self.rates(acceleration, 0.5 * velocity_scale),
            shutter: shutter_secs,
        };
        let moves = |rates: &[[f32; 3]]| rates.par_iter().any(|rate| *rate != [0.0; 3]);
        Ok((moves(&motion.velocities) || moves(&motion.half_accelerations)).then_some(motion))
    }

    fn rates(&self, column: Option<Attribute<'_>>, scale: f64) -> Vec<[f32; 3]> {
        let Some(column) = column else {
            return vec![[0.0; 3]; self.kept.len()];
        };
        self.kept
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|&row| {
                let rate = [0, 1, 2].map(|k| (column.get(row as usize, k) * scale) as f32);
                if rate.iter().all(|r| r.is_finite()) {
                    rate
                } else {
                    [0.0; 3]
                }
            })
            .collect()
    }
}
