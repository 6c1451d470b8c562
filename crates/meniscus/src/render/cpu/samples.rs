//! Samples: the eye's rays, what they see, and what the film keeps of it.

use super::{Job, Tile};
use crate::film::{Film, NO_INDEX, PixelSample, SurfaceSample};
use crate::frame::environment::luminance;
use crate::frame::{Frame, Geometry};
use crate::intersect::{BlobTracer, Hit};
use crate::math::aabb::DAabb;
use crate::math::ray::{Ray, Side};
use crate::math::sampling::{Moments, PixelSampler};
use crate::render::RenderError;
use crate::render::noise::TileNoise;
use crate::shade::{EyeRays, Seen, ShadeScratch};
use glam::{DVec3, Vec3};
use std::ops::Range;

impl<T> Job<'_, T>
where
    T: BlobTracer + ?Sized,
    RenderError: From<T::Error>,
{
    /// A sample before it is traced.
    pub(super) fn start(&self, pixel: [u32; 2], sample: u32) -> Start {
        let mut sampler = PixelSampler::new(pixel, sample, self.settings.seed);
        Start {
            pixel,
            sample,
            position: self
                .filter
                .film_position(pixel, self.settings.spp, &mut sampler),
            sampler,
        }
    }

    /// The eye's ray of a sample.
    #[inline]
    pub(super) fn eye_ray(&self, start: &Start, moments: &mut Moments) -> Ray {
        let secs = self.time_secs(start, moments);
        let ray = self.camera.ray_at(start.position, secs);
        let side = self.eye_side;
        let antialiases = self.settings.integrator.specular_antialiasing;
        Ray {
            side: side.unwrap_or_else(|| eye_side(self.frame, &self.bounds, ray.origin)),
            differential: antialiases.then(|| self.camera.differential_at(start.position, secs)),
            ..ray
        }
    }

    /// Traces the eye's rays of the block at `left`, `top` that go together, from sample `first` on: always
    /// all of them, as far as the picture has them, so that rays see the same whatever part is wanted.
    pub(super) fn find_first(
        &self,
        block: &mut Block,
        [left, top]: [u32; 2],
        first: u32,
        scratch: &mut ShadeScratch,
    ) -> Result<(), RenderError> {
        block.starts.clear();
        block.eye.rays.clear();
        let [width, height] = self.camera.size;
        for sample in first..(first + self.cut.samples).min(self.settings.spp) {
            for y in top..(top + self.cut.block_side).min(height) {
                for x in left..(left + self.cut.block_side).min(width) {
                    block.starts.push(self.start([x, y], sample));
                }
            }
        }
        let mut moments = self.moments();
        let starts = block.starts.iter();
        let rays = starts.map(|start| self.eye_ray(start, &mut moments));
        block.eye.rays.extend(rays);
        Ok(self
            .shader
            .find_first(self.tracer, &mut block.eye, scratch)?)
    }

    /// What deals samples their times: by numbers of their own, so that nothing else of a sample depends
    /// on the shutter.
    pub(super) fn moments(&self) -> Moments {
        Moments::new(self.settings.spp, self.settings.seed)
    }

    /// When a sample is taken.
    pub(super) fn time_secs(&self, start: &Start, moments: &mut Moments) -> f64 {
        let [open, close] = self.settings.shutter_secs;
        if open == close {
            return open;
        }
        open + (close - open) * moments.part_of_shutter(start.pixel, start.sample)
    }

    /// Adds what is wanted of `block`: `samples` of the pixels that lie in the film.
    pub(super) fn add_block(
        &self,
        film: &mut Film,
        block: &mut Block,
        tile: &mut Tile,
        samples: &Range<u32>,
        scratch: &mut ShadeScratch,
    ) -> Result<(), RenderError> {
        let Tile { region, noise } = tile;
        let Block { starts, eye } = block;
        let region = *region;
        let mut add = |start: &Start, time_secs: f64, seen: &Seen, attributes: &[f32]| {
            self.add(film, noise, (start, time_secs), seen, attributes);
        };
        let is_wanted = |start: &Start| {
            samples.contains(&start.sample)
                && region.index(start.pixel[0], start.pixel[1]).is_some()
        };
        if self.cut.waits {
            let wanted = starts.iter().enumerate();
            let wanted = wanted.filter(|(_, start)| is_wanted(start));
            let samples = wanted.map(|(index, start)| (index, start.sampler));
            self.shader.sample_many(
                self.tracer,
                eye,
                samples,
                scratch,
                |index, seen, attributes| {
                    add(&starts[index], eye.rays[index].time, seen, attributes);
                },
            )?;
            return Ok(());
        }
        for (index, start) in starts.iter_mut().enumerate() {
            if !is_wanted(start) {
                continue;
            }
            let seen = self.shader.sample(eye, index, &mut start.sampler, scratch);
            add(start, eye.rays[index].time, &seen, scratch.attributes());
        }
        Ok(())
    }

    /// Adds what a sample saw, if its pixel lies in the film.
    pub(super) fn add(
        &self,
        film: &mut Film,
        noise: &mut TileNoise,
        (start, time_secs): (&Start, f64),
        seen: &Seen,
        attributes: &[f32],
    ) {
        let [x, y] = start.pixel;
        let Some(pixel) = film.region().index(x, y) else {
            return;
        };
        let offset = [
            start.position[0] - f64::from(x) - 0.5,
            start.position[1] - f64::from(y) - 0.5,
        ];
        let sample_seen = PixelSample {
            radiance: seen.radiance,
            coverage: seen.coverage,
            backdrop: seen.backdrop,
            albedo: seen.albedo,
            denoising_albedo: seen.denoising_albedo,
            surface: self.surface_sample(seen, time_secs),
            attributes,
        };
        film.add(x, y, start.sample, offset, &sample_seen);
        if self.settings.noise.is_some() {
            let luminance = luminance(Vec3::from_array(seen.radiance));
            noise.add(pixel, luminance);
        }
    }

    /// How far what was hit moves across the film while the shutter is open, in pixels; its particles to
    /// first order.
    pub(super) fn motion(&self, hit: &Hit, time_secs: f64) -> [f32; 2] {
        let [open, close] = self.settings.shutter_secs;
        let at = |secs: f64| {
            let place = self.frame.carried(hit, time_secs, secs);
            self.camera.at(secs).project(place)
        };
        match [at(open), at(close)] {
            [Some(from), Some(to)] => [0, 1].map(|axis| (to[axis] - from[axis]) as f32),
            _ => [0.0; 2],
        }
    }

    pub(super) fn surface_sample(&self, seen: &Seen, time_secs: f64) -> Option<SurfaceSample> {
        let hit = seen.hit?;
        let curvature = if self.with_curvature {
            let level_set = self.frame.level_set(&hit, time_secs);
            [level_set.mean_curvature(), level_set.gaussian_curvature()]
        } else {
            [0.0; 2]
        };
        Some(SurfaceSample {
            depth: self.camera.at(time_secs).depth(hit.position) as f32,
            position: hit.position.as_vec3().to_array(),
            normal: hit.shading_normal.as_vec3().to_array(),
            motion: if self.with_motion {
                self.motion(&hit, time_secs)
            } else {
                [0.0; 2]
            },
            curvature: curvature.map(|curvature| curvature as f32),
            id: seen.row.unwrap_or(NO_INDEX),
            surface: hit.surface,
        })
    }
}

/// A sample of a pixel before it is traced.
pub(super) struct Start {
    pub(super) pixel: [u32; 2],
    pub(super) sample: u32,
    pub(super) position: [f64; 2],
    pub(super) sampler: PixelSampler,
}

/// Samples of the pixels of a block that go together; buffers that are reused.
#[derive(Default)]
pub(super) struct Block {
    pub(super) starts: Vec<Start>,
    pub(super) eye: EyeRays,
}

/// Outside where the eye lies beyond the supports of all blobs, meshes and spheres and above all planes, so that no
/// primary ray has to ask; unknown otherwise.
pub(super) fn eye_side(frame: &Frame, bounds: &DAabb, eye: DVec3) -> Side {
    let above_planes = frame.instances.iter().all(|instance| {
        match &frame.geometries[instance.geometry as usize] {
            Geometry::Blobs(_) | Geometry::Mesh(_) | Geometry::Sphere(_) => true,
            Geometry::Plane(plane) => {
                let eye = instance.object_from_world.transform_point3(eye);
                (eye - plane.point).dot(plane.normal) > 0.0
            }
        }
    });
    if !bounds.contains(eye) && above_planes {
        Side::Outside
    } else {
        Side::Unknown
    }
}
