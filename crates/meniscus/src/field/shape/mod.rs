//! Where the shapes of supports come from: which columns, and what they say.
//!
//! All forms say which ellipsoid the unit ball becomes. Those that state it outright (a metric, radii
//! along axes) are taken at their word; of those that follow from something else (a deformation
//! gradient, displacements of an atom) axes below a tenth of the longest are lengthened to it, because
//! a crushed element or an unsure refinement means no sheet.

mod ellipsoid;
pub(super) mod metric;

use super::build::{Build, in_range};
use super::supports::Supports;
use super::{FieldError, MetricOrder, SupportSource};
use crate::particles::{Particles, Role, Several};
use crate::scene::surface::{Anisotropy, BlobSettings};
use ellipsoid::{Ellipsoids, radius_of_probability};

/// Where shapes come from, before any is computed.
#[derive(Debug)]
pub(super) enum Form<'a> {
    /// Nowhere: balls.
    Ball,
    /// The metric.
    Metric(Several<'a>),
    /// Radii along axes.
    Radii(Radii<'a>),
    /// The deformation gradient, applied to the ball that the radius gives.
    Deformation(Several<'a>),
    /// Anisotropic displacements.
    Thermal(Several<'a>),
}

/// An ellipsoid by its radii.
#[derive(Debug)]
pub(super) struct Radii<'a> {
    /// Along the axes; `None`: their own lengths.
    radii: Option<Several<'a>>,
    axes: Axes<'a>,
}

/// The directions of an ellipsoid's axes.
#[derive(Debug)]
enum Axes<'a> {
    /// Those of space.
    Space,
    /// Three vectors.
    Vectors(Several<'a>),
    /// Those of space, turned by a quaternion.
    Turned(Several<'a>),
}

impl<'a> Form<'a> {
    /// The form that settings and columns call for.
    pub(super) fn choose(
        particles: &'a Particles,
        settings: &BlobSettings,
    ) -> Result<Self, FieldError> {
        settings.check_shape()?;
        let named = |role: Role, what: &'static str, names: &Option<String>, components| {
            let Some(names) = names else { return Ok(None) };
            let missing = |missing| FieldError::Missing { what, missing };
            let found = particles.several(role, names).map_err(missing)?;
            if found.components() == components || role == Role::Metric {
                return Ok(Some(found));
            }
            Err(FieldError::Components {
                what,
                name: names.clone(),
                found: found.components(),
                expected: match components {
                    3 => "three",
                    4 => "four",
                    _ => "nine",
                },
            })
        };
        let usual = |role: Role| particles.role(role).map(Several::from);
        let radii = named(Role::Radii, "radii", &settings.radii, 3)?;
        if let Some(metric) = named(Role::Metric, "metric", &settings.metric, 6)? {
            return Ok(Self::Metric(metric));
        }
        if let Some(vectors) = named(Role::Axes, "axes", &settings.axes, 9)? {
            return Ok(Self::Radii(Radii {
                radii: radii.or_else(|| usual(Role::Radii)),
                axes: Axes::Vectors(vectors),
            }));
        }
        if let Some(turn) = named(Role::Orientation, "orientation", &settings.orientation, 4)? {
            let radii = radii.or_else(|| usual(Role::Radii));
            return Ok(Self::Radii(Radii {
                radii: Some(radii.ok_or(FieldError::OrientationNeedsRadii)?),
                axes: Axes::Turned(turn),
            }));
        }
        let gradient = &settings.deformation;
        if let Some(gradient) = named(Role::Deformation, "deformation", gradient, 9)? {
            return Ok(Self::Deformation(gradient));
        }
        let axes = || {
            let vectors = usual(Role::Axes).map(Axes::Vectors);
            vectors.or_else(|| usual(Role::Orientation).map(Axes::Turned))
        };
        if let Some(radii) = radii {
            return Ok(Self::Radii(Radii {
                radii: Some(radii),
                axes: axes().unwrap_or(Axes::Space),
            }));
        }
        match settings.anisotropy {
            Anisotropy::None | Anisotropy::Estimate => Ok(Self::Ball),
            Anisotropy::Thermal => {
                let name = Some(Role::Displacements.name().to_owned());
                let found = named(Role::Displacements, "thermal ellipsoids", &name, 6)?;
                Ok(found.map_or(Self::Ball, Self::Thermal))
            }
            Anisotropy::Auto => {
                let has_size = settings.radius.is_some() || settings.support.is_some();
                let sized = || {
                    usual(Role::Metric).map(Self::Metric).or_else(|| {
                        let radii = usual(Role::Radii);
                        let axes = match (axes(), &radii) {
                            (Some(Axes::Turned(_)) | None, None) => return None,
                            (found, _) => found.unwrap_or(Axes::Space),
                        };
                        Some(Self::Radii(Radii { radii, axes }))
                    })
                };
                let found = if has_size { None } else { sized() };
                Ok(found
                    .or_else(|| usual(Role::Deformation).map(Self::Deformation))
                    .unwrap_or(Self::Ball))
            }
        }
    }

    /// What the report says of a form with a size.
    pub(super) fn source(&self, order: Option<MetricOrder>) -> Option<SupportSource> {
        let columns = match self {
            Self::Ball | Self::Deformation(_) => return None,
            Self::Metric(column) => {
                let column = column.name().to_owned();
                return order.map(|order| SupportSource::Metric { column, order });
            }
            Self::Thermal(column) => column.name().to_owned(),
            Self::Radii(Radii { radii, axes }) => {
                let axes = match axes {
                    Axes::Space => None,
                    Axes::Vectors(column) | Axes::Turned(column) => Some(column),
                };
                let names = radii.iter().chain(axes).map(Several::name);
                names.collect::<Vec<_>>().join(", ")
            }
        };
        Some(SupportSource::Ellipsoids(columns))
    }
}

impl BlobSettings {
    /// Whether the settings that decide on supports go together.
    fn check_shape(&self) -> Result<(), FieldError> {
        let is_thermal = self.anisotropy == Anisotropy::Thermal;
        let is_estimate = self.anisotropy == Anisotropy::Estimate;
        let given = [
            ("--metric", self.metric.is_some()),
            ("--axes", self.axes.is_some()),
            ("--orientation", self.orientation.is_some()),
            ("--radii", self.radii.is_some()),
            ("--deformation", self.deformation.is_some()),
            ("--anisotropy thermal", is_thermal),
            ("--anisotropy estimate", is_estimate),
            ("--radius", self.radius.is_some()),
            ("--support", self.support.is_some()),
        ];
        let together = [
            ("--axes", "--radii"),
            ("--orientation", "--radii"),
            ("--deformation", "--radius"),
            ("--deformation", "--support"),
            ("--anisotropy estimate", "--radius"),
            ("--anisotropy estimate", "--support"),
        ];
        let given: Vec<&str> = given.iter().filter(|g| g.1).map(|g| g.0).collect();
        for (i, &first) in given.iter().enumerate() {
            for &second in &given[i + 1..] {
                if !together.contains(&(first, second)) {
                    return Err(FieldError::Conflict { first, second });
                }
            }
        }
        if !(self.probability > 0.0 && self.probability < 1.0) {
            return Err(FieldError::Setting {
                name: "probability",
                value: self.probability,
                expected: "a number above 0 and below 1",
            });
        }
        Ok(())
    }
}

impl Build<'_> {
    /// The ellipsoids of `form`, without the particles that it makes none of; radii are multiplied by
    /// `scale`. A deformation gradient is kept for [`Build::stretched`].
    pub(super) fn shapes(
        &mut self,
        form: &Form<'_>,
        scale: f64,
        probability: f64,
    ) -> Result<Option<(Supports, Option<MetricOrder>)>, FieldError> {
        let (ellipsoids, order, reason, is_stretch) = match form {
            Form::Ball => return Ok(None),
            Form::Metric(column) => {
                let (factors, order) = metric::factors(column, &self.kept)?;
                let reason = "its metric is not positive definite".to_owned();
                (Ellipsoids::exact(factors), Some(order), reason, false)
            }
            Form::Radii(radii) => {
                let reason = "its axes, orientation or radii make no ellipsoid".to_owned();
                (radii.ellipsoids(&self.kept, scale), None, reason, false)
            }
            Form::Deformation(column) => (
                ellipsoid::deformed(column, &self.kept),
                None,
                format!(
                    "its deformation gradient in column {} is no use",
                    column.name()
                ),
                true,
            ),
            Form::Thermal(column) => (
                ellipsoid::thermal(
                    column,
                    &self.kept,
                    radius_of_probability(probability) * scale,
                ),
                None,
                format!("its displacements in column {} are no use", column.name()),
                false,
            ),
        };
        match form {
            // The report's source says it.
            Form::Ball | Form::Metric(_) => {}
            Form::Radii(_) | Form::Thermal(_) => {
                if let Some(SupportSource::Ellipsoids(columns)) = form.source(order) {
                    self.notes
                        .push(format!("ellipsoids from columns {columns}"));
                }
            }
            Form::Deformation(column) => self.notes.push(format!(
                "supports stretched by the deformation gradient in column {}; --anisotropy none \
                 leaves balls",
                column.name()
            )),
        }
        if let Some(first) = ellipsoids.lengthened.first() {
            self.notes.push(format!(
                "the shortest axes of {} ellipsoids were lengthened to a tenth of the longest, \
                 the first in row {}",
                ellipsoids.lengthened.len(),
                self.particles.rows[*first as usize]
            ));
        }
        let keep: Vec<bool> = ellipsoids.factors.iter().map(Option::is_some).collect();
        self.drop_unless(&keep, &reason)?;
        let factors = ellipsoids.factors.into_iter().flatten().collect();
        if is_stretch {
            self.stretch = Some(factors);
            return Ok(None);
        }
        Ok(Some((Supports::Ellipsoids(factors), order)))
    }

    /// The supports that the deformation gradients make of balls.
    pub(super) fn stretched(&mut self, supports: Supports) -> Supports {
        match (supports, self.stretch.take()) {
            (Supports::Balls(radii), Some(mut factors)) => {
                for (factor, radius) in factors.iter_mut().zip(&radii) {
                    *factor = factor.map(|a| a / radius);
                }
                Supports::Ellipsoids(factors)
            }
            (supports, _) => supports,
        }
    }
}

/// Whether f32 holds the factor of an ellipsoid well.
fn fits([a00, a01, a02, a11, a12, a22]: [f64; 6]) -> bool {
    let is_finite = [a01, a02, a12].iter().all(|a| (*a as f32).is_finite());
    is_finite && [a00, a11, a22].iter().all(|a| in_range(1.0 / a))
}

#[cfg(test)]
mod tests;
