//! The command line as clap sees it: syntax only. What the words mean together is decided in `job/`.

pub(crate) mod bench;
pub(crate) mod camera;
pub(crate) mod engine;
pub(crate) mod generate;
pub(crate) mod info;
pub(crate) mod output;
pub(crate) mod render;
pub(crate) mod surface;
pub(crate) mod trace;
pub(crate) mod values;

use clap::{Parser, Subcommand};

/// Ray traces the smooth surface of particles: no mesh, no grid, no file in between.
#[derive(Debug, Parser)]
#[command(name = "meniscus", version, max_term_width = 100, after_help = EXAMPLES)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  meniscus generate splash -o splash.vtk         write 30,000 particles and splash.toml
  meniscus render splash.toml -o splash.png      make its picture
  meniscus render fluid.vtk -o fluid.png         a picture of your own particles, nothing to set
  meniscus info fluid.vtk                        what a file holds

Exit codes: 0 done, 1 the work failed (files, devices), 2 the command line or the scene is wrong,
130 interrupted.";

/// A command.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Make pictures of particle files or scenes.
    Render(Box<render::RenderArgs>),
    /// Say what a particle file or scene holds.
    Info(Box<info::InfoArgs>),
    /// Make particles by formula, with a ready scene file.
    Generate(generate::GenerateArgs),
    /// Trace rays from a file and write their hits.
    Trace(Box<trace::TraceArgs>),
    /// Measure how fast rays are traced.
    Bench(Box<bench::BenchArgs>),
}
