//! `meniscus trace`.

use super::camera::CameraArgs;
use super::engine::EngineArgs;
use super::output::OutputArgs;
use super::surface::SurfaceArgs;
use super::values::Setting;
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Rays: an NPY array (n, 8) or (n, 9) of f32 or f64: origin, direction, t_min, t_max[, time].
A hit is the first t in [t_min, t_max] at which the ray crosses the surface. Rays with zero direction,
NaN or infinite parts are misses (t_max may be infinite).

Hits: an NPZ file with
  t f64 (inf: miss), normal f32 (n, 3), id i64 (row of the strongest particle, -1: miss),
  surface i32 (-1: miss), inside bool (whether the ray starts inside), and the columns named by -a
  --any: occluded bool
  --all: ray i64, t f64, entering bool, one row per crossing

Examples:
  meniscus trace fluid.vtk --rays rays.npy -o hits.npz
  meniscus trace fluid.vtk --rays rays.npy -o hits.npz -a velocity --kernel quartic -t 0.2";

/// Options of `trace`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct TraceArgs {
    /// Particle file or scene
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Rays to trace
    #[arg(long, value_name = "FILE.npy")]
    pub rays: PathBuf,
    /// File to write
    #[arg(short, long, value_name = "HITS.npz")]
    pub output: PathBuf,
    /// Only whether each ray hits anything
    #[arg(long, conflicts_with = "all")]
    pub any: bool,
    /// Every crossing of every ray
    #[arg(long)]
    pub all: bool,
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
