//! Integrator `path`: unbiased path tracing up to its depth limits, with next-event estimation and
//! multiple importance sampling by the power heuristic (Veach, "Robust Monte Carlo Methods for Light
//! Transport Simulation", 1997, §9.2), and Russian roulette.

use super::{Gathered, Shader};
use crate::intersect::Hit;
use crate::math::ray::Ray;
use crate::math::sampling::PixelSampler;
use crate::scene::Background;
use crate::shade::ShadeScratch;
use crate::shade::asking::Ask;
use crate::shade::bsdf::{BsdfSample, Scattering, Sheet};
use crate::shade::interaction::{Interaction, Turn};
use crate::shade::light::Found;
use crate::shade::medium::MediumStack;
use crate::shade::world::{count, passed};
use glam::{DVec3, Vec3};

/// Draws from the sampler per surface, and which one decides what. Numbers that nothing needs are not
/// drawn: they are a tenth of the time of water.
const DRAWS: u32 = 5;
const LIGHT_DRAW: u32 = 0;
const CHOICE_DRAW: u32 = 2;
const SURVIVAL_DRAW: u32 = 3;
const DIRECTION_DRAW: u32 = 4;
/// Surfaces before Russian roulette begins.
const SURE_SURFACES: u32 = 4;
/// Largest probability of going on once it has begun.
const MOST_SURVIVAL: f32 = 0.95;
/// Roughness at least of mirrors that rough surfaces see where caustics are left out.
const BLURRED_ROUGHNESS: f64 = 0.5;
/// Boundaries between media of which neither fills the place that a path crosses in all.
const MAX_FALSE_BOUNDARIES: u32 = 256;
/// Thin sheets that a path goes straight through in all.
const MAX_SHEETS: u32 = 256;

/// A path on its way.
struct Path {
    ray: Ray,
    media: MediumStack,
    throughput: Vec3,
    light: Vec3,
    /// Surfaces that scattered it so far, and by kind: diffuse, reflection, refraction.
    surfaces: u32,
    kinds: [u32; 3],
    /// Thin sheets that it went straight through.
    sheets: u32,
    /// Where it was scattered last and the density of its direction there; infinite behind the eye
    /// and behind mirrors.
    scattered_at: DVec3,
    density: f64,
    /// Whether a surface that spreads light lies behind it.
    is_spread: bool,
    /// Whether its next surface ends it: then it can only find lights.
    is_last: bool,
}

/// The random numbers of one surface.
struct Draws<'a> {
    sampler: &'a mut PixelSampler,
    first: u32,
}

impl Draws<'_> {
    fn number(&mut self, draw: u32) -> f64 {
        self.sampler.skip_to(self.first + draw);
        self.sampler.next_1d()
    }

    fn point(&mut self, draw: u32) -> [f64; 2] {
        self.sampler.skip_to(self.first + draw);
        self.sampler.next_2d()
    }
}

fn power_heuristic(density: f64, other: f64) -> f32 {
    if density.is_infinite() {
        return 1.0;
    }
    let [a, b] = [density * density, other * other];
    (a / (a + b)) as f32
}

impl Shader<'_> {
    pub(super) async fn path(
        &self,
        ray: &Ray,
        first: Option<Hit>,
        sampler: &mut PixelSampler,
        ask: &impl Ask,
    ) -> Gathered {
        let world = &self.world;
        let mut path = Path {
            ray: *ray,
            media: self.media(ray),
            throughput: Vec3::ONE,
            light: Vec3::ZERO,
            surfaces: 0,
            kinds: [0; 3],
            sheets: 0,
            scattered_at: ray.origin,
            density: f64::INFINITY,
            is_spread: false,
            is_last: false,
        };
        let mut known = Some(first);
        let mut first = None;
        let mut is_covered = false;
        let mut false_boundaries = 0;
        loop {
            let hit = match known.take() {
                Some(hit) => hit,
                None => ask.closest(&path.ray).await,
            };
            let end = hit.map_or(f64::INFINITY, |hit| hit.t);
            if let Some((t, found)) = world.lights.met(path.ray.origin, path.ray.direction, end) {
                let left = world.absorbed(&path.ray, t, &path.media, &mut ask.scratch());
                path.throughput *= left;
                self.add_found(&mut path, found);
                is_covered = true;
                break;
            }
            path.throughput *= world.absorbed(&path.ray, end, &path.media, &mut ask.scratch());
            let Some(hit) = hit else {
                self.add_escaped(&mut path);
                break;
            };
            is_covered = true;
            let least_roughness = if path.is_spread && !self.settings.integrator.caustics {
                BLURRED_ROUGHNESS
            } else {
                0.0
            };
            let found = world.interaction(
                &path.ray,
                hit,
                &path.media,
                least_roughness,
                &mut ask.scratch(),
            );
            let Some(point) = found else {
                false_boundaries += 1;
                if false_boundaries > MAX_FALSE_BOUNDARIES {
                    break;
                }
                let onward = world.onward(&path.ray, hit, &path.media, &mut ask.scratch());
                (path.ray, path.media) = (onward.ray, onward.media);
                continue;
            };
            let hit = point.hit;
            if first.is_none() {
                first = Some((hit, point.color));
                let shows_backdrop_alone = world.opacity(&hit) == 0.0
                    && self.settings.background != Background::Transparent;
                if shows_backdrop_alone {
                    break;
                }
            } else if !self.fade(&mut path, &hit) {
                break;
            }
            let sheet = point.bsdf.sheet();
            if path.is_last && sheet.is_none() {
                break;
            }
            let mut draws = Draws {
                sampler: &mut *sampler,
                first: 1 + (path.surfaces + path.sheets) * DRAWS,
            };
            let goes_on = match sheet {
                Some(sheet) => {
                    self.meet_sheet(&mut path, sheet, &point, &mut draws, &mut ask.scratch())
                }
                None => {
                    path.surfaces += 1;
                    self.add_direct(&mut path, &point, &mut draws, ask).await;
                    self.scatter(&mut path, &point, &mut draws, &mut ask.scratch())
                }
            };
            if !goes_on {
                break;
            }
        }
        Gathered {
            radiance: path.light,
            first,
            is_covered,
        }
    }

    /// The ground fades into what surrounds the scene; false where nothing is left of it.
    fn fade(&self, path: &mut Path, hit: &Hit) -> bool {
        let opacity = self.world.opacity(hit);
        if opacity < 1.0 {
            let behind = self.world.lights.surroundings(path.ray.direction);
            self.add(path, behind * (1.0 - opacity));
            path.throughput *= opacity;
        }
        opacity > 0.0
    }

    /// Adds radiance that the path sees at its end.
    fn add(&self, path: &mut Path, radiance: Vec3) {
        let mut light = path.throughput * radiance;
        if let Some(clamp) = self.settings.integrator.clamp
            && path.surfaces > 1
        {
            let largest = light.max_element();
            if largest > clamp as f32 {
                light *= clamp as f32 / largest;
            }
        }
        path.light += light;
    }

    /// Adds a light that the path ran into.
    fn add_found(&self, path: &mut Path, found: Found) {
        let lights = &self.world.lights;
        let weight = if path.density.is_infinite() {
            // Where caustics are left out, such lights were counted straight through the surface.
            let left_out = !self.settings.integrator.caustics
                && path.is_spread
                && lights.is_drawn(found.emitter);
            f32::from(u8::from(!left_out))
        } else {
            let other = lights.density(found.emitter, path.scattered_at, path.ray.direction);
            power_heuristic(path.density, other)
        };
        let scale = self.world.emission_scale(&path.media);
        self.add(path, found.radiance * (weight * scale));
    }

    /// Adds what surrounds the scene.
    fn add_escaped(&self, path: &mut Path) {
        let world = &self.world;
        let direction = path.ray.direction;
        let is_first = path.surfaces + path.sheets == 0;
        if is_first && self.settings.background != Background::Sky {
            return;
        }
        for found in world.lights.escaped(direction) {
            self.add_found(path, found);
        }
        // Seen in mirrors and through clear surfaces, too.
        let shows_default_sky =
            self.settings.background == Background::Sky && !world.lights.has_surroundings();
        if shows_default_sky && !path.is_spread {
            let sky = world.backdrop(direction);
            self.add(path, sky);
        }
    }

    /// Next-event estimation: light that comes straight from a drawn light.
    async fn add_direct(
        &self,
        path: &mut Path,
        point: &Interaction<'_>,
        draws: &mut Draws<'_>,
        ask: &impl Ask,
    ) {
        let world = &self.world;
        if !point.bsdf.is_spread() {
            return;
        }
        let (choice, u) = (draws.number(LIGHT_DRAW), draws.point(LIGHT_DRAW + 1));
        let position = point.hit.position;
        let Some((emitter, light)) = world.lights.sample(position, choice, u) else {
            return;
        };
        let local = point.to_local(light.towards);
        let on_viewers_side = local.z > 0.0;
        let is_lit_from_there = on_viewers_side || point.bsdf.is_two_sided();
        if !(is_lit_from_there && point.agrees(light.towards, on_viewers_side)) {
            return;
        }
        let scattered = point.bsdf.evaluate(point.view, local);
        if scattered == Vec3::ZERO {
            return;
        }
        let ray = point.leaving(light.towards, on_viewers_side, path.ray.time);
        let media = if on_viewers_side {
            path.media
        } else {
            point.beyond
        };
        let straight = !self.settings.integrator.caustics && world.lights.is_drawn(emitter);
        let reach = world.reach(ray, light.distance, media, straight, ask).await;
        if reach.part == Vec3::ZERO {
            return;
        }
        // Behind clear surfaces scattered rays do not count, so nothing shares with this one.
        let weight = if reach.went_through {
            1.0
        } else {
            power_heuristic(light.density, point.bsdf.density(point.view, local))
        };
        self.add(path, scattered * light.weight * reach.part * weight);
    }

    /// Sends the path on straight through a thin sheet, or mirrored; false where it ends.
    ///
    /// Lights behind sheets are found by scattered rays and by drawn lights alike, so a path that goes
    /// straight through counts no surface and was scattered last where it was before.
    fn meet_sheet(
        &self,
        path: &mut Path,
        sheet: &Sheet,
        point: &Interaction<'_>,
        draws: &mut Draws<'_>,
        scratch: &mut ShadeScratch,
    ) -> bool {
        let sample = if path.is_last {
            sheet.through(point.view)
        } else {
            sheet.sample(point.view, draws.number(CHOICE_DRAW))
        };
        if sample.scattering == Scattering::Reflection {
            path.surfaces += 1;
            return self.turn(path, point, &sample, draws, scratch);
        }
        path.throughput *= sample.weight;
        path.ray = passed(&path.ray, &point.hit);
        path.sheets += 1;
        count(&mut scratch.rays, sample.scattering);
        path.sheets <= MAX_SHEETS && path.throughput.max_element() > 0.0
    }

    /// Sends the path on in a direction drawn from the surface; false where it ends.
    fn scatter(
        &self,
        path: &mut Path,
        point: &Interaction<'_>,
        draws: &mut Draws<'_>,
        scratch: &mut ShadeScratch,
    ) -> bool {
        let choice = draws.number(CHOICE_DRAW);
        let u = match point.bsdf.is_spread() {
            true => draws.point(DIRECTION_DRAW),
            // Smooth surfaces choose among single directions.
            false => [0.5; 2],
        };
        let sample = point.bsdf.sample(point.view, choice, u);
        sample.is_some_and(|sample| self.turn(path, point, &sample, draws, scratch))
    }

    /// Sends the path on in direction `sample`, if it survives; false where it ends.
    fn turn(
        &self,
        path: &mut Path,
        point: &Interaction<'_>,
        sample: &BsdfSample,
        draws: &mut Draws<'_>,
        scratch: &mut ShadeScratch,
    ) -> bool {
        path.throughput *= sample.weight;
        if path.throughput.max_element() <= 0.0 {
            return false;
        }
        let settings = &self.settings.integrator;
        let (kind, limit) = match sample.scattering {
            Scattering::Diffuse => (0, settings.diffuse_depth),
            Scattering::Reflection => (1, settings.glossy_depth),
            Scattering::Refraction => (2, settings.transmission_depth),
        };
        path.kinds[kind] += 1;
        path.is_last =
            path.surfaces >= settings.depth || limit.is_some_and(|limit| path.kinds[kind] > limit);
        if path.surfaces >= SURE_SURFACES {
            let probability = path.throughput.max_element().min(MOST_SURVIVAL);
            if draws.number(SURVIVAL_DRAW) as f32 >= probability {
                return false;
            }
            path.throughput /= probability;
        }
        let on_viewers_side = sample.light.z > 0.0;
        if !on_viewers_side {
            path.media = point.beyond;
        }
        let direction = point.to_world(sample.light);
        if !point.agrees(direction, on_viewers_side) {
            return false;
        }
        // A lobe counts as a mirror, and what is spread over the hemisphere has no footprint.
        let turn = match sample.scattering {
            Scattering::Diffuse => None,
            Scattering::Reflection => Some(Turn::Reflection),
            Scattering::Refraction => point.bsdf.index_ratio().map(Turn::Refraction),
        };
        path.ray = Ray {
            differential: turn.and_then(|turn| point.differential(&path.ray, turn)),
            ..point.leaving(direction, on_viewers_side, path.ray.time)
        };
        path.scattered_at = point.hit.position;
        path.density = sample.density;
        path.is_spread |= !sample.is_only_direction();
        count(&mut scratch.rays, sample.scattering);
        true
    }
}
