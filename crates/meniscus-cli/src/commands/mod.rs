//! The commands, each from its arguments to its outcome.

mod bench;
mod generate;
mod info;
mod render;
mod trace;

use crate::args::Command;
use crate::exit::Outcome;

/// Runs a command.
pub(crate) fn run(command: Command) -> Outcome {
    match command {
        Command::Render(args) => render::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Trace(args) => trace::run(&args),
        Command::Bench(args) => bench::run(&args),
    }
}
