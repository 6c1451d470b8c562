//! Tiles on a rayon pool: everything but the blob surfaces' answers to rays, which come from a
//! [`BlobTracer`], is made on this machine's processor.

mod samples;
mod staged;

use super::noise::{SURE_SAMPLES, TileNoise};
use super::stages::{SampleRun, SampleStages};
use super::{Backend, Progress, RenderError, RenderSettings, RenderState, RenderStats, Staging};
use crate::film::{CURVATURE, Film, MOTION, Region};
use crate::frame::Frame;
use crate::intersect::{BlobTracer, OnCpu};
use crate::math::aabb::DAabb;
use crate::math::ray::Side;
use crate::math::sampling::{PixelFilter, TIME_BLOCK};
use crate::scene::camera::Camera;
use crate::shade::{ShadeScratch, ShadeSettings, Shader, Unstaged};
use glam::DVec3;
use rayon::prelude::*;
use samples::{Block, eye_side};
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
                    eye_bounds: eye_moves.then(|| camera.eye_bounds(settings.shutter_secs)),
                    shutter_secs: settings.shutter_secs,
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
