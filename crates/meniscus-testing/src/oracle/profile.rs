//! The field along one ray, in float64.

use super::bernstein::{Bernstein, Interpolation};
use crate::tolerance::FIELD;
use glam::DVec3;
use meniscus::field::BlobField;

/// One blob along the ray: q(s) = q₀ + β(s − c)².
#[derive(Debug, Clone, Copy)]
struct OnRay {
    weight: f64,
    q0: f64,
    beta: f64,
    center: f64,
    enter: f64,
    leave: f64,
}

impl OnRay {
    fn q(&self, s: f64) -> f64 {
        self.q0 + self.beta * (s - self.center) * (s - self.center)
    }
}

/// Blobs on a stretch of a ray. Its parameter s is length from a point near the blobs.
#[derive(Debug)]
pub(super) struct Profile<'a> {
    kernel: &'static [f64],
    threshold: f64,
    interpolation: &'a Interpolation,
    blobs: Vec<OnRay>,
}

impl<'a> Profile<'a> {
    pub(super) fn new(field: &BlobField, threshold: f64, interpolation: &'a Interpolation) -> Self {
        Self {
            kernel: field.kernel.coefficients_in_g(),
            threshold,
            interpolation,
            blobs: Vec::new(),
        }
    }

    /// Adds blob `i`, which stands at `p`, on the line `o + s·d` (local coordinates, |d| = 1), if the line pierces it.
    pub(super) fn add(
        &mut self,
        field: &BlobField,
        (i, p): (usize, DVec3),
        (o, d): (DVec3, DVec3),
    ) {
        let scaled_d = field.shapes.transform(i, d);
        let beta = scaled_d.length_squared();
        let center = field.shapes.transform(i, p - o).dot(scaled_d) / beta;
        // Once more from the point next to the centre: what is left of c is its rounding.
        let nearest = field.shapes.transform(i, o + d * center - p);
        let rest = nearest.dot(scaled_d) / beta;
        let q0 = (nearest - scaled_d * rest).length_squared();
        if q0 < 1.0 {
            let center = center - rest;
            let half = ((1.0 - q0) / beta).sqrt();
            self.blobs.push(OnRay {
                weight: f64::from(field.weights[i]),
                q0,
                beta,
                center,
                enter: center - half,
                leave: center + half,
            });
        }
    }

    fn k(&self, q: f64) -> f64 {
        let g = 1.0 - q;
        if g <= 0.0 {
            return 0.0;
        }
        self.kernel.iter().rev().fold(0.0, |sum, &c| sum * g + c)
    }

    /// F − T.
    pub(super) fn excess(&self, s: f64) -> f64 {
        let sum: f64 = self.blobs.iter().map(|b| b.weight * self.k(b.q(s))).sum();
        sum - self.threshold
    }

    /// The |F − T| up to which differences are excused at `s`.
    pub(super) fn band(&self, s: f64) -> f64 {
        let sum: f64 = self
            .blobs
            .iter()
            .map(|b| b.weight.abs() * self.k(b.q(s)))
            .sum();
        FIELD * sum.max(self.threshold.abs()).max(1.0)
    }

    /// Calls `see(s, above)` at `from` and wherever F − T changes sign in `[from, to]`, in order, until
    /// it returns false.
    pub(super) fn signs(&self, from: f64, to: f64, see: &mut impl FnMut(f64, bool) -> bool) {
        let mut state = None;
        let mut note = |s: f64, above: bool| {
            if state == Some(above) {
                return true;
            }
            state = Some(above);
            see(s, above)
        };
        self.signs_of(&self.blobs, from, to, &mut note);
    }

    fn signs_of(
        &self,
        blobs: &[OnRay],
        from: f64,
        to: f64,
        see: &mut impl FnMut(f64, bool) -> bool,
    ) -> bool {
        let here: Vec<OnRay> = blobs
            .iter()
            .filter(|b| b.enter < to && b.leave > from)
            .copied()
            .collect();
        let (mut least, mut most) = (0.0, 0.0);
        for b in &here {
            let near = self.k(b.q(b.center.clamp(from, to)));
            let far = self.k(b.q(from)).min(self.k(b.q(to)));
            let (low, high) = if b.weight > 0.0 {
                (far, near)
            } else {
                (near, far)
            };
            least += b.weight * low;
            most += b.weight * high;
        }
        if most <= self.threshold {
            return see(from, false);
        }
        if least > self.threshold {
            return see(from, true);
        }
        let mut events: Vec<f64> = here
            .iter()
            .flat_map(|b| [b.enter, b.leave])
            .filter(|&s| s > from && s < to)
            .collect();
        if events.is_empty() {
            let polynomial = self.polynomial(&here, from, to);
            let mut go_on = true;
            polynomial.signs(&mut |u, above| {
                go_on = go_on && see(from + u * (to - from), above);
            });
            return go_on;
        }
        let middle = events.len() / 2;
        let at = *events.select_nth_unstable_by(middle, f64::total_cmp).1;
        self.signs_of(&here, from, at, see) && self.signs_of(&here, at, to, see)
    }

    /// F − T on a stretch without events.
    fn polynomial(&self, blobs: &[OnRay], from: f64, to: f64) -> Bernstein {
        let value = |u: &f64| {
            let s = from + u * (to - from);
            let sum: f64 = blobs.iter().map(|b| b.weight * self.k(b.q(s))).sum();
            sum - self.threshold
        };
        let values: Vec<f64> = self.interpolation.nodes.iter().map(value).collect();
        self.interpolation.through(&values)
    }

    /// Whether |F − T| stays within [`Profile::band`] on all of `[from, to]`, and the largest |F − T|
    /// that was met on the way.
    pub(super) fn stays_in_band(&self, from: f64, to: f64) -> (bool, f64) {
        let mut seams: Vec<f64> = self
            .blobs
            .iter()
            .flat_map(|b| [b.enter, b.leave])
            .filter(|&s| s > from && s < to)
            .chain([from, to])
            .collect();
        seams.sort_by(f64::total_cmp);
        let mut worst = 0.0_f64;
        for pair in seams.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let here: Vec<OnRay> = self
                .blobs
                .iter()
                .filter(|blob| blob.enter < b && blob.leave > a)
                .copied()
                .collect();
            let mut open = vec![(self.polynomial(&here, a, b), a, b, 0)];
            while let Some((polynomial, a, b, depth)) = open.pop() {
                let (excess_a, excess_b) = (self.excess(a).abs(), self.excess(b).abs());
                let (band_a, band_b) = (self.band(a), self.band(b));
                worst = worst.max(excess_a).max(excess_b);
                let within = |c: &f64| c.abs() <= band_a.min(band_b);
                if polynomial.coefficients().iter().all(within) {
                    continue;
                }
                if excess_a > band_a || excess_b > band_b || depth > 40 {
                    return (false, worst);
                }
                let (left, right) = polynomial.halves();
                let middle = 0.5 * (a + b);
                open.push((right, middle, b, depth + 1));
                open.push((left, a, middle, depth + 1));
            }
        }
        (true, worst)
    }
}
