//! Pictures whose samples a device shades by stages of its own, and what it hands back.

use crate::film::Region;
use crate::intersect::TraceError;
use crate::math::ray::Side;
use crate::math::sampling::PixelFilter;
use crate::scene::camera::Camera;
use crate::shade::{RayCounts, StagedShading, Unstaged};
use glam::Vec3;
use std::ops::Range;

/// Everything that a sample's light depends on.
#[derive(Debug, Clone)]
pub struct StagedPicture {
    /// Looks and lights.
    pub shading: StagedShading,
    /// The camera.
    pub camera: Camera,
    /// Where samples lie in their pixels.
    pub filter: PixelFilter,
    /// Samples per pixel of the whole picture.
    pub spp: u32,
    /// Seed of the sample pattern.
    pub seed: u32,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter_secs: [f64; 2],
    /// Side of every surface at the eye, where it is the same and known.
    pub eye_side: Side,
}

/// Rows of pixels that follow each other column by column, so that rays next to each other in memory lie
/// close together on the film.
pub const STRIP_ROWS: u32 = 8;

/// A rectangle of the film with some samples of each pixel, numbered sample by sample, then strip by strip
/// of [`STRIP_ROWS`] rows, then column by column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SampleBlock {
    /// The pixels.
    pub region: Region,
    /// Their samples.
    pub samples: Range<u32>,
}

impl SampleBlock {
    /// How many samples it has.
    pub fn count(&self) -> u64 {
        self.region.pixels() * u64::from(self.samples.end - self.samples.start)
    }

    /// Pixel and sample of a number.
    pub fn place(&self, number: u64) -> ([u32; 2], u32) {
        let Region {
            x,
            y,
            width,
            height,
        } = self.region;
        let pixels = self.region.pixels();
        let sample = self.samples.start + (number / pixels) as u32;
        let in_picture = (number % pixels) as u32;
        let strip = in_picture / (STRIP_ROWS * width);
        let rows = STRIP_ROWS.min(height - strip * STRIP_ROWS);
        let in_strip = in_picture % (STRIP_ROWS * width);
        let pixel = [
            x + in_strip / rows,
            y + strip * STRIP_ROWS + in_strip % rows,
        ];
        (pixel, sample)
    }
}

/// What a surface shows that a sample met first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StagedHit {
    /// Relative to [`StagedShading::origin`].
    pub position: Vec3,
    /// Unit outward normal.
    pub normal: Vec3,
    /// The instance.
    pub surface: u32,
    /// The strongest blob.
    pub blob: Option<u32>,
    /// Whether the ray goes in there.
    pub entering: bool,
}

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StagedSample {
    /// f32 could not decide one of its rays, or the stages do not know what it met: the processor has to.
    InDoubt,
    /// Done.
    Seen {
        /// As [`crate::shade::Seen::radiance`].
        radiance: Vec3,
        /// Whether something was seen, a surface or a lamp.
        is_covered: bool,
        /// The first surface.
        hit: Option<StagedHit>,
    },
}

/// Lets a device shade.
pub trait SampleStages: Sync {
    /// Readies a device for a picture.
    ///
    /// # Errors
    /// Why it cannot.
    fn start<'s>(&'s self, picture: &StagedPicture) -> Result<Box<dyn SampleRun + 's>, Unstaged>;
}

/// A picture on its way; several threads may ask for samples.
pub trait SampleRun: Sync {
    /// Samples that go together at most.
    fn together(&self) -> u64;

    /// Shades the samples `numbers` of a block, in their order; false where the device is gone and the
    /// processor may do its work.
    ///
    /// # Errors
    /// Where the device fails and may not be replaced.
    fn shade(
        &self,
        block: &SampleBlock,
        numbers: Range<u64>,
        samples: &mut Vec<StagedSample>,
        rays: &mut RayCounts,
    ) -> Result<bool, TraceError>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_of_a_block_has_one_number() {
        let region = Region {
            x: 3,
            y: 5,
            width: 7,
            height: 19,
        };
        let block = SampleBlock {
            region,
            samples: 2..4,
        };
        let mut seen = vec![0; block.count() as usize];
        for number in 0..block.count() {
            let ([x, y], sample) = block.place(number);
            let pixel = region.index(x, y).expect("it lies in the block");
            assert!(block.samples.contains(&sample));
            seen[(sample as usize - 2) * region.pixels() as usize + pixel] += 1;
        }
        assert!(seen.iter().all(|&times| times == 1));
        assert_eq!(block.place(9), ([4, 6], 2));
    }
}
