//! Tiles that a device shades by itself, and the samples that it leaves to the processor.

use super::samples::Start;
use super::{Job, Tile};
use crate::film::Film;
use crate::intersect::{BlobTracer, Hit, OnCpu};
use crate::render::stages::{
    SampleBlock, SampleRun, SampleStages, StagedHit, StagedPicture, StagedSample,
};
use crate::render::{Progress, RenderError, RenderState, Staging};
use crate::shade::{EyeRays, Seen, ShadeScratch, Unstaged};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Distance of an eye, over the size of the scene, from which on f32 tells distances badly apart.
const FARTHEST_EYE: f64 = 1e3;

/// As few samples that the processor has to do are not worth other threads.
const FEW_SAMPLES: usize = 64;

/// A pixel, and the number of a sample of it.
type Place = ([u32; 2], u32);

impl<'a, T> Job<'a, T>
where
    T: BlobTracer + ?Sized,
    RenderError: From<T::Error>,
{
    pub(super) fn staged(
        &self,
        stages: Option<&'a dyn SampleStages>,
    ) -> Result<(Box<dyn SampleRun + 'a>, DVec3), Unstaged> {
        let stages = stages.ok_or(Unstaged::Engine)?;
        let shading = self.shader.staged()?;
        let size = self.bounds.size().max_element();
        let eye = self.camera.eye_bounds(self.settings.shutter_secs);
        let center = self.bounds.center();
        let farthest = (eye.max - center).max(center - eye.min).length();
        if farthest > FARTHEST_EYE * size {
            return Err(Unstaged::FarEye);
        }
        let origin = shading.origin;
        let picture = StagedPicture {
            shading,
            camera: self.camera.clone(),
            filter: self.filter.clone(),
            spp: self.settings.spp,
            seed: self.settings.seed,
            shutter_secs: self.settings.shutter_secs,
            eye_side: self.eye_side.unwrap_or_default(),
        };
        Ok((stages.start(&picture)?, origin))
    }

    /// The tile by the device's own stages; `None` where there are none, or the device is gone.
    pub(super) fn staged_tile(
        &self,
        tile: &mut Tile,
        samples: &Range<u32>,
        (scratch, state): (&mut ShadeScratch, &RenderState),
        progress: &Progress<'_>,
    ) -> Result<Option<(Film, Option<Staging>)>, RenderError> {
        let Some((run, origin)) = &self.stages else {
            return Ok(None);
        };
        let block = SampleBlock {
            region: tile.region,
            samples: samples.clone(),
        };
        let mut film = self.film(tile.region)?;
        let mut noise = tile.noise.clone();
        let mut answers = Vec::new();
        let mut on_cpu = 0;
        let mut done = 0;
        while done < block.count() {
            if progress.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            let numbers = done..block.count().min(done + run.together());
            if !run.shade(&block, numbers.clone(), &mut answers, &mut scratch.rays)? {
                return Ok(None);
            }
            let places = numbers.clone().map(|number| block.place(number));
            let in_doubt: Vec<Place> = (places.clone().zip(&answers))
                .filter(|(_, answer)| **answer == StagedSample::InDoubt)
                .map(|(place, _)| place)
                .collect();
            on_cpu += in_doubt.len() as u64;
            let mut again = self.redo(&in_doubt, (&mut *scratch, state)).into_iter();
            let mut moments = self.moments();
            // In their order, so that sums over pixels are always the same.
            for ((pixel, sample), answer) in places.zip(&answers) {
                match *answer {
                    StagedSample::InDoubt => {
                        if let Some((start, secs, seen, attributes)) = again.next() {
                            let at = (&start, secs);
                            self.add(&mut film, &mut noise, at, &seen, &attributes);
                        }
                    }
                    StagedSample::Seen {
                        radiance,
                        is_covered,
                        hit,
                    } => {
                        let start = self.start(pixel, sample);
                        let secs = self.time_secs(&start, &mut moments);
                        let hit = hit.map(|hit| hit_of(&hit, *origin));
                        let shader = &self.shader;
                        let seen = shader.seen_by_stages(radiance, is_covered, hit, secs, scratch);
                        let at = (&start, secs);
                        self.add(&mut film, &mut noise, at, &seen, scratch.attributes());
                    }
                }
            }
            done = numbers.end;
        }
        tile.noise = noise;
        tile.noise.counted(samples.len() as u32);
        let staging = Staging::Device {
            samples: block.count(),
            on_cpu,
        };
        Ok(Some((film, Some(staging))))
    }

    /// What samples saw that a device's stages leave to the processor, when, and attributes there.
    pub(super) fn redo(
        &self,
        places: &[Place],
        (scratch, state): (&mut ShadeScratch, &RenderState),
    ) -> Vec<(Start, f64, Seen, Vec<f32>)> {
        let alone = |&(pixel, sample): &Place, scratch: &mut ShadeScratch| {
            let mut start = self.start(pixel, sample);
            let mut eye = EyeRays::default();
            eye.rays.push(self.eye_ray(&start, &mut self.moments()));
            let Ok(()) = self.shader.find_first(&OnCpu, &mut eye, scratch);
            let seen = self.shader.sample(&eye, 0, &mut start.sampler, scratch);
            (start, eye.rays[0].time, seen, scratch.attributes().to_vec())
        };
        if places.len() <= FEW_SAMPLES {
            let seen = places.iter().map(|place| alone(place, &mut *scratch));
            return seen.collect();
        }
        let parts = places.par_chunks(FEW_SAMPLES).map(|part| {
            let mut loan = state.borrow();
            let seen = part.iter().map(|place| alone(place, &mut loan.scratch));
            let seen: Vec<_> = seen.collect();
            (seen, std::mem::take(&mut loan.scratch.rays))
        });
        let parts: Vec<_> = parts.collect();
        let mut all = Vec::with_capacity(places.len());
        for (seen, rays) in parts {
            scratch.rays += rays;
            all.extend(seen);
        }
        all
    }
}

/// What a device's stages met, in the world.
fn hit_of(hit: &StagedHit, origin: DVec3) -> Hit {
    let normal = hit.normal.as_dvec3();
    Hit {
        // Films do not ask for it.
        t: 0.0,
        position: origin + hit.position.as_dvec3(),
        normal,
        shading_normal: normal,
        surface: hit.surface,
        blob: hit.blob,
        entering: hit.entering,
    }
}
