//! Integrator `whitted`: a tree of mirrored and refracted rays with hard shadows (Whitted, "An Improved
//! Illumination Model for Shaded Display", 1980). Rough surfaces mirror sharply, clear ones let the
//! light of lamps through without bending it, and what surrounds the scene lights unshaded.

use super::{Gathered, Shader};
use crate::intersect::Hit;
use crate::math::ray::Ray;
use crate::scene::MaterialKind;
use crate::shade::asking::Ask;
use crate::shade::bsdf::{Bsdf, Scattering, Sheet, dielectric_reflectance};
use crate::shade::interaction::{Interaction, Turn};
use crate::shade::medium::MediumStack;
use crate::shade::world::{count, passed};
use glam::{DVec3, Vec3};

/// Branches that can change a picture by less than this are not followed.
const LEAST_WEIGHT: f32 = 1e-3;
/// Surfaces that one branch goes straight through: thin sheets, and boundaries between media of which
/// neither fills the place.
const MAX_STRAIGHT: u32 = 64;

/// What one ray of the tree found.
struct Seen {
    light: Vec3,
    first: Option<(Hit, Vec3)>,
    is_covered: bool,
}

/// Where a branch of the tree meets a surface.
struct Branch<'a> {
    ray: &'a Ray,
    media: &'a MediumStack,
    /// How often it was turned.
    level: u32,
    /// How much it counts in the picture.
    weight: f32,
}

impl Shader<'_> {
    pub(super) async fn whitted(&self, ray: &Ray, first: Option<Hit>, ask: &impl Ask) -> Gathered {
        let media = self.media(ray);
        let seen = self.branch(*ray, first, media, 0, 1.0, ask).await;
        Gathered {
            radiance: seen.light,
            first: seen.first,
            is_covered: seen.is_covered,
        }
    }

    /// Light along `ray`, whose first surface is `hit`, which counts with `weight` in the picture and
    /// was turned `level` times.
    async fn branch(
        &self,
        mut ray: Ray,
        mut hit: Option<Hit>,
        mut media: MediumStack,
        level: u32,
        weight: f32,
        ask: &impl Ask,
    ) -> Seen {
        let world = &self.world;
        // What is seen on thin sheets, and what is left of the light behind them.
        let (mut sum, mut first) = (Vec3::ZERO, None);
        let mut left = Vec3::ONE;
        for _ in 0..MAX_STRAIGHT {
            let end = hit.map_or(f64::INFINITY, |hit| hit.t);
            if let Some((t, found)) = world.lights.met(ray.origin, ray.direction, end) {
                left *= world.absorbed(&ray, t, &media, &mut ask.scratch());
                let scale = world.emission_scale(&media);
                return Seen {
                    light: sum + left * found.radiance * scale,
                    first,
                    is_covered: true,
                };
            }
            left *= world.absorbed(&ray, end, &media, &mut ask.scratch());
            let Some(met) = hit else {
                let behind = if level == 0 && first.is_none() {
                    world.behind(ray.direction)
                } else {
                    world.surroundings_or_backdrop(ray.direction)
                };
                return Seen {
                    light: sum + left * behind,
                    is_covered: first.is_some(),
                    first,
                };
            };
            let point = world.interaction(&ray, met, &media, 0.0, &mut ask.scratch());
            match point {
                Some(point) => {
                    let met = point.hit;
                    let branch = Branch {
                        ray: &ray,
                        media: &media,
                        level,
                        weight,
                    };
                    let mut light = self.turned(&branch, &point, ask).await;
                    let opacity = world.opacity(&met);
                    if level > 0 && opacity < 1.0 {
                        let behind = world.surroundings_or_backdrop(ray.direction);
                        light = light * opacity + behind * (1.0 - opacity);
                    }
                    sum += left * light;
                    let first = *first.get_or_insert((met, point.color));
                    let through = point.bsdf.sheet().map_or(Vec3::ZERO, Sheet::transmitted);
                    left *= through;
                    if left.max_element() <= 0.0 {
                        return Seen {
                            light: sum,
                            first: Some(first),
                            is_covered: true,
                        };
                    }
                    count(&mut ask.scratch().rays, Scattering::Refraction);
                    ray = passed(&ray, &met);
                }
                None => {
                    let onward = world.onward(&ray, met, &media, &mut ask.scratch());
                    (ray, media) = (onward.ray, onward.media);
                }
            }
            hit = ask.closest(&ray).await;
        }
        Seen {
            light: sum,
            first,
            is_covered: true,
        }
    }

    /// Light from a surface towards the viewer.
    async fn turned(&self, branch: &Branch<'_>, point: &Interaction<'_>, ask: &impl Ask) -> Vec3 {
        let world = &self.world;
        let media = branch.media;
        let mut light = self.direct(branch.ray, point, media, ask).await;
        let cosine = point.view.z;
        let mirror = DVec3::new(-point.view.x, -point.view.y, cosine);
        let follow = async |local: DVec3, part: Vec3, turn: Turn| -> Vec3 {
            self.follow(branch, point, (local, part, turn), ask).await
        };
        if let Some(sheet) = point.bsdf.sheet() {
            return light + follow(mirror, sheet.reflected(), Turn::Reflection).await;
        }
        let (material, _) = world.material(point.hit.surface);
        match material.kind {
            MaterialKind::Diffuse | MaterialKind::Foam => {
                light += point.color * self.ambient.diffuse(point.normal());
            }
            MaterialKind::Glossy | MaterialKind::Plastic => {
                let Bsdf::Plastic(plastic) = &point.bsdf else {
                    return light + point.color * self.ambient.diffuse(point.normal());
                };
                let coat = plastic.coat_reflectance(cosine) as f32;
                light += point.color * self.ambient.diffuse(point.normal()) * (1.0 - coat);
                light += follow(mirror, Vec3::splat(coat), Turn::Reflection).await;
            }
            MaterialKind::Metal | MaterialKind::Mirror => {
                if let Bsdf::Conductor(conductor) = &point.bsdf {
                    let part = conductor.facet_reflectance(cosine);
                    light += follow(mirror, part, Turn::Reflection).await;
                }
            }
            MaterialKind::Dielectric | MaterialKind::Glass | MaterialKind::Water => {
                let [ior, beyond] = [media.ior(world.frame), point.beyond.ior(world.frame)];
                let eta = ior / beyond;
                let (reflectance, other) = dielectric_reflectance(cosine, eta);
                let part = Vec3::splat(reflectance as f32);
                light += follow(mirror, part, Turn::Reflection).await;
                if let Some(other) = other {
                    let refracted = DVec3::new(-eta * point.view.x, -eta * point.view.y, -other);
                    light += follow(refracted, Vec3::ONE - part, Turn::Refraction(eta)).await;
                }
            }
        }
        light
    }

    /// Light from a mirrored or refracted direction, of which `part` arrives.
    async fn follow(
        &self,
        branch: &Branch<'_>,
        point: &Interaction<'_>,
        (local, part, turn): (DVec3, Vec3, Turn),
        ask: &impl Ask,
    ) -> Vec3 {
        let world = &self.world;
        let media = branch.media;
        let weight = branch.weight * part.max_element();
        if weight < LEAST_WEIGHT {
            return Vec3::ZERO;
        }
        let on_viewers_side = local.z > 0.0;
        let level = branch.level + 1;
        if level >= self.settings.integrator.depth {
            // A mirror in the open shows what it would if nothing were in its way, rather than black.
            let in_the_open = on_viewers_side && media.filling(world.frame).is_none();
            return if in_the_open {
                part * world.surroundings_or_backdrop(point.to_world(local))
            } else {
                Vec3::ZERO
            };
        }
        let direction = point.to_world(local);
        if !point.agrees(direction, on_viewers_side) {
            return Vec3::ZERO;
        }
        let ray = Ray {
            differential: point.differential(branch.ray, turn),
            ..point.leaving(direction, on_viewers_side, branch.ray.time)
        };
        let media = if on_viewers_side {
            *media
        } else {
            point.beyond
        };
        let scattering = match turn {
            Turn::Reflection => Scattering::Reflection,
            Turn::Refraction(_) => Scattering::Refraction,
        };
        count(&mut ask.scratch().rays, scattering);
        let hit = ask.closest(&ray).await;
        let seen = Box::pin(self.branch(ray, hit, media, level, weight, ask)).await;
        part * seen.light
    }

    /// Light of lamps, each as one direction.
    async fn direct(
        &self,
        ray: &Ray,
        point: &Interaction<'_>,
        media: &MediumStack,
        ask: &impl Ask,
    ) -> Vec3 {
        if !point.bsdf.is_spread() {
            return Vec3::ZERO;
        }
        let mut sum = Vec3::ZERO;
        for (_, light) in self.world.lights.hard(point.hit.position) {
            let local = point.to_local(light.towards);
            let scattered = point.bsdf.evaluate(point.view, local);
            if scattered == Vec3::ZERO {
                continue;
            }
            let on_viewers_side = local.z > 0.0;
            if !point.agrees(light.towards, on_viewers_side) {
                continue;
            }
            let media = if on_viewers_side {
                *media
            } else {
                point.beyond
            };
            let shadow = point.leaving(light.towards, on_viewers_side, ray.time);
            let reach = self
                .world
                .reach(shadow, light.distance, media, true, ask)
                .await;
            sum += scattered * light.weight * reach.part;
        }
        sum
    }
}
