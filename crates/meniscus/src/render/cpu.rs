//! Tiles on a rayon pool: everything but the blob surfaces' answers to rays, which come from a
//! [`BlobTracer`], is made on this machine's processor.

use super::noise::{SURE_SAMPLES, TileNoise};
use super::{Backend, Progress, RenderError, RenderSettings, RenderState, RenderStats};
use crate::film::{CURVATURE, Film, MOTION, NO_INDEX, PixelSample, Region, SurfaceSample};
use crate::frame::environment::luminance;
use crate::frame::{Frame, Geometry};
use crate::intersect::{BlobTracer, Hit, OnCpu};
use crate::math::aabb::DAabb;
use crate::math::ray::{Ray, Side};
use crate::math::sampling::{PixelFilter, PixelSampler, TIME_BLOCK, part_of_shutter};
use crate::scene::camera::Camera;
use crate::shade::{EyeRays, Seen, ShadeScratch, ShadeSettings, Shader};
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
        Job::new((&OnCpu, cut), frame, camera, settings)?.run_on_threads(state, progress)
    }
}

/// Renders with blob surfaces traced by another device, and everything else by this machine's processor.
#[derive(Debug, Clone, Copy)]
pub struct DeviceBackend<'a, T: ?Sized> {
    /// What `--device` calls it.
    pub name: &'static str,
    /// Answers rays on the blobs of the frame that is rendered.
    pub tracer: &'a T,
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
        Job::new((self.tracer, ON_DEVICE), frame, camera, settings)?.run_on_threads(state, progress)
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
}

impl<'a, T> Job<'a, T>
where
    T: BlobTracer + ?Sized,
    RenderError: From<T::Error>,
{
    fn new(
        (tracer, cut): (&'a T, Cut),
        frame: &'a Frame,
        camera: &'a Camera,
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
        Ok(Self {
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
        })
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
                    let film = self.tile(tile, pass.clone(), scratch, progress)?;
                    let stats = RenderStats {
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
        scratch: &mut ShadeScratch,
        progress: &Progress<'_>,
    ) -> Result<Film, RenderError> {
        let region = tile.region;
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
        Ok(film)
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
                    let mut sampler = PixelSampler::new([x, y], sample, self.settings.seed);
                    let position =
                        self.filter
                            .film_position([x, y], self.settings.spp, &mut sampler);
                    let secs = self.time_secs([x, y], sample);
                    let ray = self.camera.ray_at(position, secs);
                    let side = self.eye_side;
                    let antialiases = self.settings.integrator.specular_antialiasing;
                    block.eye.rays.push(Ray {
                        side: side
                            .unwrap_or_else(|| eye_side(self.frame, &self.bounds, ray.origin)),
                        differential: antialiases
                            .then(|| self.camera.differential_at(position, secs)),
                        ..ray
                    });
                    block.starts.push(Start {
                        pixel: [x, y],
                        sample,
                        position,
                        sampler,
                    });
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
        let mut add = |start: &Start, time_secs: f64, seen: &Seen, attributes: &[f32]| {
            let [x, y] = start.pixel;
            let Some(pixel) = region.index(x, y) else {
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
