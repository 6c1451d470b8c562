//! Particles that come or go: [`Role::SupportScale`] shrinks their supports, and in volume weights
//! they count as much as their volume does.

use super::FieldError;
use super::build::Build;
use super::supports::Supports;
use crate::particles::Role;

impl Build<'_> {
    /// Drops particles whose support scale is no positive number.
    pub(super) fn drop_absent(&mut self) -> Result<(), FieldError> {
        let Some(scales) = self.support_scales() else {
            return Ok(());
        };
        let keep: Vec<bool> = scales.iter().map(|&s| s > 0.0 && s.is_finite()).collect();
        self.drop_unless(&keep, "its support_scale is not a positive number")
    }

    /// The support scales of the particles that are left; `None` where nothing says any.
    pub(super) fn support_scales(&self) -> Option<Vec<f64>> {
        let scales = self.particles.role(Role::SupportScale)?;
        Some(
            self.kept
                .iter()
                .map(|&i| scales.get(i as usize, 0))
                .collect(),
        )
    }
}

impl Supports {
    /// Shrinks each support.
    pub(super) fn scale(&mut self, scales: &[f64]) {
        match self {
            Self::Balls(radii) => radii.iter_mut().zip(scales).for_each(|(r, s)| *r *= s),
            Self::Ellipsoids(factors) => {
                for (factor, scale) in factors.iter_mut().zip(scales) {
                    *factor = factor.map(|a| a / scale);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::field::BlobField;
    use crate::particles::{Column, Particles};
    use crate::scene::{BlobSettings, Weights};
    use glam::DVec3;

    /// A block of particles, the first of which has this much of its support.
    fn field(scale: Option<f32>, weights: Weights) -> BlobField {
        let positions =
            (0..4 * 4 * 4).map(|i| DVec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64));
        let mut positions: Vec<DVec3> = positions.collect();
        // Beside another one, where a small support of full weight would count most.
        positions.insert(0, DVec3::new(1.1, 1.0, 2.0));
        if scale.is_none() {
            positions.remove(0);
        }
        let mut particles = Particles::from_positions(positions);
        if let Some(scale) = scale {
            let mut scales = vec![1.0; particles.len()];
            scales[0] = scale;
            particles
                .columns
                .push(Column::new("support_scale", 1, scales));
        }
        let settings = BlobSettings {
            radius: Some(0.5),
            weights,
            threshold: 0.6,
            ..BlobSettings::default()
        };
        BlobField::from_particles(&particles, &settings)
            .unwrap()
            .field
    }

    fn values(field: &BlobField) -> Vec<f64> {
        let at = |i: u32| {
            let [x, y, z] = [i % 7, i / 7 % 7, i / 49].map(|c| 0.61 * f64::from(c) - 0.3);
            field.value(DVec3::new(x, y, z) - field.origin)
        };
        (0..343).map(at).collect()
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_field_goes_over_from_without_to_with_a_particle() {
        for weights in [Weights::Volume, Weights::Unit] {
            let without = values(&field(None, weights.clone()));
            let with = values(&field(Some(1.0), weights.clone()));
            let whole = largest_difference(&without, &with);
            assert!(whole > 0.02, "{weights:?}: {whole}");
            let almost_gone = values(&field(Some(0.02), weights.clone()));
            assert!(
                largest_difference(&without, &almost_gone) < 1e-3,
                "{weights:?}"
            );
            let mut before = without;
            for step in 1..=50 {
                let now = values(&field(Some(0.02 * step as f32), weights.clone()));
                let jump = largest_difference(&before, &now);
                assert!(
                    jump < 0.12 * whole.max(0.3),
                    "{weights:?} step {step}: {jump}"
                );
                before = now;
            }
            assert!(largest_difference(&before, &with) < 1e-6);
        }
    }

    #[test]
    fn a_lone_particle_shrinks_to_nothing() {
        for weights in [Weights::Volume, Weights::Unit] {
            for scale in [1.0, 0.5, 0.1] {
                let mut particles = Particles::from_positions(vec![DVec3::ZERO]);
                particles
                    .columns
                    .push(Column::new("support_scale", 1, vec![scale]));
                let settings = BlobSettings {
                    support: Some(2.0),
                    weights: weights.clone(),
                    ..BlobSettings::default()
                };
                let field = BlobField::from_particles(&particles, &settings)
                    .unwrap()
                    .field;
                assert_eq!(field.weights, [1.0]);
                let half = field.shapes.half_extents(0)[0];
                assert!((half - 2.0 * scale).abs() < 1e-5);
            }
        }
    }
}
