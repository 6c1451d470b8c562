//! When samples are taken while the shutter is open.

use super::PixelSampler;

/// Side in pixels of the blocks whose samples share strata of time.
pub const TIME_BLOCK: u32 = 4;

/// Sets the times of samples apart from their other random numbers, and those of blocks from those of
/// pixels.
const PIXEL_SEED: u32 = 0x5bd1_e995;
const BLOCK_SEED: u32 = 0x1b87_3593;

/// How much of the shutter's time is over when sample `sample` of `spp` of a pixel is taken, in [0, 1).
///
/// The shutter's time is cut into the largest power of two of strata that is no more than `spp`. In each
/// round of as many samples a pixel has one in every stratum, in an order that the pixels of a block
/// share: rays side by side see nearly the same moment, which traces them faster, and the mean of a
/// pixel's samples is that over the whole shutter. Where in the stratum a sample lies is the pixel's own.
pub fn part_of_shutter(pixel: [u32; 2], sample: u32, spp: u32, seed: u32) -> f64 {
    let own = PixelSampler::new(pixel, sample, seed ^ PIXEL_SEED).next_1d();
    let strata = f64::from(1_u32 << spp.max(1).ilog2());
    let block = pixel.map(|k| k / TIME_BLOCK);
    let shared = PixelSampler::new(block, sample, seed ^ BLOCK_SEED).next_1d();
    ((shared * strata).floor() + own) / strata
}
