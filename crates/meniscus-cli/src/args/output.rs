//! What is said while working.

use clap::{Args, ValueEnum};

/// How progress is shown, always on standard error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum ProgressMode {
    /// A bar where standard error is a terminal, nothing elsewhere
    #[default]
    Auto,
    /// A bar
    Bar,
    /// One JSON object per line: event (start, frame, progress, frame_done, warning, done), and with
    /// progress stage, fraction, elapsed_secs, remaining_secs
    Json,
    /// Nothing
    None,
}

/// Message options.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Messages")]
pub(crate) struct OutputArgs {
    /// How to show progress (on standard error)
    #[arg(long, value_enum, default_value_t, value_name = "MODE")]
    pub progress: ProgressMode,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say what is being done, and how long each step took
    #[arg(short, long)]
    pub verbose: bool,
}
