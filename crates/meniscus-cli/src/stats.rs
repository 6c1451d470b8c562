//! What `--stats` writes. The keys are fixed: measurements read them.

use serde::Serialize;

/// One frame.
#[derive(Debug, Clone, Default, Serialize)]
pub(crate) struct FrameStats {
    /// Particles in the picture, after filter and dropping.
    pub particles: usize,
    /// Particles dropped because their numbers were unusable.
    pub dropped: usize,
    /// Where it was rendered.
    pub device: &'static str,
    /// Engine.
    pub engine: &'static str,
    /// SIMD level.
    pub simd: &'static str,
    /// Threads.
    pub threads: usize,
    /// Kernel of the first surface.
    pub kernel: &'static str,
    /// Threshold of the first surface.
    pub threshold: f64,
    /// Weights of the first surface.
    pub weights: String,
    /// Median distance of nearest neighbours in the first surface.
    pub spacing: Option<f64>,
    /// Smallest support radius.
    pub support_min: f64,
    /// Largest support radius.
    pub support_max: f64,
    /// Size of the picture.
    pub image: ImageStats,
    /// Reading and decoding files.
    pub read_secs: f64,
    /// Field (weights included) and acceleration structure.
    pub build_secs: f64,
    /// Tracing and shading.
    pub render_secs: f64,
    /// Time of the graphics card by its own clock; left out where none worked or it keeps none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device_secs: Option<f64>,
    /// Developing and writing.
    pub write_secs: f64,
    /// From start to end of the frame.
    pub total_secs: f64,
    /// Memory of the acceleration structures.
    pub structure_bytes: usize,
    /// Most memory that the process held so far; null where the system does not say.
    pub peak_rss_bytes: Option<u64>,
    /// Rays by purpose.
    pub rays: RayStats,
}

/// Size of a picture.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct ImageStats {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples per pixel; the most where sampling may end early.
    pub spp: u32,
    /// Samples that a pixel got on average.
    pub mean_samples: f64,
}

/// Rays by purpose.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct RayStats {
    /// From the camera.
    pub primary: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Through surfaces.
    pub refraction: u64,
    /// For ambient occlusion.
    pub ambient_occlusion: u64,
    /// Diffuse bounces.
    pub diffuse: u64,
}

/// Most memory that this process held so far, from Linux's `/proc`.
pub(crate) fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}
