//! From particles and settings to a packed field.

use super::anisotropy::{Estimate, estimate};
use super::shape::Form;
use super::supports::{Rule, Supports, positive, retain};
use super::weights::volume_weights;
use super::{BlobField, FieldError, FieldReport, SupportSource};
use crate::particles::Particles;
use crate::particles::elements::van_der_waals_radius;
use crate::particles::filter::Filter;
use crate::particles::spacing::{median_spacing_in, point_tree, typical_spacing_in};
use crate::scene::surface::{Anisotropy, BlobSettings, Weights};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// Positions, supports and weights beyond this are dropped: f32 has to hold their squares. Supports and
/// the sizes of weights must also be at least its inverse.
pub const LARGEST_COORDINATE: f64 = 1e18;

/// Supports that differ by no more than this factor keep the particles' own tree.
const SIMILAR_SUPPORTS: f64 = 4.0;

/// Particles that one task handles at least.
pub(super) const PARALLEL: usize = 1 << 14;

/// A field and what a user should know about it.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldBuild {
    /// The field.
    pub field: BlobField,
    /// What happened to the particles.
    pub report: FieldReport,
}

/// Particles removed for one reason.
pub(super) struct Dropped {
    pub(super) count: usize,
    first_row: u32,
    reason: String,
}

impl Dropped {
    pub(super) fn sentence(&self) -> String {
        let Self {
            count,
            first_row,
            reason,
        } = self;
        if *count == 1 {
            format!("dropped 1 particle ({reason}): row {first_row}")
        } else {
            format!("dropped {count} particles ({reason}), the first in row {first_row}")
        }
    }
}

/// The particles that are left while the field is being built: indices into the particles given, and
/// their weights once they are known.
pub(super) struct Build<'a> {
    pub(super) particles: &'a Particles,
    pub(super) kept: Vec<u32>,
    pub(super) filtered: usize,
    pub(super) dropped: Vec<Dropped>,
    pub(super) weights: Option<Vec<f64>>,
    /// Factors for a support radius of 1 that stretch the supports, where the file says so.
    pub(super) stretch: Option<Vec<[f64; 6]>>,
    /// What else a user should know, a sentence each.
    pub(super) notes: Vec<String>,
    /// Where they count as standing instead, once that is known.
    pub(super) moved: Option<Vec<DVec3>>,
}

impl BlobField {
    /// The field of `particles` under `settings`: filter first, then everything else.
    ///
    /// Positions are taken relative to an f64 origin near the middle of the particles and packed in
    /// f32: a cloud keeps 24 bits of its own size wherever it lies, so one at coordinates around 10⁶
    /// needs a spacing above 10⁻⁷ of its extent, not of its coordinates. The report warns when that is
    /// not so.
    ///
    /// # Errors
    /// When settings are out of range or contradict each other, a column is missing, or no particle is
    /// left.
    pub fn from_particles(
        particles: &Particles,
        settings: &BlobSettings,
    ) -> Result<FieldBuild, FieldError> {
        Self::from_moving_particles(particles, settings, [0.0; 2], 1.0)
    }

    /// A field without blobs that carries the attributes which `settings` want of such particles: what a
    /// frame shows of which [`FieldError::Empty`] leaves nothing.
    ///
    /// # Errors
    /// When an attribute is missing.
    pub fn without_blobs(
        particles: &Particles,
        settings: &BlobSettings,
    ) -> Result<FieldBuild, FieldError> {
        let none = Supports::Balls(Vec::new());
        let build = Build {
            filtered: particles.len(),
            ..Build::of(particles, Vec::new())
        };
        // No tolerance is asked of it, but each is to be a number.
        let mut built = build.pack(settings, none, SupportSource::Support, Some(1.0))?;
        built.report.spacing = None;
        Ok(built)
    }

    /// [`BlobField::from_particles`] of particles that move while the shutter is open, from and until
    /// these seconds relative to the frame, as their velocities and accelerations say, which are
    /// multiplied by `velocity_scale`.
    ///
    /// # Errors
    /// As there.
    pub fn from_moving_particles(
        particles: &Particles,
        settings: &BlobSettings,
        shutter_secs: [f64; 2],
        velocity_scale: f64,
    ) -> Result<FieldBuild, FieldError> {
        positive("threshold", settings.threshold)?;
        let form = Form::choose(particles, settings)?;
        let rule = Rule::choose(particles, settings)?;
        let scale = match (&form, &rule) {
            (Form::Metric(_), _) | (_, Rule::Support(_)) => 1.0,
            _ => Rule::support_per_radius(settings)?,
        };
        let mut build = Build::filtered(particles, settings)?;
        build.drop_positions()?;
        build.drop_absent()?;
        build.column_weights(&settings.weights)?;
        let shapes = build.shapes(&form, scale, settings.probability)?;
        let own = match shapes {
            Some(shapes) => Some(shapes),
            None => build.own_supports(&rule, scale)?.map(|own| (own, None)),
        };
        let positions = build.positions();
        let points = point_tree(&positions);
        let spacing = if own.is_none() && matches!(rule, Rule::Estimate) {
            median_spacing_in(&points, &positions)
        } else {
            // No more than a scale for tolerances.
            typical_spacing_in(&points, &positions)
        };
        let (supports, order) = match own {
            Some((supports, order)) => (supports, order),
            None => (
                common_support(&rule, scale, spacing, positions.len())?,
                None,
            ),
        };
        let mut supports = build.stretched(supports);
        let scales = build.support_scales();
        let volumes = |positions: &[DVec3], supports: &Supports| {
            volume_weights(
                positions,
                supports,
                scales.as_deref(),
                settings.kernel,
                &points,
            )
        };
        let is_estimated = settings.anisotropy == Anisotropy::Estimate;
        let mut weights = None;
        if is_estimated && let Supports::Balls(radii) = &supports {
            let Estimate { centers, factors } = estimate(&positions, radii, &points);
            let ellipsoids = Supports::Ellipsoids(factors);
            if settings.weights == Weights::BallVolume {
                let mut of_balls = volumes(&positions, &supports);
                for (i, weight) in of_balls.iter_mut().enumerate() {
                    *weight *= ellipsoids.determinant(i) / supports.determinant(i);
                }
                weights = Some(of_balls);
            } else if settings.weights == Weights::Volume {
                weights = Some(volumes(&centers, &ellipsoids));
            }
            build.moved = Some(centers);
            supports = ellipsoids;
        } else if settings.weights.are_volumes() {
            weights = Some(volumes(&positions, &supports));
        }
        if let Some(weights) = weights {
            build.weights = Some(weights);
            let keep = build.drop_weights("its volume is beyond all others'")?;
            supports.retain(&keep);
        }
        if let Some(scales) = build.support_scales() {
            supports.scale(&scales);
        }
        let (least, largest) = supports.range();
        let are_similar = largest <= SIMILAR_SUPPORTS * least && supports.len() == positions.len();
        let have_axes = matches!(supports, Supports::Ellipsoids(_));
        let motion = build.motion(have_axes, shutter_secs, velocity_scale)?;
        let source = form.source(order).unwrap_or_else(|| rule.source());
        let mut built = build.pack(settings, supports, source, spacing)?;
        built.field.motion = motion;
        if are_similar {
            built.field.adopt_tree(&points);
        }
        Ok(built)
    }
}

impl<'a> Build<'a> {
    fn filtered(particles: &'a Particles, settings: &BlobSettings) -> Result<Self, FieldError> {
        let all = 0..particles.len() as u32;
        let kept: Vec<u32> = match &settings.filter {
            None => all.collect(),
            Some(filter) => {
                let keep = Filter::parse(filter)?.keep(particles)?;
                all.filter(|&i| keep[i as usize]).collect()
            }
        };
        Ok(Self {
            filtered: particles.len() - kept.len(),
            ..Self::of(particles, kept)
        })
    }

    /// Nothing is known yet but who is kept.
    fn of(particles: &'a Particles, kept: Vec<u32>) -> Self {
        Self {
            particles,
            kept,
            filtered: 0,
            dropped: Vec::new(),
            weights: None,
            stretch: None,
            notes: Vec::new(),
            moved: None,
        }
    }

    /// Where the particles that are left stand.
    pub(super) fn positions(&self) -> Cow<'a, [DVec3]> {
        let positions = &self.particles.positions;
        if self.kept.len() == positions.len() {
            return Cow::Borrowed(positions);
        }
        Cow::Owned(self.kept.iter().map(|&i| positions[i as usize]).collect())
    }

    /// Where the particles that are left count as standing.
    pub(super) fn places(&self) -> Cow<'_, [DVec3]> {
        match &self.moved {
            Some(moved) => Cow::Borrowed(moved),
            None => self.positions(),
        }
    }

    /// Removes the particles for which `keep` is false; an error when none is left.
    pub(super) fn drop_unless(&mut self, keep: &[bool], reason: &str) -> Result<(), FieldError> {
        if let Some(first) = keep.iter().position(|&keep| !keep) {
            self.dropped.push(Dropped {
                count: keep.iter().filter(|&&keep| !keep).count(),
                first_row: self.particles.rows[self.kept[first] as usize],
                reason: reason.to_owned(),
            });
            retain(&mut self.kept, keep);
            if let Some(weights) = &mut self.weights {
                retain(weights, keep);
            }
            if let Some(stretch) = &mut self.stretch {
                retain(stretch, keep);
            }
            if let Some(moved) = &mut self.moved {
                retain(moved, keep);
            }
        }
        if !self.kept.is_empty() {
            return Ok(());
        }
        let mut reasons = Vec::new();
        if self.filtered > 0 {
            reasons.push(format!("the filter removed {}", self.filtered));
        }
        reasons.extend(self.dropped.iter().map(Dropped::sentence));
        Err(FieldError::Empty {
            total: self.particles.len(),
            reasons,
        })
    }

    fn drop_positions(&mut self) -> Result<(), FieldError> {
        let keep: Vec<bool> = self
            .positions()
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|p| p.abs().max_element() <= LARGEST_COORDINATE && p.is_finite())
            .collect();
        self.drop_unless(&keep, "its position is not finite")
    }

    fn column_weights(&mut self, weights: &Weights) -> Result<(), FieldError> {
        let Weights::Column(name) = weights else {
            return Ok(());
        };
        let what = "weights";
        let missing = |missing| FieldError::Missing { what, missing };
        let column = self.particles.attribute(name).map_err(missing)?;
        if column.components() != 1 {
            return Err(FieldError::Components {
                what,
                name: name.clone(),
                found: column.components(),
                expected: "one (write name.x or |name|)",
            });
        }
        let values = self.kept.iter().map(|&i| column.get(i as usize, 0));
        self.weights = Some(values.collect());
        self.drop_weights(&format!(
            "its weight in column {name} is zero or not finite"
        ))?;
        Ok(())
    }

    /// Removes what has no usable weight and says who stayed.
    fn drop_weights(&mut self, reason: &str) -> Result<Vec<bool>, FieldError> {
        let weights = self.weights.iter().flatten();
        let keep: Vec<bool> = weights.map(|weight| in_range(weight.abs())).collect();
        self.drop_unless(&keep, reason)?;
        Ok(keep)
    }

    /// Supports from a column, without the particles that it is no use for; `None` when all have the
    /// same.
    fn own_supports(
        &mut self,
        rule: &Rule<'_>,
        scale: f64,
    ) -> Result<Option<Supports>, FieldError> {
        match rule {
            Rule::Column(column) => {
                let radii = self.kept.iter().map(|&i| column.get(i as usize, 0) * scale);
                let mut supports: Vec<f64> = radii.collect();
                let keep: Vec<bool> = supports.iter().map(|&r| in_range(r)).collect();
                self.drop_unless(&keep, "its radius is not a positive number")?;
                retain(&mut supports, &keep);
                Ok(Some(Supports::Balls(supports)))
            }
            Rule::Elements(numbers) => {
                let radius = |&i: &u32| atom_radius(numbers.get(i as usize, 0)) * scale;
                let supports = self.kept.iter().map(radius).collect();
                Ok(Some(Supports::Balls(supports)))
            }
            Rule::Support(_) | Rule::Radius(_) | Rule::Estimate => Ok(None),
        }
    }
}

/// The one support of all `count` particles.
fn common_support(
    rule: &Rule<'_>,
    scale: f64,
    spacing: Option<f64>,
    count: usize,
) -> Result<Supports, FieldError> {
    let (name, radius) = match rule {
        Rule::Support(support) => ("support", *support),
        Rule::Radius(radius) => ("radius", *radius),
        Rule::Estimate | Rule::Column(_) | Rule::Elements(_) => {
            ("radius", 0.5 * spacing.ok_or(FieldError::NoRadius)?)
        }
    };
    if !in_range(radius * scale) {
        return Err(FieldError::Setting {
            name,
            value: radius,
            expected: "a support between 1e-18 and 1e18",
        });
    }
    Ok(Supports::Balls(vec![radius * scale; count]))
}

/// Van der Waals radius of an atomic number as a column holds it, in ångström.
fn atom_radius(number: f64) -> f64 {
    van_der_waals_radius(atomic_number_of(number))
}

/// The atomic number that a column's value stands for; 0 for what is none.
pub(super) fn atomic_number_of(value: f64) -> u8 {
    if value.fract() == 0.0 { value as u8 } else { 0 }
}

/// Whether f32 holds `size` and its square's inverse well.
pub(super) fn in_range(size: f64) -> bool {
    (1.0 / LARGEST_COORDINATE..=LARGEST_COORDINATE).contains(&size)
}
