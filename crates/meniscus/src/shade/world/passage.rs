//! What is left of light on its way: absorption in media, and clear surfaces crossed in a straight line.

use super::contact::{Contact, viewed_normal};
use super::{World, passed};
use crate::intersect::Hit;
use crate::math::ray::Ray;
use crate::shade::asking::Ask;
use crate::shade::bsdf::{Sheet, dielectric_reflectance};
use crate::shade::medium::MediumStack;
use crate::shade::rays::ShadeScratch;
use glam::{DVec3, Vec3};

/// Points along a way through a medium at which its absorption is looked at where it varies.
const ABSORPTION_STEPS: u32 = 8;
/// Clear surfaces that a ray crosses in a straight line before it counts as stopped.
const MAX_CROSSINGS: u32 = 64;

/// The part of a light that reaches a point, and whether it went through clear surfaces.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Reach {
    /// What is left of it.
    pub(in crate::shade) part: Vec3,
    /// Whether something clear was in between.
    pub(in crate::shade) went_through: bool,
}

impl Reach {
    const NOTHING: Self = Self {
        part: Vec3::ZERO,
        went_through: false,
    };
}

impl World<'_> {
    /// The thin sheet that a ray in `media` meets.
    pub(super) fn sheet(
        &self,
        ray: &Ray,
        hit: &Hit,
        media: &MediumStack,
        scratch: &mut ShadeScratch,
    ) -> Sheet {
        let (material, _) = self.material(hit.surface);
        let depth = match material.absorption.constant() {
            Some(depth) => Vec3::from_array(depth),
            None => self.coefficients(hit.surface, hit.position, scratch),
        };
        let cosine = -viewed_normal(ray, hit, false).dot(ray.direction);
        Sheet::new(cosine, media.ior(self.frame) / material.ior, depth)
    }

    /// Absorption of a clear surface at a point, per world unit.
    pub(super) fn coefficients(
        &self,
        surface: u32,
        point: DVec3,
        scratch: &mut ShadeScratch,
    ) -> Vec3 {
        let absorption = &self.material(surface).0.absorption;
        scratch.attributes.gather(self.frame, surface, point);
        let left = self.color(&absorption.left, surface, scratch);
        let density = match &absorption.density {
            None => 1.0,
            Some(scaling) => self.number(scaling, surface, scratch).max(0.0),
        };
        Vec3::from_array(absorption.coefficients(left)) * density
    }

    /// What is left of light after `distance` along a ray in `media` (Beer and Lambert). Where the
    /// absorption varies its mean is taken by the midpoint rule.
    pub(in crate::shade) fn absorbed(
        &self,
        ray: &Ray,
        distance: f64,
        media: &MediumStack,
        scratch: &mut ShadeScratch,
    ) -> Vec3 {
        let Some(surface) = media.filling(self.frame) else {
            return Vec3::ONE;
        };
        let absorption = &self.material(surface).0.absorption;
        let coefficients = match absorption.constant() {
            Some(coefficients) => Vec3::from_array(coefficients),
            None if !distance.is_finite() => Vec3::ZERO,
            None => {
                let mut sum = Vec3::ZERO;
                for step in 0..ABSORPTION_STEPS {
                    let along = (f64::from(step) + 0.5) / f64::from(ABSORPTION_STEPS);
                    sum += self.coefficients(surface, ray.at(along * distance), scratch);
                }
                sum / ABSORPTION_STEPS as f32
            }
        };
        // Without absorption infinite ways are clear: 0 · ∞ is not a number.
        Vec3::from_array(coefficients.to_array().map(|c| {
            if c > 0.0 {
                (-c * distance as f32).exp()
            } else {
                1.0
            }
        }))
    }

    /// How much of the light from `distance` along `ray` arrives. Boundaries of clear media stop it;
    /// or, if `straight`, they let through what they do not reflect, without bending it. Thin sheets
    /// bend nothing: they never stop it.
    pub(in crate::shade) async fn reach(
        &self,
        mut ray: Ray,
        mut distance: f64,
        mut media: MediumStack,
        straight: bool,
        ask: &impl Ask,
    ) -> Reach {
        ask.scratch().rays.shadow += 1;
        // One clear surface alone has no boundaries that are none.
        let walks = self.has_sheets || self.medium_count > 1 || straight && self.medium_count > 0;
        if !walks {
            ray.t_max = distance;
            if ask.is_blocked(&ray).await {
                return Reach::NOTHING;
            }
            let emission = self.emission_scale(&media);
            return Reach {
                part: self.absorbed(&ray, distance, &media, &mut ask.scratch()) * emission,
                went_through: false,
            };
        }
        let mut reach = Reach {
            part: Vec3::ONE,
            went_through: false,
        };
        for _ in 0..MAX_CROSSINGS {
            ray.t_max = distance;
            let Some(hit) = ask.closest(&ray).await else {
                let left = self.absorbed(&ray, distance, &media, &mut ask.scratch());
                reach.part *= left * self.emission_scale(&media);
                return reach;
            };
            reach.part *= self.absorbed(&ray, hit.t, &media, &mut ask.scratch());
            let contact = self.contact(&ray, hit, &media, &mut ask.scratch());
            let Contact { hit, beyond, .. } = contact;
            if !contact.is_boundary {
                let onward = contact.onward(&ray);
                distance -= onward.walked;
                (ray, media) = (onward.ray, onward.media);
                continue;
            }
            let (material, _) = self.material(hit.surface);
            if !material.kind.is_clear() {
                return Reach::NOTHING;
            }
            if material.thin {
                reach.part *= self
                    .sheet(&ray, &hit, &media, &mut ask.scratch())
                    .transmitted();
            } else {
                if !straight {
                    return Reach::NOTHING;
                }
                reach.went_through = true;
                let [ior, ior_beyond] = [media.ior(self.frame), beyond.ior(self.frame)];
                let cosine = hit.normal.dot(ray.direction).abs().min(1.0);
                reach.part *= 1.0 - dielectric_reflectance(cosine, ior / ior_beyond).0 as f32;
            }
            if reach.part.max_element() <= 0.0 {
                return Reach::NOTHING;
            }
            media = beyond;
            distance -= hit.t;
            ray = passed(&ray, &hit);
        }
        Reach::NOTHING
    }
}
