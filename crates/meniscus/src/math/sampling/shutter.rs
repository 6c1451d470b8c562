//! When samples are taken while the shutter is open.

use super::PixelSampler;

/// Side in pixels of the blocks whose samples share strata of time.
pub const TIME_BLOCK: u32 = 4;

/// Sets the times of samples apart from their other random numbers, and those of blocks from those of
/// pixels.
const PIXEL_SEED: u32 = 0x5bd1_e995;
const BLOCK_SEED: u32 = 0x1b87_3593;

/// Deals samples their times while the shutter is open.
///
/// The shutter's time is cut into the largest power of two of strata that is no more than the samples of
/// a pixel. In each round of as many samples a pixel has one in every stratum, in an order that the pixels
/// of a block share: rays side by side see nearly the same moment, which traces them faster, and the mean
/// of a pixel's samples is that over the whole shutter. Where in the stratum a sample lies is its own.
#[derive(Debug, Clone)]
pub struct Moments {
    strata: f64,
    seed: u32,
    /// The block and sample that were asked about last, and their stratum.
    last: Option<([u32; 2], u32, f64)>,
}

impl Moments {
    /// Of pictures with `spp` samples a pixel; `seed` chooses among independent ones.
    pub fn new(spp: u32, seed: u32) -> Self {
        Self {
            strata: f64::from(1_u32 << spp.max(1).ilog2()),
            seed,
            last: None,
        }
    }

    /// How much of the shutter's time is over when sample `sample` of a pixel is taken, in [0, 1).
    pub fn part_of_shutter(&mut self, pixel: [u32; 2], sample: u32) -> f64 {
        let own = PixelSampler::new(pixel, sample, self.seed ^ PIXEL_SEED).next_unordered();
        (self.stratum(pixel, sample) + own) / self.strata
    }

    fn stratum(&mut self, pixel: [u32; 2], sample: u32) -> f64 {
        let block = pixel.map(|k| k / TIME_BLOCK);
        match self.last {
            Some((last_block, last_sample, stratum))
                if (last_block, last_sample) == (block, sample) =>
            {
                stratum
            }
            _ => {
                let shared = PixelSampler::new(block, sample, self.seed ^ BLOCK_SEED).next_1d();
                let stratum = (shared * self.strata).floor();
                self.last = Some((block, sample, stratum));
                stratum
            }
        }
    }
}
