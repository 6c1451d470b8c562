//! `meniscus generate`.

use super::output::OutputArgs;
use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  meniscus generate pool -o pool.vtk --count 100000
  meniscus generate splash -o 'splash_{}.vtk' --frames 25

Beside pool.vtk it writes pool.toml, a scene with surface settings, camera and light that suit:
  meniscus render pool.toml -o pool.png";

/// Options of `generate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct GenerateArgs {
    /// scattered, pool, tornado, molecule, fountain or splash
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Particle file to write: .vtk, .ply, .bgeo, .csv, .npz, .npy or .xyz; with --frames a pattern
    /// such as 'splash_{}.vtk'
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// How many particles [default: as in the papers]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub count: Option<usize>,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// How many frames, 1/25 s apart; fountain and splash move
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub frames: Option<u32>,
    /// Message options.
    #[command(flatten)]
    pub messages: OutputArgs,
}
