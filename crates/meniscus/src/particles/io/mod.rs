//! Particle files. The format is told by content, never by the file's ending.
//!
//! To add a format: one file beside these with `fn read(bytes, frame) -> Result<Parsed, ParseError>`
//! and one line in [`Format`] and in its tables.

pub mod error;

pub use error::{ParseError, Place, ReadError};

use super::Particles;

/// What a reader found in the bytes of one file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parsed {
    /// The particles of the frame asked for.
    pub particles: Particles,
    /// How many frames (time steps) the file holds.
    pub frames: usize,
    /// What a user should know, one sentence each.
    pub warnings: Vec<String>,
}
