//! Where light comes from: a closed list of emitters, one file each.
//!
//! Skies without detail are found by scattered rays alone: drawing directions from them as well
//! would only take the place of what surfaces draw better.

mod rectangle;
mod sky;
mod sphere;
mod sun;

pub(super) use rectangle::Rectangle;
pub use sky::Sky;
pub(super) use sphere::Sphere;
pub(super) use sun::Sun;

use crate::frame::environment::luminance;
use crate::frame::{Environment, Frame, Light};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Light that comes from a drawn direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LightSample {
    /// Unit vector towards the light.
    pub(super) towards: DVec3,
    /// How far it is; may be infinite.
    pub(super) distance: f64,
    /// Radiance over density: what a surface multiplies with its BSDF and cosine.
    pub(super) weight: Vec3,
    /// Density per solid angle; infinite for a light without size.
    pub(super) density: f64,
}

/// One light.
#[derive(Debug, Clone)]
pub(super) enum Emitter {
    /// A disk at infinity.
    Sun(Sun),
    /// A point: position and radiant intensity over π.
    Point(DVec3, Vec3),
    /// A ball.
    Sphere(Sphere),
    /// A parallelogram.
    Rectangle(Rectangle),
    /// A gradient all around.
    Sky(Sky),
    /// The same from everywhere.
    Constant(Vec3),
    /// An image and its scale.
    Environment(Arc<Environment>, Vec3),
}

impl Emitter {
    fn new(light: &Light) -> Self {
        let color = |radiance: &[f32; 3]| Vec3::from_array(*radiance);
        match light {
            Light::Sun {
                towards,
                radiance,
                half_angle,
            } => Self::Sun(Sun::new(*towards, color(radiance), *half_angle)),
            Light::Sky { radiance } => Self::Sky(Sky::new(*radiance)),
            Light::Constant { radiance } => Self::Constant(color(radiance)),
            Light::Point { position, radiance } => Self::Point(*position, color(radiance)),
            Light::Sphere {
                center,
                radius,
                radiance,
            } => Self::Sphere(Sphere::new(*center, *radius, color(radiance))),
            Light::Rectangle {
                center,
                edges,
                radiance,
            } => Self::Rectangle(Rectangle::new(*center, *edges, color(radiance))),
            Light::Environment { environment, scale } => {
                Self::Environment(environment.clone(), color(scale))
            }
        }
    }

    /// Roughly the light that a white surface at `point` gets if nothing is in the way: how much a
    /// light deserves to be drawn. 0 for those that are not drawn at all.
    fn importance(&self, point: DVec3) -> f64 {
        match self {
            Self::Sun(sun) => luminance(sun.irradiance()),
            Self::Point(position, radiance) => {
                luminance(*radiance) / point.distance_squared(*position).max(f64::MIN_POSITIVE)
            }
            Self::Sphere(sphere) => luminance(sphere.irradiance(point)),
            Self::Rectangle(rectangle) => luminance(rectangle.irradiance(point)),
            Self::Environment(environment, scale) => luminance(environment.mean() * *scale),
            Self::Sky(_) | Self::Constant(_) => 0.0,
        }
    }

    /// Draws a direction from `point` towards the light.
    fn sample(&self, point: DVec3, u: [f64; 2]) -> Option<LightSample> {
        match self {
            Self::Sun(sun) => Some(sun.sample(u)),
            Self::Point(..) => self.hard(point),
            Self::Sphere(sphere) => sphere.sample(point, u),
            Self::Rectangle(rectangle) => rectangle.sample(point, u),
            Self::Environment(environment, scale) => {
                let (towards, density) = environment.sample(u)?;
                Some(LightSample {
                    towards,
                    distance: f64::INFINITY,
                    weight: environment.radiance(towards) * *scale / density as f32,
                    density,
                })
            }
            Self::Sky(_) | Self::Constant(_) => None,
        }
    }

    /// Density with which [`Emitter::sample`] draws a direction that meets the light.
    fn density(&self, point: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Sun(sun) => sun.density(),
            Self::Sphere(sphere) => sphere.density(point),
            Self::Rectangle(rectangle) => rectangle.density(point, direction),
            Self::Environment(environment, _) => environment.density(direction),
            Self::Point(..) | Self::Sky(_) | Self::Constant(_) => 0.0,
        }
    }

    /// The light as a single direction, for hard shadows; `None` for what surrounds everything.
    fn hard(&self, point: DVec3) -> Option<LightSample> {
        let at = |position: DVec3, irradiance: Vec3| {
            let (towards, distance) = (position - point).normalize_and_length();
            (distance > 0.0).then_some(LightSample {
                towards,
                distance,
                weight: irradiance * PI as f32,
                density: f64::INFINITY,
            })
        };
        match self {
            Self::Sun(sun) => Some(sun.middle()),
            Self::Point(position, radiance) => {
                let falloff = point.distance_squared(*position).max(f64::MIN_POSITIVE);
                at(*position, *radiance / falloff as f32)
            }
            Self::Sphere(sphere) => at(sphere.center, sphere.irradiance(point)),
            Self::Rectangle(rectangle) => at(rectangle.center, rectangle.irradiance(point)),
            Self::Sky(_) | Self::Constant(_) | Self::Environment(..) => None,
        }
    }

    /// Radiance that a ray sees which leaves everything behind.
    fn escaped(&self, direction: DVec3, up: DVec3) -> Vec3 {
        match self {
            Self::Sun(sun) => sun.radiance(direction),
            Self::Sky(sky) => sky.radiance(direction.dot(up) as f32),
            Self::Constant(radiance) => *radiance,
            Self::Environment(environment, scale) => environment.radiance(direction) * *scale,
            Self::Point(..) | Self::Sphere(_) | Self::Rectangle(_) => Vec3::ZERO,
        }
    }

    /// Where a ray with unit direction meets the light before `t_max`, and the radiance it sees.
    fn met(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, Vec3)> {
        match self {
            Self::Sphere(sphere) => sphere.met(origin, direction, t_max),
            Self::Rectangle(rectangle) => rectangle.met(origin, direction, t_max),
            _ => None,
        }
    }

    /// Whether directions are drawn towards it; the others are found by scattered rays alone.
    fn is_drawn(&self) -> bool {
        !matches!(self, Self::Sky(_) | Self::Constant(_))
    }

    /// Whether it stands all around the scene.
    fn surrounds(&self) -> bool {
        matches!(
            self,
            Self::Sky(_) | Self::Constant(_) | Self::Environment(..)
        )
    }
}

/// All lights of a frame.
#[derive(Debug)]
pub(super) struct Lights {
    pub(super) emitters: Vec<Emitter>,
    up: DVec3,
}

/// Light that a scattered ray found, by emitter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    /// Index of the emitter.
    pub(super) emitter: usize,
    /// What the ray sees of it.
    pub(super) radiance: Vec3,
}

impl Lights {
    pub(super) fn new(frame: &Frame) -> Self {
        Self {
            emitters: frame.lights.iter().map(Emitter::new).collect(),
            up: frame.up,
        }
    }

    /// Draws one light and a direction towards it, with `choice` among the lights. The answer counts
    /// for all lights, its density includes the choice.
    pub(super) fn sample(
        &self,
        point: DVec3,
        choice: f64,
        u: [f64; 2],
    ) -> Option<(usize, LightSample)> {
        let total = self.total_importance(point);
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut rest = choice * total;
        let mut drawn = None;
        for (index, emitter) in self.emitters.iter().enumerate() {
            let importance = emitter.importance(point);
            if importance > 0.0 {
                drawn = Some((index, importance / total));
                if rest < importance {
                    break;
                }
                rest -= importance;
            }
        }
        let (index, part) = drawn?;
        let sample = self.emitters[index].sample(point, u)?;
        Some((
            index,
            LightSample {
                weight: sample.weight / part as f32,
                density: sample.density * part,
                ..sample
            },
        ))
    }

    fn total_importance(&self, point: DVec3) -> f64 {
        self.emitters
            .iter()
            .map(|emitter| emitter.importance(point))
            .sum()
    }

    /// Density with which [`Lights::sample`] draws a direction that finds `emitter`.
    pub(super) fn density(&self, emitter: usize, point: DVec3, direction: DVec3) -> f64 {
        let total = self.total_importance(point);
        if !(total > 0.0 && total.is_finite()) {
            return 0.0;
        }
        let light = &self.emitters[emitter];
        light.importance(point) / total * light.density(point, direction)
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.emitters.len()
    }

    /// Light `index` as a single direction, for hard shadows; `None` for what surrounds everything.
    pub(super) fn hard_of(&self, index: usize, point: DVec3) -> Option<LightSample> {
        self.emitters.get(index)?.hard(point)
    }

    /// The lights as single directions, for hard shadows, with their indices.
    pub(super) fn hard(&self, point: DVec3) -> impl Iterator<Item = (usize, LightSample)> {
        let emitters = self.emitters.iter().enumerate();
        emitters.filter_map(move |(index, emitter)| Some((index, emitter.hard(point)?)))
    }

    /// What a ray sees that leaves everything behind, light by light.
    pub(super) fn escaped(&self, direction: DVec3) -> impl Iterator<Item = Found> {
        self.emitters
            .iter()
            .enumerate()
            .map(move |(index, emitter)| Found {
                emitter: index,
                radiance: emitter.escaped(direction, self.up),
            })
            .filter(|found| found.radiance != Vec3::ZERO)
    }

    /// The radiance from a direction of all that surrounds the scene but suns.
    pub(super) fn surroundings(&self, direction: DVec3) -> Vec3 {
        self.emitters
            .iter()
            .filter(|emitter| emitter.surrounds())
            .map(|emitter| emitter.escaped(direction, self.up))
            .sum()
    }

    /// Whether anything surrounds the scene.
    pub(super) fn has_surroundings(&self) -> bool {
        self.emitters.iter().any(Emitter::surrounds)
    }

    /// The nearest light that a ray with unit direction meets before `t_max`.
    pub(super) fn met(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Option<(f64, Found)> {
        let mut nearest: Option<(f64, Found)> = None;
        for (emitter, light) in self.emitters.iter().enumerate() {
            let limit = nearest.map_or(t_max, |(t, _)| t);
            if let Some((t, radiance)) = light.met(origin, direction, limit) {
                nearest = Some((t, Found { emitter, radiance }));
            }
        }
        nearest
    }

    /// Whether directions are drawn towards an emitter, so that caustics of it can be left out.
    pub(super) fn is_drawn(&self, emitter: usize) -> bool {
        self.emitters[emitter].is_drawn()
    }
}

#[cfg(test)]
mod tests;
