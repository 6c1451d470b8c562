//! Tiles on a rayon pool: everything but the blob surfaces' answers to rays, which come from a
//! [`BlobTracer`], is made on this machine's processor.

use super::noise::{SURE_SAMPLES, TileNoise};
use super::stages::{SampleBlock, SampleRun, SampleStages, StagedHit, StagedPicture, StagedSample};
use super::{Backend, Progress, RenderError, RenderSettings, RenderState, RenderStats, Staging};
use crate::film::{CURVATURE, Film, MOTION, NO_INDEX, PixelSample, Region, SurfaceSample};
use crate::frame::environment::luminance;
use crate::frame::{Frame, Geometry};
use crate::intersect::{BlobTracer, Hit, OnCpu};
use crate::math::aabb::DAabb;
use crate::math::ray::{Ray, Side};
use crate::math::sampling::{PixelFilter, PixelSampler, TIME_BLOCK, part_of_shutter};
use crate::scene::camera::Camera;
use crate::shade::{EyeRays, Seen, ShadeScratch, ShadeSettings, Shader, Unstaged};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How a picture is cut up.
#[derive(Debug, Clone, Copy)]
struct Cut {
    /// Side of a tile in pixels.
    tile_side: u32,
    /// Side of the blocks of pixels whose rays are traced together; divides `tile_side`.
    block_side: u32,
    /// Samples of each of its pixels that are traced together.
    samples: u32,
    /// Whether all rays that are known go together, rather than each at once.
    waits: bool,
}

/// Tiles large enough for rays to find their neighbours' data in the cache, small enough to keep many
/// threads busy to the end; blocks of rays that lie close together.
const ON_CPU: Cut = Cut {
    tile_side: 16,
    block_side: TIME_BLOCK,
    samples: 1,
    waits: false,
};

/// The same where pixels have several samples, which lie closer together than pixels, but are spread over
/// the shutter.
const ON_CPU_SAMPLED: Cut = Cut {
    block_side: 2,
    samples: 4,
    ..ON_CPU
};

/// Tiles whose rays keep a device busy and whose buffers stay small.
const ON_DEVICE: Cut = Cut {
    tile_side: 256,
    block_side: 256,
    samples: 1,
    waits: true,
};

/// Side of the tiles that a device shades by itself: whole waves of samples even where a pixel has one.
const STAGED_SIDE: u32 = 512;

/// Distance of an eye, over the size of the scene, from which on f32 tells distances badly apart.
const FARTHEST_EYE: f64 = 1e3;

/// As few samples that the processor has to do are not worth other threads.
const FEW_SAMPLES: usize = 64;

/// Renders on this machine's processor.
#[derive(Debug, Clone, Copy, Default)]
pub struct CpuBackend;

impl Backend for CpuBackend {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn render(
        &self,
        frame: &Frame,
        camera: &Camera,
        settings: &RenderSettings,
        state: &RenderState,
        progress: &Progress<'_>,
    ) -> Result<(Film, RenderStats), RenderError> {
        let comes_in_groups =
            settings.spp >= ON_CPU_SAMPLED.samples && settings.time_limit.is_none();
        let cut = if comes_in_groups && !frame.moves() {
            ON_CPU_SAMPLED
        } else {
            ON_CPU
        };
        Job::new((&OnCpu, cut), None, (frame, camera), settings)?.run_on_threads(state, progress)
    }
}

/// Renders with blob surfaces traced by another device, which shades, too, what its stages know;
/// everything else is made by this machine's processor.
#[derive(Clone, Copy)]
pub struct DeviceBackend<'a, T: ?Sized> {
    /// What `--device` calls it.
    pub name: &'static str,
    /// Answers rays on the blobs of the frame that is rendered.
    pub tracer: &'a T,
    /// Shades whole samples, if it can.
    pub stages: Option<&'a dyn SampleStages>,
}

impl<T> Backend for DeviceBackend<'_, T>
where
    T: BlobTracer + ?Sized,
    RenderError: From<T::Error>,
{
    fn name(&self) -> &'static str {
        self.name
    }

    fn render(
        &self,
        frame: &Frame,
        camera: &Camera,
        settings: &RenderSettings,
        state: &RenderState,
        progress: &Progress<'_>,
    ) -> Result<(Film, RenderStats), RenderError> {
        Job::new(
            (self.tracer, ON_DEVICE),
            self.stages,
            (frame, camera),
            settings,
        )?
        .run_on_threads(state, progress)
    }
}

/// One rendering, checked.
struct Job<'a, T: ?Sized> {
    tracer: &'a T,
    cut: Cut,
    camera: &'a Camera,
    frame: &'a Frame,
    settings: &'a RenderSettings,
    with_motion: bool,
    with_curvature: bool,
    region: Region,
    samples: Range<u32>,
    shader: Shader<'a>,
    filter: PixelFilter,
    /// Side of every surface at the eye, where it is the same and known; `None` where the eye or they
    /// move.
    eye_side: Option<Side>,
    /// Box around all but planes while the shutter is open.
    bounds: DAabb,
    /// What shades whole samples, and the world point that its answers are relative to.
    stages: Option<(Box<dyn SampleRun + 'a>, DVec3)>,
    /// Why nothing does, on a device.
    unstaged: Option<Unstaged>,
}

impl<'a, T> Job<'a, T>
where
    T: BlobTracer + ?Sized,
    RenderError: From<T::Error>,
{
    fn new(
        (tracer, cut): (&'a T, Cut),
        stages: Option<&'a dyn SampleStages>,
        (frame, camera): (&'a Frame, &'a Camera),
        settings: &'a RenderSettings,
    ) -> Result<Self, RenderError> {
        let samples = settings.samples.clone().unwrap_or(0..settings.spp);
        if samples.is_empty() || samples.end > settings.spp {
            return Err(RenderError::Samples {
                start: samples.start,
                end: samples.end.saturating_sub(1),
                spp: settings.spp,
            });
        }
        let [width, height] = camera.size;
        let bounds = frame.bounds(settings.shutter_secs);
        let [open, close] = settings.shutter_secs;
        // A shutter that opens for no time sees the frame as it is then.
        let eye_moves = camera.moves() && (open != 0.0 || close != 0.0);
        let mut job = Self {
            tracer,
            cut,
            camera,
            frame,
            settings,
            with_motion: settings.channels.has(MOTION),
            with_curvature: settings.channels.has(CURVATURE),
            region: settings.region.unwrap_or(Region::full(width, height)),
            samples,
            shader: Shader::new(
                frame,
                &ShadeSettings {
                    integrator: settings.integrator.clone(),
                    background: settings.background,
                    with_attributes: !settings.channels.attributes().is_empty(),
                    spp: settings.spp,
                    eye: camera.eye,
                    eye_moves,
                    shutter_secs: settings.shutter_secs[1] - settings.shutter_secs[0],
                },
            ),
            filter: PixelFilter::default(),
            eye_side: (!eye_moves).then(|| eye_side(frame, &bounds, camera.eye)),
            bounds,
            stages: None,
            unstaged: None,
        };
        if cut.waits {
            match job.staged(stages) {
                Ok(staged) => {
                    job.stages = Some(staged);
                    job.cut.tile_side = STAGED_SIDE;
                }
                Err(why) => job.unstaged = Some(why),
            }
        }
        Ok(job)
    }

    fn staged(
        &self,
        stages: Option<&'a dyn SampleStages>,
    ) -> Result<(Box<dyn SampleRun + 'a>, DVec3), Unstaged> {
        let stages = stages.ok_or(Unstaged::Engine)?;
        let shading = self.shader.staged()?;
        let size = self.bounds.size().max_element();
        if self.camera.eye.distance(self.bounds.center()) > FARTHEST_EYE * size {
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

    fn film(&self, region: Region) -> Result<Film, RenderError> {
        Ok(Film::new(
            self.camera.size,
            region,
            self.settings.channels.clone(),
            self.settings.background,
        )?)
    }

    fn run_on_threads(
        &self,
        state: &RenderState,
        progress: &Progress<'_>,
    ) -> Result<(Film, RenderStats), RenderError> {
        match self.settings.threads {
            None => self.run(state, progress),
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads.max(1))
                .build()
                .map_err(|error| RenderError::Threads {
                    threads,
                    message: error.to_string(),
                })?
                .install(|| self.run(state, progress)),
        }
    }

    fn run(
        &self,
        state: &RenderState,
        progress: &Progress<'_>,
    ) -> Result<(Film, RenderStats), RenderError> {
        let start = Instant::now();
        let total = self.region.pixels() * self.samples.len() as u64;
        // Merging is exact in any order, so tiles merge as they come.
        let whole = Mutex::new((self.film(self.region)?, RenderStats::default()));
        let tiles = self.region.tiles(self.cut.tile_side).into_iter();
        let mut tiles: Vec<Tile> = tiles.map(Tile::new).collect();
        let mut done = self.samples.start;
        while done < self.samples.end && !tiles.is_empty() {
            let spent = start.elapsed();
            let pass = done..done + self.pass_length(done, spent);
            if pass.is_empty() {
                break;
            }
            tiles.par_iter_mut().try_for_each_init(
                || state.borrow(),
                |loan, tile| {
                    let scratch = &mut loan.scratch;
                    let (film, staging) =
                        self.tile(tile, pass.clone(), (&mut *scratch, state), progress)?;
                    let stats = RenderStats {
                        staging,
                        rays: std::mem::take(&mut scratch.rays),
                        counters: std::mem::take(&mut scratch.trace.counters),
                        ..RenderStats::default()
                    };
                    let mut whole = whole.lock().unwrap_or_else(PoisonError::into_inner);
                    whole.0.merge(&film)?;
                    whole.1.add(&stats);
                    drop(whole);
                    let skipped = if self.is_smooth(tile) {
                        self.samples.end - pass.end
                    } else {
                        0
                    };
                    let samples = pass.len() as u64 + u64::from(skipped);
                    progress.advance(tile.region.pixels() * samples, total);
                    Ok::<(), RenderError>(())
                },
            )?;
            tiles.retain(|tile| !self.is_smooth(tile));
            done = pass.end;
        }
        let (film, stats) = whole.into_inner().unwrap_or_else(PoisonError::into_inner);
        let stats = RenderStats {
            threads: rayon::current_num_threads(),
            seconds: start.elapsed().as_secs_f64(),
            ..stats
        };
        Ok((film, stats))
    }

    /// Samples of the next pass, after `done` samples took `spent`: all that are left, unless they
    /// have to stop early. Then passes double the samples, so that each ends on a stratified pattern,
    /// and a last one takes what time is left for. 0: no time is left.
    fn pass_length(&self, done: u32, spent: Duration) -> u32 {
        let left = self.samples.end - done;
        let so_far = done - self.samples.start;
        let mut length = left;
        if self.settings.noise.is_some() {
            length = length.min(so_far.max(SURE_SAMPLES));
        }
        if let Some(limit) = self.settings.time_limit {
            if so_far == 0 {
                return 1;
            }
            let per_sample = spent.as_secs_f64() / f64::from(so_far);
            let fitting = limit.saturating_sub(spent).as_secs_f64() / per_sample;
            length = length.min(so_far).min(fitting as u32);
        }
        length
    }

    /// Whether a tile has no more noise than was asked for.
    fn is_smooth(&self, tile: &Tile) -> bool {
        self.settings
            .noise
            .is_some_and(|target| tile.noise.relative() <= target)
    }

    fn tile(
        &self,
        tile: &mut Tile,
        samples: Range<u32>,
        (scratch, state): (&mut ShadeScratch, &RenderState),
        progress: &Progress<'_>,
    ) -> Result<(Film, Option<Staging>), RenderError> {
        let region = tile.region;
        if let Some(done) = self.staged_tile(tile, &samples, (&mut *scratch, state), progress)? {
            return Ok(done);
        }
        let block_side = self.cut.block_side;
        let mut film = self.film(region)?;
        let mut block = Block::default();
        for top in (region.y / block_side..).map(|row| row * block_side) {
            if top >= region.y + region.height {
                break;
            }
            if progress.is_cancelled() {
                return Err(RenderError::Cancelled);
            }
            for left in (region.x / block_side..).map(|column| column * block_side) {
                if left >= region.x + region.width {
                    break;
                }
                let groups = samples.start / self.cut.samples..;
                for first in groups.map(|group| group * self.cut.samples) {
                    if first >= samples.end {
                        break;
                    }
                    self.find_first(&mut block, [left, top], first, scratch)?;
                    self.add_block(&mut film, &mut block, tile, &samples, scratch)?;
                }
            }
        }
        tile.noise.counted(samples.len() as u32);
        Ok((film, self.unstaged.map(Staging::Processor)))
    }

    /// The tile by the device's own stages; `None` where there are none, or the device is gone.
    fn staged_tile(
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
                        let secs = self.time_secs(pixel, sample);
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
    fn redo(
        &self,
        places: &[Place],
        (scratch, state): (&mut ShadeScratch, &RenderState),
    ) -> Vec<(Start, f64, Seen, Vec<f32>)> {
        let alone = |&(pixel, sample): &Place, scratch: &mut ShadeScratch| {
            let mut start = self.start(pixel, sample);
            let mut eye = EyeRays::default();
            eye.rays.push(self.eye_ray(&start));
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

    /// A sample before it is traced.
    fn start(&self, pixel: [u32; 2], sample: u32) -> Start {
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
    fn eye_ray(&self, start: &Start) -> Ray {
        let secs = self.time_secs(start.pixel, start.sample);
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
    fn find_first(
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
                    let start = self.start([x, y], sample);
                    block.eye.rays.push(self.eye_ray(&start));
                    block.starts.push(start);
                }
            }
        }
        Ok(self
            .shader
            .find_first(self.tracer, &mut block.eye, scratch)?)
    }

    /// When a sample is taken: by numbers of their own, so that nothing else of the sample depends on the
    /// shutter.
    fn time_secs(&self, pixel: [u32; 2], sample: u32) -> f64 {
        let [open, close] = self.settings.shutter_secs;
        if open == close {
            return open;
        }
        let RenderSettings { spp, seed, .. } = *self.settings;
        open + (close - open) * part_of_shutter(pixel, sample, spp, seed)
    }

    /// Adds what is wanted of `block`: `samples` of the pixels that lie in the film.
    fn add_block(
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
    fn add(
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
    fn motion(&self, hit: &Hit, time_secs: f64) -> [f32; 2] {
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

    fn surface_sample(&self, seen: &Seen, time_secs: f64) -> Option<SurfaceSample> {
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

/// A pixel, and the number of a sample of it.
type Place = ([u32; 2], u32);

/// A sample of a pixel before it is traced.
struct Start {
    pixel: [u32; 2],
    sample: u32,
    position: [f64; 2],
    sampler: PixelSampler,
}

/// Samples of the pixels of a block that go together; buffers that are reused.
#[derive(Default)]
struct Block {
    starts: Vec<Start>,
    eye: EyeRays,
}

/// A tile and what is known of its noise.
struct Tile {
    region: Region,
    noise: TileNoise,
}

impl Tile {
    fn new(region: Region) -> Self {
        Self {
            region,
            noise: TileNoise::default(),
        }
    }
}

/// Outside where the eye lies beyond the supports of all blobs, meshes and spheres and above all planes, so that no
/// primary ray has to ask; unknown otherwise.
fn eye_side(frame: &Frame, bounds: &DAabb, eye: DVec3) -> Side {
    let in_bounds = bounds.min.cmple(eye).all() && eye.cmple(bounds.max).all();
    let above_planes = frame.instances.iter().all(|instance| {
        match &frame.geometries[instance.geometry as usize] {
            Geometry::Blobs(_) | Geometry::Mesh(_) | Geometry::Sphere(_) => true,
            Geometry::Plane(plane) => {
                let eye = instance.object_from_world.transform_point3(eye);
                (eye - plane.point).dot(plane.normal) > 0.0
            }
        }
    });
    if !in_bounds && above_planes {
        Side::Outside
    } else {
        Side::Unknown
    }
}
