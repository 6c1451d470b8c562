//! Random numbers that depend only on pixel, sample and dimension, and the shapes drawn with them.
//!
//! A [`PixelSampler`] hands out Owen-scrambled Sobol points (Burley, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4), 2020): any power of two of a pixel's samples is stratified in every pair
//! of dimensions, pixels are independent, and no state is shared, so the picture does not depend on
//! threads, tiles or the order of samples.

mod shutter;

pub use shutter::{Moments, TIME_BLOCK};

use glam::DVec3;
use std::f64::consts::{FRAC_PI_4, TAU};

/// The random numbers of one sample of one pixel, in a fixed order of dimensions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelSampler {
    pixel_seed: u64,
    index: u32,
    drawn: u32,
}

/// Sobol indices that sobol_burley supports.
const SEQUENCE_LENGTH: u32 = 1 << 16;

impl PixelSampler {
    /// The numbers of sample `sample` of `pixel`; `seed` chooses among independent pictures.
    pub fn new(pixel: [u32; 2], sample: u32, seed: u32) -> Self {
        let place = u64::from(pixel[0]) | u64::from(pixel[1]) << 32;
        let series = u64::from(seed) | u64::from(sample / SEQUENCE_LENGTH) << 32;
        Self {
            pixel_seed: mix(mix(place) ^ series),
            index: sample % SEQUENCE_LENGTH,
            drawn: 0,
        }
    }

    /// The next draw is number `draw` (from 0), whatever came before: so the same decision has the
    /// same stratified numbers in all samples of a pixel.
    pub fn skip_to(&mut self, draw: u32) {
        self.drawn = draw;
    }

    /// The next number in [0, 1).
    pub fn next_1d(&mut self) -> f64 {
        let seed = self.next_seed();
        f64::from(sobol_burley::sample(self.index, 0, seed))
    }

    /// The next point in [0, 1)².
    pub fn next_2d(&mut self) -> [f64; 2] {
        let seed = self.next_seed();
        plane_point(self.index, seed)
    }

    /// The next number in [0, 1), of which nothing is known from those of other samples: cheaper than
    /// [`PixelSampler::next_1d`].
    pub fn next_unordered(&mut self) -> f64 {
        self.drawn += 1;
        let place = u64::from(self.drawn) | u64::from(self.index + 1) << 32;
        // As many bits as an f32 holds, so that graphics cards draw the same number.
        f64::from((mix(self.pixel_seed ^ place) >> 40) as u32) * 2_f64.powi(-24)
    }

    /// The next `count` points in [0, 1)², stratified among themselves and with those of the pixel's
    /// other samples.
    pub fn next_2d_of(&mut self, count: u32) -> impl Iterator<Item = [f64; 2]> + use<> {
        let seed = self.next_seed();
        let first = u64::from(self.index) * u64::from(count);
        (first..first + u64::from(count)).map(move |index| {
            let series = index / u64::from(SEQUENCE_LENGTH);
            let index = (index % u64::from(SEQUENCE_LENGTH)) as u32;
            let seed = if series == 0 {
                seed
            } else {
                mix(u64::from(seed) ^ series << 32) as u32
            };
            plane_point(index, seed)
        })
    }

    /// Each draw is a Sobol sequence of its own, scrambled by its own seed ("padding").
    fn next_seed(&mut self) -> u32 {
        self.drawn += 1;
        (mix(self.pixel_seed ^ u64::from(self.drawn)) >> 32) as u32
    }
}

/// The first two dimensions of a Sobol point; four at once cost what one does.
fn plane_point(index: u32, seed: u32) -> [f64; 2] {
    let [x, y, ..] = sobol_burley::sample_4d(index, 0, seed);
    [f64::from(x), f64::from(y)]
}

/// A bijection of 64 bits that leaves no visible pattern (the finaliser of SplitMix64; Steele, Lea &
/// Flood 2014).
fn mix(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

/// Draws one of several things by weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Sums of the weights up to and including each.
    sums: Vec<f64>,
}

impl Distribution {
    /// Of these weights, none negative.
    pub fn new(weights: impl Iterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let sums = weights.map(|weight| {
            sum += weight;
            sum
        });
        Self {
            sums: sums.collect(),
        }
    }

    /// Sum of all weights.
    pub fn total(&self) -> f64 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The probability of `index`.
    pub fn part(&self, index: usize) -> f64 {
        let total = self.total();
        if total > 0.0 {
            self.weight(index) / total
        } else {
            0.0
        }
    }

    /// Sums of the weights up to and including each.
    pub fn sums(&self) -> &[f64] {
        &self.sums
    }

    fn weight(&self, index: usize) -> f64 {
        let before = if index == 0 {
            0.0
        } else {
            self.sums[index - 1]
        };
        self.sums[index] - before
    }

    /// What `u` in [0, 1) draws, how far `u` lies through its share (again in [0, 1)), and its
    /// probability; `None` if all weights are 0.
    pub fn sample(&self, u: f64) -> Option<(usize, f64, f64)> {
        let total = self.total();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let wanted = u * total;
        let mut index = self.sums.partition_point(|&sum| sum <= wanted);
        if index == self.sums.len() {
            // Rounding went past the end: the last thing with a weight.
            index = self.sums.partition_point(|&sum| sum < total);
        }
        let weight = self.weight(index);
        let before = self.sums[index] - weight;
        let through = ((wanted - before) / weight).clamp(0.0, 1.0 - f64::EPSILON);
        Some((index, through, weight / total))
    }
}

/// A point in the unit disk, uniform by area and continuous in `u` (Shirley & Chiu 1997).
pub fn uniform_disk(u: [f64; 2]) -> [f64; 2] {
    let [x, y] = u.map(|u| 2.0 * u - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    // In the half of the quadrants about x, or else about y.
    let about_x = x.abs() > y.abs();
    let (radius, other) = if about_x { (x, y) } else { (y, x) };
    let (sin, cos) = (FRAC_PI_4 * (other / radius)).sin_cos();
    let (along, across) = (radius * cos, radius * sin);
    if about_x {
        [along, across]
    } else {
        [across, along]
    }
}

/// A unit direction around the unit vector `normal`, with density cos θ/π (Malley's method).
pub fn cosine_hemisphere(normal: DVec3, u: [f64; 2]) -> DVec3 {
    let [x, y] = uniform_disk(u);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let [tangent, bitangent] = tangents(normal);
    tangent * x + bitangent * y + normal * z
}

/// A unit direction, uniform over the sphere.
pub fn uniform_sphere(u: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u[0];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u[1]).sin_cos();
    DVec3::new(radius * cos, radius * sin, z)
}

/// Two unit vectors that complete the unit vector `normal` to a right-handed frame (Duff et al.,
/// "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
pub fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0_f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(
            1.0 + sign * normal.x * normal.x * a,
            sign * b,
            -sign * normal.x,
        ),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// The pixel filter: a separable Blackman–Harris window of radius 1 pixel. It is sampled, not
/// weighted ("filter importance sampling", Ernst et al. 2006): a sample counts for its own pixel
/// alone, with weight 1.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelFilter {
    /// The inverse of the cumulative distribution at even steps.
    offsets: Vec<f64>,
}

impl Default for PixelFilter {
    fn default() -> Self {
        const STEPS: usize = 1024;
        let mut offsets = Vec::with_capacity(STEPS + 1);
        for step in 0..=STEPS {
            let wanted = step as f64 / STEPS as f64;
            let (mut low, mut high) = (-Self::RADIUS, Self::RADIUS);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if Self::cumulative(middle) < wanted {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            offsets.push(0.5 * (low + high));
        }
        Self { offsets }
    }
}

impl PixelFilter {
    /// Largest offset from the pixel centre along x or y, in pixels.
    pub const RADIUS: f64 = 1.0;

    /// Blackman–Harris, four terms: Σ aₖ cos(2πk t), t in [0, 1], with alternating signs folded in.
    const TERMS: [f64; 4] = [0.358_75, -0.488_29, 0.141_28, -0.011_68];

    /// Part of the window to the left of `x`.
    fn cumulative(x: f64) -> f64 {
        let t = 0.5 * (x / Self::RADIUS + 1.0);
        let [a0, rest @ ..] = Self::TERMS;
        let sines: f64 = rest
            .iter()
            .zip([1.0, 2.0, 3.0])
            .map(|(a, k)| a * (TAU * k * t).sin() / (TAU * k))
            .sum();
        t + sines / a0
    }

    /// Offsets along x or y for numbers at even steps from 0 to 1, between which the others lie.
    pub fn steps(&self) -> &[f64] {
        &self.offsets
    }

    /// The offset from the pixel centre, in pixels, for a point in [0, 1)².
    pub fn offset(&self, u: [f64; 2]) -> [f64; 2] {
        let last = self.offsets.len() - 1;
        u.map(|u| {
            let position = u * last as f64;
            let below = (position as usize).min(last - 1);
            let [a, b] = [self.offsets[below], self.offsets[below + 1]];
            a + (b - a) * (position - below as f64)
        })
    }

    /// Where the sampler's sample of `pixel` lies on the film, in pixels from the top left corner:
    /// the pixel's centre if it is the only one, a point drawn from the filter otherwise.
    pub fn film_position(
        &self,
        pixel: [u32; 2],
        samples_per_pixel: u32,
        sampler: &mut PixelSampler,
    ) -> [f64; 2] {
        let u = sampler.next_2d();
        let [dx, dy] = if samples_per_pixel == 1 {
            [0.0; 2]
        } else {
            self.offset(u)
        };
        [
            f64::from(pixel[0]) + 0.5 + dx,
            f64::from(pixel[1]) + 0.5 + dy,
        ]
    }
}

#[cfg(test)]
mod tests;
