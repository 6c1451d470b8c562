//! Ways of gathering light, one file each: a closed list.

pub(super) mod ambient;
mod ao;
mod path;
mod shaded;
mod whitted;

use super::asking::{Ask, AtOnce, Desk, run};
use super::gloss::Gloss;
use super::medium::MediumStack;
use super::rays::{EyeRays, Seen, ShadeScratch};
use super::world::World;
use crate::frame::Frame;
use crate::intersect::{BlobTracer, Hit};
use crate::math::aabb::DAabb;
use crate::math::ray::Ray;
use crate::math::sampling::PixelSampler;
use crate::scene::{Background, IntegratorKind, IntegratorSettings};
use ambient::Ambient;
use glam::{DVec3, Vec3};
use std::pin::pin;
use std::task::{Context, Poll, Waker};

/// Samples that are under way at a time where rays are traced many at a time: as many rays as keep a
/// device busy, and records of a few KiB each.
const UNDER_WAY: usize = 1 << 14;

/// How a frame is shaded.
#[derive(Debug, Clone)]
pub struct ShadeSettings {
    /// How light is gathered.
    pub integrator: IntegratorSettings,
    /// What stands behind the surfaces.
    pub background: Background,
    /// Whether every attribute is evaluated where the eye's rays hit.
    pub with_attributes: bool,
    /// Camera samples per pixel, over which `ao` deals out its rays.
    pub spp: u32,
    /// Where the eye's rays start at the frame's time: the media there surround the camera.
    pub eye: DVec3,
    /// Box around where they start while the shutter is open, if that is not always the same place.
    pub eye_bounds: Option<DAabb>,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter_secs: [f64; 2],
}

impl Default for ShadeSettings {
    fn default() -> Self {
        Self {
            integrator: IntegratorSettings::default(),
            background: Background::Sky,
            with_attributes: false,
            spp: 1,
            eye: DVec3::ZERO,
            eye_bounds: None,
            shutter_secs: [0.0; 2],
        }
    }
}

/// Shades the surfaces of one frame.
pub struct Shader<'a> {
    pub(super) world: World<'a>,
    pub(super) settings: ShadeSettings,
    /// Media around the eye at the frame's time; `None` where they may be others at other times.
    pub(super) media: Option<MediumStack>,
    /// Light from all around, for `shaded` and `whitted`.
    pub(super) ambient: Ambient,
    /// Coats of `shaded`, one per material.
    pub(super) gloss: Vec<Option<Gloss>>,
}

/// What an integrator found along an eye's ray.
pub(super) struct Gathered {
    /// Light towards the eye, without what shows behind a faded ground.
    pub(super) radiance: Vec3,
    /// The first surface and its base colour.
    pub(super) first: Option<(Hit, Vec3)>,
    /// Whether something was seen, a surface or a lamp.
    pub(super) is_covered: bool,
}

impl Gathered {
    fn surface(radiance: Vec3, hit: Hit, color: Vec3) -> Self {
        Self {
            radiance,
            first: Some((hit, color)),
            is_covered: true,
        }
    }

    fn nothing(radiance: Vec3) -> Self {
        Self {
            radiance,
            first: None,
            is_covered: false,
        }
    }
}

/// Media around the eye while the shutter is open; `None` where they may be others at other times.
fn media_at_eye(frame: &Frame, settings: &ShadeSettings) -> Option<MediumStack> {
    let [open, close] = settings.shutter_secs;
    let moves = settings.eye_bounds.is_some() || frame.moves();
    if open == close || !moves {
        return Some(MediumStack::at(frame, settings.eye, 0.0));
    }
    let eye = settings.eye_bounds.unwrap_or(DAabb {
        min: settings.eye,
        max: settings.eye,
    });
    let is_medium = |surface: u32| {
        let material = frame.instances[surface as usize].material;
        frame.materials[material as usize].is_medium()
    };
    (0..frame.instances.len() as u32)
        .filter(|&surface| is_medium(surface))
        .all(|surface| frame.is_outside(surface, &eye, settings.shutter_secs))
        .then(MediumStack::default)
}

impl<'a> Shader<'a> {
    /// A shader for `frame`.
    pub fn new(frame: &'a Frame, settings: &ShadeSettings) -> Self {
        Self {
            media: media_at_eye(frame, settings),
            ambient: Ambient::new(frame),
            gloss: frame
                .materials
                .iter()
                .map(|material| Gloss::new(material.specular, material.roughness))
                .collect(),
            settings: settings.clone(),
            world: World::new(frame, settings),
        }
    }

    /// Media where a ray of the eye starts.
    fn media(&self, ray: &Ray) -> MediumStack {
        let asked = || MediumStack::at(self.world.frame, ray.origin, ray.time);
        self.media.unwrap_or_else(asked)
    }

    /// Lets `tracer` trace the eye's rays to the first surfaces, and with integrator `shaded` from there
    /// to the lights; [`Shader::sample`] goes on.
    ///
    /// # Errors
    /// Those of `tracer`.
    pub fn find_first<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        eye: &mut EyeRays,
        scratch: &mut ShadeScratch,
    ) -> Result<(), T::Error> {
        eye.hits.clear();
        eye.hits.resize(eye.rays.len(), None);
        self.world
            .frame
            .closest_hits_by(tracer, &eye.rays, &mut eye.hits, &mut scratch.trace)?;
        if self.settings.integrator.kind == IntegratorKind::Shaded {
            self.find_shadows(tracer, eye, scratch)?;
        }
        Ok(())
    }

    /// What ray `index` of `eye` sees, with the random numbers of its sample; [`Shader::find_first`] has
    /// run.
    ///
    /// # Panics
    /// If `eye` has no such ray.
    pub fn sample(
        &self,
        eye: &EyeRays,
        index: usize,
        sampler: &mut PixelSampler,
        scratch: &mut ShadeScratch,
    ) -> Seen {
        scratch.attributes.time_secs = eye.rays[index].time;
        let gathered = if self.settings.integrator.kind == IntegratorKind::Shaded {
            self.shaded(eye, index, scratch)
        } else {
            let ask = AtOnce::new(self.world.frame, scratch);
            run(pin!(self.ask_around(&ask, eye, index, sampler)))
        };
        self.seen(&eye.rays[index], gathered, scratch)
    }

    /// What rays of `eye` see, each with the random numbers of its sample; [`Shader::find_first`] has
    /// run. All rays that become known together are traced together, by `tracer`; `visit` is called with
    /// the ray's index, what it saw, and all attributes there ([`ShadeScratch::attributes`]).
    ///
    /// # Errors
    /// Those of `tracer`.
    ///
    /// # Panics
    /// If `eye` has no such ray.
    pub fn sample_many<T: BlobTracer + ?Sized>(
        &self,
        tracer: &T,
        eye: &EyeRays,
        samples: impl Iterator<Item = (usize, PixelSampler)>,
        scratch: &mut ShadeScratch,
        mut visit: impl FnMut(usize, &Seen, &[f32]),
    ) -> Result<(), T::Error> {
        if self.settings.integrator.kind == IntegratorKind::Shaded {
            for (index, mut sampler) in samples {
                let seen = self.sample(eye, index, &mut sampler, scratch);
                visit(index, &seen, scratch.attributes());
            }
            return Ok(());
        }
        let desk = &Desk::new(self.world.frame, scratch);
        let mut context = Context::from_waker(Waker::noop());
        let mut samples = samples.map(|(index, mut sampler)| {
            let work = async move { self.ask_around(desk, eye, index, &mut sampler).await };
            (index, Box::pin(work))
        });
        let mut under_way = Vec::with_capacity(UNDER_WAY);
        loop {
            let room = UNDER_WAY - under_way.len();
            under_way.extend(samples.by_ref().take(room));
            if under_way.is_empty() {
                return Ok(());
            }
            under_way.retain_mut(|(index, work)| {
                let ray = &eye.rays[*index];
                desk.scratch().attributes.time_secs = ray.time;
                match work.as_mut().poll(&mut context) {
                    Poll::Pending => true,
                    Poll::Ready(gathered) => {
                        let seen = self.seen(ray, gathered, &mut desk.scratch());
                        visit(*index, &seen, desk.scratch().attributes());
                        false
                    }
                }
            });
            desk.answer(tracer)?;
        }
    }

    /// What an integrator finds that asks about further rays; `shaded` has its answers already.
    async fn ask_around(
        &self,
        ask: &impl Ask,
        eye: &EyeRays,
        index: usize,
        sampler: &mut PixelSampler,
    ) -> Gathered {
        let (ray, first) = (&eye.rays[index], eye.hits[index]);
        match self.settings.integrator.kind {
            IntegratorKind::Shaded => self.shaded(eye, index, &mut ask.scratch()),
            IntegratorKind::Whitted => self.whitted(ray, first, ask).await,
            IntegratorKind::Ao => self.ambient_occlusion(ray, first, sampler, ask).await,
            IntegratorKind::Path => self.path(ray, first, sampler, ask).await,
        }
    }

    /// What a sample saw along the eye's ray, with what shows behind a faded ground.
    fn seen(&self, ray: &Ray, gathered: Gathered, scratch: &mut ShadeScratch) -> Seen {
        scratch.rays.primary += 1;
        let radiance = match &gathered.first {
            None => gathered.radiance,
            // A file without background keeps the whole ground for whoever composes it.
            Some(_) if self.settings.background == Background::Transparent => gathered.radiance,
            Some((hit, _)) => {
                let opacity = self.world.opacity(hit);
                gathered.radiance * opacity + self.world.behind(ray.direction) * (1.0 - opacity)
            }
        };
        self.seen_with_backdrop(
            &Gathered {
                radiance,
                ..gathered
            },
            scratch,
        )
    }

    /// What a sample saw whose radiance has what shows behind a faded ground.
    pub(super) fn seen_with_backdrop(
        &self,
        gathered: &Gathered,
        scratch: &mut ShadeScratch,
    ) -> Seen {
        scratch.attributes.all.clear();
        let Some((hit, color)) = gathered.first else {
            return Seen {
                radiance: gathered.radiance.to_array(),
                coverage: f32::from(u8::from(gathered.is_covered)),
                backdrop: f32::from(u8::from(!gathered.is_covered)),
                albedo: [0.0; 3],
                denoising_albedo: [0.0; 3],
                hit: None,
                row: None,
            };
        };
        self.world.fill_attributes(&hit, scratch);
        Seen {
            radiance: gathered.radiance.to_array(),
            coverage: 1.0,
            backdrop: 1.0 - self.world.opacity(&hit),
            albedo: color.to_array(),
            denoising_albedo: match self.world.material(hit.surface).0.kind.is_clear() {
                true => [1.0; 3],
                false => color.to_array(),
            },
            hit: Some(hit),
            row: self.world.row(&hit),
        }
    }
}

#[cfg(test)]
mod tests;
