//! Why a graphics card cannot be used.

use meniscus::intersect::TraceError;
use thiserror::Error;

/// Why a graphics card cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GpuError {
    /// There is no adapter that may be used.
    #[error("there is no graphics card to trace on{seen}")]
    NoAdapter {
        /// What was found instead, ready to follow the sentence; or nothing.
        seen: String,
    },
    /// The driver refused.
    #[error("{adapter} cannot be used: {message}")]
    Refused {
        /// The adapter's name.
        adapter: String,
        /// What the driver says.
        message: String,
    },
    /// A frame does not fit.
    #[error(
        "{adapter} has too little memory for {bytes} bytes of particles and their tree: {message}"
    )]
    TooLarge {
        /// The adapter's name.
        adapter: String,
        /// What was wanted.
        bytes: u64,
        /// What limits it.
        message: String,
    },
    /// Engine `peel` cannot do this.
    #[error("engine peel cannot trace {what}")]
    Unfit {
        /// What it is asked for.
        what: &'static str,
    },
    /// The device was lost, or failed at its work.
    #[error("{adapter} was lost: {message}")]
    Lost {
        /// The adapter's name.
        adapter: String,
        /// What the driver says.
        message: String,
    },
}

impl From<GpuError> for TraceError {
    fn from(error: GpuError) -> Self {
        Self {
            message: error.to_string(),
        }
    }
}
