//! How noisy a tile still is, by its own samples alone: so that adaptive sampling gives the same picture
//! for any number of threads.

/// Samples per pixel before noise is judged.
pub(super) const SURE_SAMPLES: u32 = 16;
/// What is added to a pixel's brightness before its noise is compared with it: black parts need not
/// be free of noise that nobody sees.
const FLOOR: f64 = 0.05;

/// Sums over the samples of each pixel of a tile.
#[derive(Debug, Clone, Default)]
pub(super) struct TileNoise {
    /// Per pixel: luminance and its square, summed.
    sums: Vec<[f64; 2]>,
    count: u32,
}

impl TileNoise {
    /// Adds the luminance of one sample of pixel `pixel`.
    pub(super) fn add(&mut self, pixel: usize, luminance: f64) {
        if self.sums.len() <= pixel {
            self.sums.resize(pixel + 1, [0.0; 2]);
        }
        self.sums[pixel][0] += luminance;
        self.sums[pixel][1] += luminance * luminance;
    }

    /// Every pixel has got this many samples more.
    pub(super) fn counted(&mut self, samples: u32) {
        self.count += samples;
    }

    /// Mean over the pixels of the standard error relative to brightness; infinite before it can be
    /// known.
    pub(super) fn relative(&self) -> f64 {
        if self.count < SURE_SAMPLES || self.sums.is_empty() {
            return f64::INFINITY;
        }
        let n = f64::from(self.count);
        let errors = self.sums.iter().map(|[sum, squares]| {
            let mean = sum / n;
            let variance = (squares / n - mean * mean).max(0.0) / (n - 1.0);
            variance.sqrt() / (mean + FLOOR)
        });
        errors.sum::<f64>() / self.sums.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_the_relative_standard_error() {
        let mut noise = TileNoise::default();
        for i in 0..64_u32 {
            noise.add(0, f64::from(i % 2));
            noise.add(1, 0.7);
        }
        assert_eq!(noise.relative(), f64::INFINITY);
        noise.counted(64);
        // Mean 1/2, standard deviation 1/2, over √63; the even pixel has none.
        let expected = 0.5 / 63.0_f64.sqrt() / 0.55 / 2.0;
        assert!((noise.relative() - expected).abs() < 1e-12);
    }
}
