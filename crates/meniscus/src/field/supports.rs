//! How far each particle reaches: the support rule.

use super::build::PARALLEL;
use super::{FieldError, SupportSource};
use crate::math::aabb::DAabb;
use crate::particles::{Particles, Role};
use crate::primitive::{Ellipsoid, Shapes};
use crate::scene::surface::BlobSettings;
use glam::DVec3;
use rayon::prelude::*;

/// Supports in float64, one per particle.
#[derive(Debug, Clone)]
pub(super) enum Supports {
    /// Radii R.
    Balls(Vec<f64>),
    /// Upper-triangular factors A.
    Ellipsoids(Vec<[f64; 6]>),
}

impl Supports {
    /// det A of particle `i`, in 1/length³.
    pub(super) fn determinant(&self, i: usize) -> f64 {
        match self {
            Self::Balls(radii) => radii[i].powi(-3),
            Self::Ellipsoids(factors) => factors[i][0] * factors[i][3] * factors[i][5],
        }
    }

    /// The box around the support of particle `i` at `position`.
    pub(super) fn bounds(&self, i: usize, position: DVec3) -> DAabb {
        let half = match self {
            Self::Balls(radii) => DVec3::splat(radii[i]),
            Self::Ellipsoids(factors) => {
                let half = Ellipsoid(factors[i].map(|a| a as f32)).half_extents();
                DVec3::from_array(half.map(f64::from))
            }
        };
        DAabb {
            min: position - half,
            max: position + half,
        }
    }

    /// Smallest and largest radius; of ellipsoids that of the ball of the same volume.
    pub(super) fn range(&self) -> (f64, f64) {
        // Roots of the ends alone: 1/∛ of a million determinants take as long as a tree over them.
        let size = |i: usize| match self {
            Self::Balls(radii) => radii[i],
            Self::Ellipsoids(_) => self.determinant(i),
        };
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        let (least, most) = (0..self.len())
            .into_par_iter()
            .with_min_len(PARALLEL)
            .map(|i| (size(i), size(i)))
            .reduce(|| (f64::INFINITY, 0.0), wider);
        match self {
            Self::Balls(_) => (least, most),
            Self::Ellipsoids(_) => (most.powf(-1.0 / 3.0), least.powf(-1.0 / 3.0)),
        }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Balls(radii) => radii.len(),
            Self::Ellipsoids(factors) => factors.len(),
        }
    }

    /// Packed in f32.
    pub(super) fn packed(&self) -> Shapes {
        match self {
            Self::Balls(radii) => Shapes::Balls(radii.iter().map(|&r| r as f32).collect()),
            Self::Ellipsoids(factors) => Shapes::Ellipsoids(
                factors
                    .iter()
                    .map(|factor| Ellipsoid(factor.map(|a| a as f32)))
                    .collect(),
            ),
        }
    }

    /// Keeps the particles for which `keep` is true.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        match self {
            Self::Balls(radii) => retain(radii, keep),
            Self::Ellipsoids(factors) => retain(factors, keep),
        }
    }
}

/// Keeps the entries for which `keep` is true.
pub(super) fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    values.retain(|_| *kept.next().unwrap_or(&false));
}

/// Where supports come from, before any is computed.
#[derive(Debug)]
pub(super) enum Rule<'a> {
    /// One R for all.
    Support(f64),
    /// One radius for all.
    Radius(f64),
    /// A column of radii.
    Column(crate::particles::Attribute<'a>),
    /// Atomic numbers, whose van der Waals radii in ångström are taken.
    Elements(crate::particles::Attribute<'a>),
    /// Half the spacing for all.
    Estimate,
}

impl<'a> Rule<'a> {
    /// The rule that settings and columns call for.
    pub(super) fn choose(
        particles: &'a Particles,
        settings: &BlobSettings,
    ) -> Result<Self, FieldError> {
        if let Some(support) = settings.support {
            return positive("support", support).map(Self::Support);
        }
        if let Some(radius) = settings.radius {
            return positive("radius", radius).map(Self::Radius);
        }
        // Where weights are not volumes a radius is the surface of a lone particle, which is what a
        // van der Waals radius means.
        let elements = || {
            let has_atoms = !settings.weights.are_volumes();
            let numbers = particles.attribute("atomic_number").ok();
            numbers.filter(|numbers| has_atoms && numbers.components() == 1)
        };
        Ok(particles
            .role(Role::Radius)
            .map(Self::Column)
            .or_else(|| elements().map(Self::Elements))
            .unwrap_or(Self::Estimate))
    }

    /// R over the radius.
    pub(super) fn support_per_radius(settings: &BlobSettings) -> Result<f64, FieldError> {
        if settings.weights.are_volumes() {
            return positive("smoothing", settings.smoothing);
        }
        let q = settings.kernel.q_at(settings.threshold);
        q.map(|q| 1.0 / q.sqrt())
            .ok_or_else(|| FieldError::ThresholdNeedsSupport {
                threshold: settings.threshold,
                weights: settings.weights.name().to_owned(),
            })
    }

    /// What the report says.
    pub(super) fn source(&self) -> SupportSource {
        match self {
            Self::Support(_) => SupportSource::Support,
            Self::Radius(_) => SupportSource::Radius,
            Self::Elements(_) => SupportSource::Elements,
            Self::Estimate => SupportSource::Estimate,
            Self::Column(column) => SupportSource::Column(column.name().to_owned()),
        }
    }
}

/// `value` when it is finite and above 0.
pub(super) fn positive(name: &'static str, value: f64) -> Result<f64, FieldError> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(FieldError::Setting {
        name,
        value,
        expected: "a positive number",
    })
}
