//! `meniscus info`.

use super::camera::CameraArgs;
use super::engine::EngineArgs;
use super::output::OutputArgs;
use super::surface::SurfaceArgs;
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  meniscus info fluid.vtk
  meniscus info 'frame_{}.vtk' --json
  meniscus info fluid.vtk --filter 'density > 900'";

/// Options of `info`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct InfoArgs {
    /// Particle file, pattern, or scene
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
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
