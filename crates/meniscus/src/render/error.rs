//! Why a picture could not be rendered.

use crate::film::FilmError;
use crate::intersect::TraceError;
use std::convert::Infallible;
use thiserror::Error;

/// Why a picture could not be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// The film cannot be made.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// No sample lies in the range.
    #[error("samples {start} to {end} are not within the {spp} samples per pixel, 0 to {last}", last = spp.saturating_sub(1))]
    Samples {
        /// First sample asked for.
        start: u32,
        /// Last sample asked for.
        end: u32,
        /// Samples per pixel.
        spp: u32,
    },
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {message}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why.
        message: String,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] TraceError),
    /// Somebody asked to stop.
    #[error("the rendering was cancelled")]
    Cancelled,
}

impl From<Infallible> for RenderError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}
