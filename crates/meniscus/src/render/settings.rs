//! What to render, and what it took.

use crate::film::{ChannelSet, Region};
use crate::intersect::Counters;
use crate::scene::{Background, IntegratorSettings};
use crate::shade::{RayCounts, Unstaged};
use std::ops::Range;
use std::sync::Arc;
use std::time::Duration;

/// What to render; the picture's size is the camera's.
#[derive(Debug, Clone)]
pub struct RenderSettings {
    /// The rectangle to render; `None`: the whole picture.
    pub region: Option<Region>,
    /// Samples per pixel of the whole picture; 1 samples pixel centres.
    pub spp: u32,
    /// The samples to render, within `0..spp`; `None`: all.
    pub samples: Option<Range<u32>>,
    /// Seed of the sample pattern.
    pub seed: u32,
    /// Channels of the film.
    pub channels: Arc<ChannelSet>,
    /// What stands behind the surfaces.
    pub background: Background,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter_secs: [f64; 2],
    /// How light is gathered.
    pub integrator: IntegratorSettings,
    /// Adaptive sampling: relative noise at which a tile is done, see
    /// [`crate::scene::FilmSettings::noise`]. `spp` is the most then, and tiles are cut from the
    /// region, so the picture depends on it.
    pub noise: Option<f64>,
    /// Stops adding samples when this much time is over; every pixel gets at least one.
    pub time_limit: Option<Duration>,
    /// Threads; `None`: as many as the global pool has.
    pub threads: Option<usize>,
}

impl Default for RenderSettings {
    /// Everything, 16 samples per pixel, colour and depth, before the sky.
    fn default() -> Self {
        Self {
            region: None,
            spp: 16,
            samples: None,
            seed: 0,
            channels: Arc::new(ChannelSet::default()),
            background: Background::Sky,
            shutter_secs: [0.0; 2],
            integrator: IntegratorSettings::default(),
            noise: None,
            time_limit: None,
            threads: None,
        }
    }
}

/// What a rendering took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RenderStats {
    /// Rays by purpose.
    pub rays: RayCounts,
    /// Work of the engines.
    pub counters: Counters,
    /// Threads that rendered.
    pub threads: usize,
    /// Wall-clock time.
    pub seconds: f64,
    /// Who shaded, where a device traced.
    pub staging: Option<Staging>,
}

/// Who shaded a picture that a device traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Staging {
    /// The device's own stages.
    Device {
        /// Samples in all.
        samples: u64,
        /// Samples among them that the processor did.
        on_cpu: u64,
    },
    /// The processor, and why.
    Processor(Unstaged),
}

impl Staging {
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (
                Self::Device { samples, on_cpu },
                Self::Device {
                    samples: more,
                    on_cpu: more_on_cpu,
                },
            ) => Self::Device {
                samples: samples + more,
                on_cpu: on_cpu + more_on_cpu,
            },
            (Self::Processor(why), _) | (_, Self::Processor(why)) => Self::Processor(why),
        }
    }
}

impl RenderStats {
    pub(super) fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.counters += other.counters;
        self.staging = match (self.staging, other.staging) {
            (Some(a), Some(b)) => Some(a.and(b)),
            (a, b) => a.or(b),
        };
    }
}
