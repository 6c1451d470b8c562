//! What can go wrong with films and image files.

use super::channel::ChannelError;
use std::path::PathBuf;
use thiserror::Error;

/// Why a film could not be made, merged or written.
#[derive(Debug, Error)]
pub enum FilmError {
    /// The picture's size cannot be.
    #[error(
        "a picture of {width}x{height} pixels cannot be made: each side must be 1 to {max_side} \
         pixels and the rendered region at most {max_pixels} pixels"
    )]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Largest side.
        max_side: u32,
        /// Largest area held in memory.
        max_pixels: u64,
    },
    /// The region does not lie within the picture.
    #[error(
        "the region x={x}, y={y}, width={width}, height={height} does not lie within the picture \
         of {film_width}x{film_height} pixels"
    )]
    Region {
        /// Left edge.
        x: u32,
        /// Top edge.
        y: u32,
        /// Width.
        width: u32,
        /// Height.
        height: u32,
        /// The picture's width.
        film_width: u32,
        /// The picture's height.
        film_height: u32,
    },
    /// The machine has not enough memory.
    #[error("not enough memory for a film of {pixels} pixels with {planes} planes")]
    Memory {
        /// Pixels of the region.
        pixels: u64,
        /// Planes of the channel set.
        planes: usize,
    },
    /// A channel that cannot be had.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// Films that do not belong to one picture.
    #[error("the films differ in {what} and cannot be merged")]
    Merge {
        /// What differs.
        what: &'static str,
    },
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The noise could not be taken out.
    #[error("cannot denoise the picture: {message}")]
    Denoise {
        /// Why.
        message: String,
    },
    /// The picture cannot be stored in this format.
    #[error("cannot encode {}: {message}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
}
