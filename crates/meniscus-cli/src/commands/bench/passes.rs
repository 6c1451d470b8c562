//! The four passes that are measured.

use crate::exit::Outcome;
use crate::interrupt;
use crate::job::device::{Tracing, trace_failure};
use crate::progress::Reporter;
use meniscus::frame::Frame;
use meniscus::intersect::{Counters, Hit, Scratch, TraceError};
use meniscus::math::DVec3;
use meniscus::math::ray::{Ray, Side};
use meniscus::math::sampling::{PixelSampler, TIME_BLOCK, cosine_hemisphere};
use meniscus::scene::camera::Camera;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;

/// Rays that one task traces: with their answers they stay in the caches next to a core.
const CHUNK: usize = 256;
/// Side in pixels of the blocks that primary rays are made in: those in which `render` traces.
const BLOCK: u32 = TIME_BLOCK;
/// Seed of the hemisphere's directions and of the shuffle.
const SEED: u32 = 1;

/// One pass, as printed.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct PassFigures {
    /// Rays of one repeat.
    pub rays: u64,
    /// Median time of one repeat.
    pub secs: f64,
    /// Million rays a second, from the median time.
    pub mrays_per_sec: f64,
    /// The same from the best time.
    pub best_mrays_per_sec: f64,
    /// Part of the rays that hit.
    pub hit_fraction: f64,
    /// On a card: million rays a second by its own clock, from the median time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_mrays_per_sec: Option<f64>,
}

/// What was measured.
#[derive(Debug)]
pub(crate) struct Measured {
    /// One ray per pixel centre.
    pub primary: PassFigures,
    /// Towards the light.
    pub shadow: PassFigures,
    /// One cosine-distributed ray per hit, in pixel order.
    pub hemisphere: PassFigures,
    /// The same in random order.
    pub shuffled: PassFigures,
    /// Work of one primary pass.
    pub counters: Counters,
    /// Memory of the structures after a frame with shadows, in bytes.
    pub structure_bytes: usize,
    /// Time that threads spent on refining structures for that frame, summed over them.
    pub refinement_secs: f64,
}

/// What to measure.
pub(crate) struct Bench<'a> {
    /// The surfaces.
    pub frame: &'a Frame,
    /// What traces them.
    pub tracing: &'a Tracing<'a>,
    /// Where primary rays start.
    pub camera: &'a Camera,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter_secs: [f64; 2],
    /// Samples a pixel of the picture that the rays are the first sample of: it says at what times
    /// `render` takes it. With 1 each ray has a time of its own.
    pub spp: u32,
    /// Where shadow rays go.
    pub towards_light: DVec3,
    /// How often.
    pub repeats: u32,
    /// Who is told.
    pub reporter: &'a Reporter,
}

/// Where a secondary ray starts.
#[derive(Debug, Clone, Copy)]
struct Start {
    position: DVec3,
    normal: DVec3,
    pixel: [u32; 2],
}

/// The middle value; sorts.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    match count {
        0 => 0.0,
        _ if count % 2 == 1 => values[count / 2],
        _ => 0.5 * (values[count / 2 - 1] + values[count / 2]),
    }
}

impl Bench<'_> {
    /// Measures primary rays alone.
    pub(crate) fn primary(&self) -> Outcome<(PassFigures, Counters)> {
        let (figures, _, counters) = self.primary_pass()?;
        Ok((figures, counters))
    }

    /// One ray per pixel, and where they hit.
    fn primary_pass(&self) -> Outcome<(PassFigures, Vec<Option<Start>>, Counters)> {
        let [width, height] = self.camera.size;
        self.pass(
            0,
            &in_blocks(width, height),
            #[inline(always)]
            |&pixel| self.primary_ray(pixel),
            |rays, hits, scratch| self.closest(rays, hits, scratch),
            start_at,
        )
    }

    fn closest(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        scratch: &mut Scratch,
    ) -> Result<(), TraceError> {
        self.tracing.closest_hits(self.frame, rays, hits, scratch)
    }

    /// The ray from a hit, at the time of the one that found it.
    #[inline(always)]
    fn leaving_surface(&self, start: &Start, direction: DVec3) -> Ray {
        Ray {
            time: self.time_secs(start.pixel),
            ..Ray::new(start.position, direction).with_side(Side::Outside)
        }
    }

    /// The ray through the centre of a pixel.
    #[inline(always)]
    fn primary_ray(&self, [x, y]: [u32; 2]) -> Ray {
        let secs = self.time_secs([x, y]);
        let film = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        self.camera.ray_at(film, secs)
    }

    /// A ray from a hit into the hemisphere above it.
    #[inline(always)]
    fn hemisphere_ray(&self, start: &Start) -> Ray {
        let mut sampler = PixelSampler::new(start.pixel, 0, SEED);
        let u = [sampler.next_unordered(), sampler.next_unordered()];
        self.leaving_surface(start, cosine_hemisphere(start.normal, u))
    }

    /// When the first sample of a pixel is taken.
    #[inline(always)]
    fn time_secs(&self, pixel: [u32; 2]) -> f64 {
        let [open, close] = self.shutter_secs;
        if open == close {
            return open;
        }
        open + (close - open) * part_of_shutter(pixel, self.spp)
    }

    /// Measures all passes.
    pub(crate) fn run(&self) -> Outcome<Measured> {
        let (primary, starts, counters) = self.primary_pass()?;
        let starts: Vec<Start> = starts.into_iter().flatten().collect();
        let lit: Vec<Start> = starts
            .iter()
            .filter(|start| start.normal.dot(self.towards_light) > 0.0)
            .copied()
            .collect();
        let blocked = |rays: &[Ray], hits: &mut [bool], scratch: &mut Scratch| {
            self.tracing.any_hits(self.frame, rays, hits, scratch)
        };
        let (shadow, ..) = self.pass(
            1,
            &lit,
            #[inline(always)]
            |start| self.leaving_surface(start, self.towards_light),
            blocked,
            |_, &is_hit| is_hit.then_some(()),
        )?;

        let structure_bytes = self.frame.structure_bytes();
        let refinement_secs = self.frame.refinement_secs();

        let is_hit = |_: &Start, hit: &Option<Hit>| hit.as_ref().map(|_| ());
        let (hemisphere, ..) = self.pass(
            2,
            &starts,
            #[inline(always)]
            |start| self.hemisphere_ray(start),
            |rays, hits, scratch| self.closest(rays, hits, scratch),
            is_hit,
        )?;
        let mut shuffled = starts;
        shuffle(&mut shuffled);
        let (shuffled, ..) = self.pass(
            3,
            &shuffled,
            #[inline(always)]
            |start| self.hemisphere_ray(start),
            |rays, hits, scratch| self.closest(rays, hits, scratch),
            is_hit,
        )?;
        Ok(Measured {
            primary,
            shadow,
            hemisphere,
            shuffled,
            counters,
            structure_bytes,
            refinement_secs,
        })
    }

    /// One pass, `repeats` times: rays are made, traced and answered, and of the answers to hits is kept
    /// what `keep` wants, all within the measured time. What was kept and the counted work are those of
    /// one repeat.
    fn pass<T: Sync, A: Clone + Default + Send, B: Clone + Send>(
        &self,
        pass: u64,
        items: &[T],
        ray_of: impl Fn(&T) -> Ray + Sync,
        trace: impl Fn(&[Ray], &mut [A], &mut Scratch) -> Result<(), TraceError> + Sync,
        keep: impl Fn(&T, &A) -> Option<B> + Sync,
    ) -> Outcome<(PassFigures, Vec<Option<B>>, Counters)> {
        let (mut times, mut device_times) = (Vec::new(), Vec::new());
        let together = self.tracing.together(CHUNK);
        let mut kept = vec![None; items.len()];
        let mut counters = Counters::default();
        for repeat in 0..self.repeats {
            interrupt::check()?;
            let device_before = self.tracing.device_secs().unwrap_or(0.0);
            let start = Instant::now();
            counters = items
                .par_chunks(together)
                .zip(kept.par_chunks_mut(together))
                .map_init(
                    <(Vec<Ray>, Vec<A>, Scratch)>::default,
                    |(rays, answers, scratch), (items, kept)| {
                        rays.clear();
                        rays.extend(items.iter().map(&ray_of));
                        answers.resize(items.len(), A::default());
                        trace(rays, answers, scratch)?;
                        for ((item, answer), kept) in items.iter().zip(&*answers).zip(kept) {
                            *kept = keep(item, answer);
                        }
                        Ok(std::mem::take(&mut scratch.counters))
                    },
                )
                .try_reduce(Counters::default, |mut sum, part| {
                    sum += part;
                    Ok(sum)
                })
                .map_err(|error| trace_failure(&error))?;
            times.push(start.elapsed().as_secs_f64());
            let device_secs = self.tracing.device_secs();
            device_times.extend(device_secs.map(|secs| secs - device_before));
            let done = pass * u64::from(self.repeats) + u64::from(repeat) + 1;
            self.reporter.advance(done, 4 * u64::from(self.repeats));
        }
        let secs = median(&mut times);
        let rays = items.len() as u64;
        let rate = |secs: f64| {
            if secs > 0.0 {
                rays as f64 / secs * 1e-6
            } else {
                0.0
            }
        };
        let hits = kept.iter().flatten().count();
        let figures = PassFigures {
            rays,
            secs,
            mrays_per_sec: rate(secs),
            best_mrays_per_sec: rate(times.first().copied().unwrap_or(0.0)),
            hit_fraction: hits as f64 / rays.max(1) as f64,
            device_mrays_per_sec: (!device_times.is_empty())
                .then(|| rate(median(&mut device_times))),
        };
        Ok((figures, kept, counters))
    }
}

/// Where secondary rays start behind a pixel's hit.
fn start_at(&pixel: &[u32; 2], hit: &Option<Hit>) -> Option<Start> {
    hit.map(|hit| Start {
        position: hit.position,
        normal: hit.normal,
        pixel,
    })
}

/// The pixels of an image, block after block of 4 × 4, so that neighbours follow each other.
fn in_blocks(width: u32, height: u32) -> Vec<[u32; 2]> {
    let mut pixels: Vec<[u32; 2]> = (0..height)
        .flat_map(|y| (0..width).map(move |x| [x, y]))
        .collect();
    pixels.sort_by_key(|[x, y]| (y / BLOCK, x / BLOCK, y % BLOCK, x % BLOCK));
    pixels
}

/// How much of the shutter's time is over when the first of `spp` samples of a pixel is taken: dealt as
/// [`meniscus::math::sampling::Moments`] does, by simpler random numbers.
#[inline(always)]
fn part_of_shutter([x, y]: [u32; 2], spp: u32) -> f64 {
    let random = |x: u32, y: u32| {
        let mixed = (x.wrapping_mul(0x9e37_79b1) ^ y).wrapping_mul(0x85eb_ca77);
        f64::from(mixed ^ mixed >> 15) * 2_f64.powi(-32)
    };
    let strata = f64::from(1_u32 << spp.max(1).ilog2());
    let shared = random(x / TIME_BLOCK, !(y / TIME_BLOCK));
    ((shared * strata).floor() + random(x, y)) / strata
}

/// Fisher and Yates, with a fixed seed.
fn shuffle<T>(items: &mut [T]) {
    for i in (1..items.len()).rev() {
        let random = PixelSampler::new([i as u32, 0], 0, SEED).next_1d();
        let j = (random * (i + 1) as f64) as usize;
        items.swap(i, j.min(i));
    }
}
