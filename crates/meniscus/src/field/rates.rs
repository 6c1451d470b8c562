//! Velocities, accelerations and velocity gradients from columns.

use super::build::Build;
use super::{FieldError, MOST_TURN, Motion};
use crate::particles::{Attribute, Role};
use rayon::prelude::*;

/// Particles that one task handles at least.
const PARALLEL: usize = 1 << 14;

impl Build<'_> {
    /// How the particles that are left move while the shutter is open; `None` where it never is, the file
    /// has no rates, or all are 0. Rates that are not finite count as 0. Shapes turn where they have axes.
    pub(super) fn motion(
        &mut self,
        have_axes: bool,
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
        if open == close {
            return Ok(None);
        }
        let mut motion = Motion {
            velocities: self.rates(velocity, velocity_scale),
            half_accelerations: self.rates(acceleration, 0.5 * velocity_scale),
            velocity_gradients: Vec::new(),
            shutter: shutter_secs,
        };
        if have_axes {
            motion.velocity_gradients =
                self.velocity_gradients(velocity_scale, motion.longest_secs());
        }
        let moves = |rates: &[[f32; 3]]| rates.par_iter().any(|rate| *rate != [0.0; 3]);
        let is_moving =
            moves(&motion.velocities) || moves(&motion.half_accelerations) || motion.turns();
        Ok(is_moving.then_some(motion))
    }

    /// What shapes turn and stretch by, limited to what a shutter may hold; empty where it is nothing.
    fn velocity_gradients(&mut self, scale: f64, longest_secs: f64) -> Vec<[f32; 9]> {
        let gradient = self.particles.role(Role::VelocityGradient);
        let spin = self.particles.role(Role::AngularVelocity);
        let of_row = |row: usize| match (&gradient, &spin) {
            (Some(gradient), _) => [0, 1, 2, 3, 4, 5, 6, 7, 8].map(|k| gradient.get(row, k)),
            (None, Some(spin)) => {
                let [x, y, z] = [0, 1, 2].map(|k| spin.get(row, k));
                [0.0, -z, y, z, 0.0, -x, -y, x, 0.0]
            }
            (None, None) => [0.0; 9],
        };
        if gradient.is_none() && spin.is_none() {
            return Vec::new();
        }
        let (gradients, are_limited): (Vec<[f32; 9]>, Vec<bool>) = self
            .kept
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|&row| {
                let gradient = of_row(row as usize).map(|rate| rate * scale);
                let turn = gradient.iter().map(|rate| rate * rate).sum::<f64>().sqrt();
                let most = 0.999 * MOST_TURN / longest_secs;
                if !turn.is_finite() {
                    return ([0.0; 9], false);
                }
                let factor = (most / turn).min(1.0);
                (gradient.map(|rate| (rate * factor) as f32), factor < 1.0)
            })
            .unzip();
        let limited = are_limited.iter().filter(|&&is_limited| is_limited).count();
        if limited > 0 {
            self.notes.push(format!(
                "{limited} shapes turn or stretch by more than {MOST_TURN} (radians, or parts of their \
                 size) while the shutter is open before or after the frame's time: they were slowed down \
                 to that"
            ));
        }
        let turns = gradients.par_iter().any(|gradient| *gradient != [0.0; 9]);
        if turns { gradients } else { Vec::new() }
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
