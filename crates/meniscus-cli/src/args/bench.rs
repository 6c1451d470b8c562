//! `meniscus bench`.

use super::camera::CameraArgs;
use super::engine::EngineArgs;
use super::output::OutputArgs;
use super::surface::SurfaceArgs;
use super::values::{Setting, Size};
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Passes: primary (one ray per pixel centre), shadow (towards the light, where the surface faces it),
hemisphere (one cosine-distributed ray per hit, in pixel order), shuffled (the same in random order).
A pass counts ray generation, traversal, hit point and normal. Figures are medians over the repeats.

meniscus bench paper [TABLE] repeats the tables gourmel-1, gourmel-3, gourmel-4 and gourmel-5 (Gourmel
et al. 2010), kanamori-1 and kanamori-clipping (Kanamori et al. 2008) and prints the papers' ratios
beside ours.

Examples:
  meniscus bench pool.toml
  meniscus bench fluid.vtk --json --size 1920x1080 --threads 1
  meniscus bench pool.toml --engine fitted-bvh --set engine.fit=false";

/// Options of `bench`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct BenchArgs {
    /// Particle file or scene
    #[arg(value_name = "INPUT", required = true)]
    pub inputs: Vec<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// How often each pass is repeated
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub repeats: u32,
    /// Trace moving particles: part of the time between two pictures that the shutter is open
    ///
    /// Rays are taken at the times of the first samples of a picture of film.spp samples a pixel, as
    /// `render` deals them: those of 4×4 pixels lie in the same of as many parts of the shutter. With
    /// --set film.spp=1 each has a time of its own.
    #[arg(long, value_name = "FRACTION", allow_hyphen_values = true)]
    pub shutter: Option<f64>,
    /// Pixels of the primary pass
    #[arg(long, value_name = "WxH", default_value_t = Size([640, 480]))]
    pub size: Size,
    /// Set any key of the scene, as in engine.cost=n (repeatable)
    #[arg(
        long = "set",
        value_name = "key.path=value",
        allow_hyphen_values = true
    )]
    pub settings: Vec<Setting>,
    /// Surface options.
    #[command(flatten)]
    pub surface: SurfaceArgs,
    /// Camera options.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Engine options.
    #[command(flatten)]
    pub engine: EngineArgs,
    /// Message options.
    #[command(flatten)]
    pub messages: OutputArgs,
}
