//! Counter-based random numbers: number `k` of stream `(seed, index)` depends on nothing else, so the
//! same rays come out for any number of threads (SplitMix64, Steele et al. 2014).

use glam::DVec3;

/// The numbers that belong to one ray or one particle.
#[derive(Debug, Clone, Copy)]
pub struct Stream {
    state: u64,
}

impl Stream {
    /// The stream of item `index` under `seed`.
    pub fn new(seed: u64, index: u64) -> Self {
        Self {
            state: mixed(mixed(seed) ^ index.wrapping_mul(0xD1B5_4A32_D192_ED03)),
        }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        mixed(self.state)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between `low` and `high` with a uniform logarithm; both must be positive.
    pub fn log_range(&mut self, low: f64, high: f64) -> f64 {
        self.range(low.ln(), high.ln()).exp()
    }

    /// Uniform among 0..count.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }

    /// Uniform in the box [0, 1)³.
    pub fn cube(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// Distributed by the cosine to `normal` over its hemisphere.
    pub fn cosine_direction(&mut self, normal: DVec3) -> DVec3 {
        (normal + self.direction() * (1.0 - 1e-9)).normalize()
    }
}

fn mixed(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::Stream;
    use glam::DVec3;

    #[test]
    fn uniform_in_mean_and_on_the_sphere() {
        let n = 20_000;
        let (mut mean, mut direction, mut up) = (0.0, DVec3::ZERO, 0.0);
        for i in 0..n {
            let mut stream = Stream::new(7, i);
            mean += stream.unit() / n as f64;
            let d = stream.direction();
            assert!((d.length() - 1.0).abs() < 1e-12);
            direction += d / n as f64;
            up += stream.cosine_direction(DVec3::Y).y / n as f64;
        }
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!(direction.length() < 0.02, "{direction}");
        // The mean cosine of a cosine-distributed direction is 2/3.
        assert!((up - 2.0 / 3.0).abs() < 0.01, "{up}");
    }
}
