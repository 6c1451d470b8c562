//! Polynomials in Bézier form and their first rise through zero (Nishita, Sederberg & Kakimoto 1990).
//!
//! A curve lies in the convex hull of its control points. So where no control value is positive the
//! curve is not, and outside the stretch where the hull meets the axis there is no root: nothing is
//! skipped. Where clipping is slow (several roots, double roots) the curve is halved, and what is
//! narrower than [`NARROWEST`] is settled by its ends.

use super::events::Active;
use crate::intersect::Counters;
use crate::kernel::KernelShape;

/// Control values of the highest degree in use: 2·4, a parabola to the fourth power.
pub(super) const MAX_COEFFICIENTS: usize = 9;
/// Pieces narrower than this fraction of the curve are not divided any further.
pub(super) const NARROWEST: f64 = 1e-14;
/// Clipping that leaves more than this of a piece is followed by halving.
const SLOW: f64 = 0.6;
/// What clipping leaves beside the hull's crossings for rounding (Campagna, Slusallek & Seidel 1997).
const CLIP_MARGIN: f64 = 1e-12;

/// A polynomial over [0, 1] by its Bernstein coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bezier {
    /// Coefficients; those beyond the degree are unused.
    pub(super) c: [f64; MAX_COEFFICIENTS],
    /// Degree, at least 1.
    pub(super) degree: usize,
}

/// F − T between two neighbouring events, as a curve over [0, 1].
///
/// In the interval's own parameter one blob's g has the Bernstein coefficients g(from),
/// g₀ − β(from − c)(to − c), g(to). Coefficients times binomials multiply like those of a polynomial,
/// which makes k(g) a short Horner scheme.
pub(super) fn expand<K: KernelShape>(
    threshold: f64,
    active: &[Active],
    (from, to): (f64, f64),
) -> Bezier {
    const { assert!(2 * K::IN_G.len() - 1 <= MAX_COEFFICIENTS) };
    let power = K::IN_G.len() - 1;
    let degree = 2 * power;
    let mut sum = [0.0; MAX_COEFFICIENTS];
    for blob in active {
        let middle = blob.g0 - blob.beta * (from - blob.center) * (to - blob.center);
        let g = [
            blob.g(from).max(0.0),
            2.0 * middle.max(0.0),
            blob.g(to).max(0.0),
        ];
        let mut k = [0.0; MAX_COEFFICIENTS];
        k[0] = K::IN_G[power];
        for p in (0..power).rev() {
            let mut product = [0.0; MAX_COEFFICIENTS];
            let factors = 2 * (power - p) - 1;
            for (i, &a) in k[..factors].iter().enumerate() {
                for (j, &b) in g.iter().enumerate() {
                    product[i + j] += a * b;
                }
            }
            if K::IN_G[p] != 0.0 {
                for (i, a) in product[..factors + 2].iter_mut().enumerate() {
                    *a += K::IN_G[p] * binomial(factors + 1, i);
                }
            }
            k = product;
        }
        for (total, k) in sum.iter_mut().zip(k) {
            *total += blob.weight * k;
        }
    }
    for (i, c) in sum[..=degree].iter_mut().enumerate() {
        *c = *c / binomial(degree, i) - threshold;
    }
    Bezier { c: sum, degree }
}

/// k(g) for g ≥ 0 from the coefficients that [`expand`] uses, so that both agree to rounding.
pub(super) fn kernel_of<K: KernelShape>(g: f64) -> f64 {
    K::IN_G.iter().rev().fold(0.0, |sum, &c| sum * g + c)
}

pub(super) fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, i| b * (n - i) as f64 / (i + 1) as f64)
}

/// Part of a curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) curve: Bezier,
    low: f64,
    high: f64,
}

impl Bezier {
    /// The coefficients in use.
    pub(super) fn coefficients(&self) -> &[f64] {
        &self.c[..=self.degree]
    }

    /// Value at the right end.
    fn last(&self) -> f64 {
        self.c[self.degree]
    }

    /// The curve with the opposite sign.
    pub(super) fn negated(mut self) -> Self {
        self.c.iter_mut().for_each(|c| *c = -*c);
        self
    }

    /// The parts left and right of `u` by de Casteljau's algorithm, each over [0, 1].
    pub(super) fn split(&self, u: f64) -> (Self, Self) {
        let n = self.degree;
        let (mut left, mut right) = (*self, *self);
        for level in 0..=n {
            left.c[level] = right.c[0];
            for i in 0..n - level {
                right.c[i] = (1.0 - u) * right.c[i] + u * right.c[i + 1];
            }
        }
        (left, right)
    }

    /// Value and slope at `u`.
    fn value_and_slope(&self, u: f64) -> (f64, f64) {
        let mut c = self.c;
        let n = self.degree;
        for level in 1..n {
            for i in 0..=n - level {
                c[i] = (1.0 - u) * c[i] + u * c[i + 1];
            }
        }
        ((1.0 - u) * c[0] + u * c[1], (c[1] - c[0]) * n as f64)
    }

    /// Whether the coefficients are first ≤ 0 and then > 0: exactly one root, by Descartes' rule.
    fn rises_once(&self) -> bool {
        let rise = self.coefficients().iter().position(|&c| c > 0.0);
        rise.is_some_and(|at| at > 0 && self.coefficients()[at..].iter().all(|&c| c > 0.0))
    }

    /// How often the control values change sign, 0 counting as negative.
    pub(super) fn sign_changes(&self) -> usize {
        let signs = self.coefficients().windows(2);
        signs
            .filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0))
            .count()
    }

    /// Where the hull of the control points meets the axis, widened by `margin`; both signs must occur.
    pub(super) fn hull_on_axis(&self, margin: f64) -> (f64, f64) {
        let n = self.degree;
        let (mut low, mut high) = (1.0_f64, 0.0_f64);
        for i in 0..n {
            for j in i + 1..=n {
                let (a, b) = (self.c[i], self.c[j]);
                if (a > 0.0) != (b > 0.0) {
                    let x = (i as f64 + (j - i) as f64 * (a / (a - b))) / n as f64;
                    low = low.min(x);
                    high = high.max(x);
                }
            }
        }
        (low - margin, high + margin)
    }

    /// The only root of a curve that rises once: Newton's method kept within the bracket.
    fn only_root(&self) -> f64 {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        let (first, last) = (self.c[0], self.last());
        let mut x = (first / (first - last)).clamp(0.0, 1.0);
        let mut last_step = 1.0_f64;
        for _ in 0..200 {
            let (value, slope) = self.value_and_slope(x);
            if value > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - value / slope;
            let slow = (newton - x).abs() > 0.5 * last_step;
            let next = if newton > low && newton < high && !slow {
                newton
            } else {
                0.5 * (low + high)
            };
            last_step = (next - x).abs();
            x = next;
            if last_step <= f64::EPSILON || high - low <= f64::EPSILON {
                break;
            }
        }
        x
    }
}

impl Piece {
    /// All of a curve.
    pub(super) fn whole(curve: Bezier) -> Self {
        Self {
            curve,
            low: 0.0,
            high: 1.0,
        }
    }

    /// Length in the whole curve's parameter.
    pub(super) fn width(&self) -> f64 {
        self.high - self.low
    }

    /// Middle in the whole curve's parameter.
    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// The part between `from` and `to` in [0, 1] of this piece, by de Casteljau's algorithm alone.
    pub(super) fn part(&self, from: f64, to: f64) -> Self {
        let rest = self.curve.split(from).1;
        let share = if from < 1.0 {
            (to - from) / (1.0 - from)
        } else {
            1.0
        };
        Self {
            curve: rest.split(share).0,
            low: self.low + from * self.width(),
            high: self.low + to * self.width(),
        }
    }

    /// The part between `from` and `to` in [0, 1] of this piece, where the signs at both ends are
    /// known to be those of this piece's ends.
    fn clipped(&self, from: f64, to: f64) -> Self {
        let (from, to) = (from.max(0.0), to.min(1.0));
        let mut curve = self.curve.split(from).1;
        curve = curve.split((to - from) / (1.0 - from)).0;
        let n = curve.degree;
        curve.c[0] = curve.c[0].min(0.0);
        curve.c[n] = if self.curve.last() > 0.0 {
            curve.c[n].max(f64::MIN_POSITIVE)
        } else {
            curve.c[n].min(0.0)
        };
        let width = self.high - self.low;
        Self {
            curve,
            low: self.low + from * width,
            high: self.low + to * width,
        }
    }
}

/// The first u in [0, 1] at which the curve turns positive by more than `noise`. The curve must start
/// at or below `noise`; where it starts higher the answer is 0. A touch from below is no rise.
pub(super) fn first_rise(
    curve: &Bezier,
    noise: f64,
    pieces: &mut Vec<Piece>,
    counters: &mut Counters,
) -> Option<f64> {
    if curve.c[0] > noise {
        return Some(0.0);
    }
    let mut curve = *curve;
    curve.c[0] = curve.c[0].min(0.0);
    pieces.clear();
    pieces.push(Piece::whole(curve));
    // Each piece starts at or below 0; one that ends above 0 returns before any to its right is seen.
    while let Some(piece) = pieces.pop() {
        let Piece { curve, low, high } = piece;
        counters.clip_iterations += 1;
        // A rise that falls back within the rounding error of the coefficients is a touch.
        let allowed = if curve.last() > 0.0 { 0.0 } else { noise };
        if curve.coefficients().iter().all(|&c| c <= allowed) {
            continue;
        }
        if curve.rises_once() {
            return Some(low + (high - low) * curve.only_root());
        }
        if high - low <= NARROWEST {
            if curve.last() > 0.0 {
                return Some(high);
            }
            continue;
        }
        let (from, to) = curve.hull_on_axis(CLIP_MARGIN);
        if to - from <= SLOW {
            pieces.push(piece.clipped(from, to));
            continue;
        }
        let (left, right) = curve.split(0.5);
        let middle = 0.5 * (low + high);
        pieces.push(Piece {
            curve: right,
            low: middle,
            high,
        });
        pieces.push(Piece {
            curve: left,
            low,
            high: middle,
        });
    }
    None
}

#[cfg(test)]
mod tests;
