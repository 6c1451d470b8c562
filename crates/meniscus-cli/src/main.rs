//! The command line: arguments → validated job → command → exit code.

mod args;
mod commands;
mod exit;
mod interrupt;
mod job;
mod progress;
mod report;
mod stats;

use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match args::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to standard output and count as done.
            let code = if error.use_stderr() { 2 } else { 0 };
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    match interrupt::watch().and_then(|()| commands::run(cli.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(message) = failure.message() {
                let _ = write!(std::io::stderr(), "{}", message.rendered());
            }
            ExitCode::from(failure.code())
        }
    }
}
