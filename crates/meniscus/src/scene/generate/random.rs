//! Portable random numbers: PCG64, whose streams are fixed by its specification (O'Neill 2014).

use glam::DVec3;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// A seeded stream of random numbers.
pub(super) struct Random(Pcg64);

impl Random {
    /// The stream of `seed`.
    pub(super) fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Uniform in [0, 1), from 53 random bits.
    pub(super) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Each coordinate uniform in [−extent, extent).
    pub(super) fn in_cube(&mut self, extent: f64) -> DVec3 {
        let x = self.range(-extent, extent);
        let y = self.range(-extent, extent);
        let z = self.range(-extent, extent);
        DVec3::new(x, y, z)
    }

    /// Uniform in the unit ball.
    pub(super) fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = self.in_cube(1.0);
            if point.length_squared() < 1.0 {
                return point;
            }
        }
    }

    /// An integer uniform in 0..`n` (the bias of 2⁻⁵³·n does not matter here).
    pub(super) fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
}
