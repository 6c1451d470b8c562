//! Ellipsoids from the arrangement of neighbours (Yu & Turk 2013, §4): smoothed centres, and supports
//! stretched along the weighted covariance.
//!
//! With weights w = 1 − (d/r)³ within r: centre x̄ = x + λ(μ − x), μ the weighted mean, and
//! G = Q diag(1/σ̃) Qᵀ / R from the covariance Q diag(σ) Qᵀ about μ. The scale of σ is such that a
//! neighbourhood that fills its ball gives 1 (the paper's k_s), none is below a quarter of the largest
//! (k_r = 4), and all go to 1, and λ to 0, where there are few neighbours (the paper switches at a
//! count, which would show between frames).
//!
//! A particle keeps the volume that it has as a ball among balls: the paper's field is
//! Σ m/ρ det G P(|G(x − x̄)|) with the simulation's ρ, so the weights of the balls are multiplied by
//! det G R³. Densities of the ellipsoids among each other would make F ≈ 1 in a thin sheet too, and the
//! sheet a third as thick.

mod gather;
mod lanes;

use crate::math::aabb::DAabb;
use crate::math::simd::Level;
use crate::particles::neighbours::BoxTree;
use fearless_simd::dispatch;
use gather::{Near, Places};
use glam::DVec3;
use lanes::{LANES, NUMBERS, shapes};
use rayon::prelude::*;
use std::ops::Range;

/// r over the support radius.
const NEIGHBOURHOOD: f64 = 1.5;
/// λ where there are enough neighbours.
const SMOOTHING: f64 = 0.9;
/// Largest ratio of axes.
const LARGEST_RATIO: f64 = 4.0;
/// Shortest axis over the support radius, however close particles stand.
const LEAST: f64 = 1.0 / 16.0;
/// Variance along any axis of a filled ball of radius 1 under the weights: ∫(1−u³)u⁴ / 3∫(1−u³)u².
const FILLED: f64 = 0.15;
/// Sums of weights (the particle's own is 1) at which the arrangement begins to count and counts fully.
const FEW: [f64; 2] = [2.0, 6.0];

/// Particles that share a list of neighbours, at most.
const GROUP: usize = 4 * LANES;
/// Groups per task.
const GROUPS: usize = 8;
/// A group whose box is longer than this many times the reach falls apart.
const LONGEST: f64 = 2.0;
/// Particles per task where there is little to do.
const PARALLEL: usize = 1 << 14;

/// What the neighbours say of each particle.
#[derive(Debug)]
pub(super) struct Estimate {
    /// Smoothed centres.
    pub(super) centers: Vec<DVec3>,
    /// Upper-triangular factors of the metrics.
    pub(super) factors: Vec<[f64; 6]>,
}

/// Shapes of particles in the order of the tree.
type Found = [f32; NUMBERS];

/// The estimate for particles with these support radii; `points` is a tree over the positions.
pub(super) fn estimate(positions: &[DVec3], supports: &[f64], points: &BoxTree) -> Estimate {
    // In the order of the tree, so that neighbours in space are neighbours in memory.
    let order = points.order();
    let column = |of: &(dyn Fn(usize) -> f64 + Sync)| -> Vec<f64> {
        let mut column = Vec::with_capacity(order.len() + LANES);
        column.par_extend(
            order
                .par_iter()
                .with_min_len(PARALLEL)
                .map(|&item| of(item as usize)),
        );
        // Blocks may reach over the end.
        column.extend([0.0; LANES]);
        column
    };
    let columns = [0, 1, 2].map(|axis| column(&|item| positions[item][axis]));
    let ordered = Ordered {
        places: Places::new(&columns),
        columns,
        supports: column(&|item| supports[item]),
        points,
    };
    let mut found: Vec<Found> = vec![[0.0; NUMBERS]; positions.len()];
    found
        .par_chunks_mut(GROUP * GROUPS)
        .enumerate()
        .for_each_init(Near::default, |near, (task, found)| {
            for (group, found) in found.chunks_mut(GROUP).enumerate() {
                let first = (task * GROUPS + group) * GROUP;
                ordered.shapes(first..first + found.len(), near, found);
            }
        });
    let mut place_of = vec![0_u32; positions.len()];
    for (place, &item) in order.iter().enumerate() {
        place_of[item as usize] = place as u32;
    }
    let settled = |item: usize| {
        settled(
            positions[item],
            supports[item],
            &found[place_of[item] as usize],
        )
    };
    let (centers, factors) = (0..positions.len())
        .into_par_iter()
        .with_min_len(PARALLEL)
        .map(settled)
        .unzip();
    Estimate { centers, factors }
}

/// The smoothed centre and the factor of the metric.
fn settled(position: DVec3, support: f64, found: &Found) -> (DVec3, [f64; 6]) {
    let [x, y, z, factor @ ..] = found.map(f64::from);
    let center = position + DVec3::new(x, y, z) * (NEIGHBOURHOOD * support);
    let is_shape =
        factor.iter().all(|a| a.is_finite()) && [0, 3, 5].iter().all(|&k| factor[k] > 0.0);
    // Where squares of f32 are too small or too large.
    let factor = if is_shape {
        factor
    } else {
        [1.0, 0.0, 0.0, 1.0, 0.0, 1.0]
    };
    (center, factor.map(|a| a / support))
}

/// Particles in the order of a tree over them.
struct Ordered<'a> {
    columns: [Vec<f64>; 3],
    places: Places,
    supports: Vec<f64>,
    points: &'a BoxTree,
}

impl Ordered<'_> {
    /// The shapes of a group of particles.
    fn shapes(&self, group: Range<usize>, near: &mut Near, found: &mut [Found]) {
        let mut region = DAabb::EMPTY;
        let mut support = 0.0_f64;
        let [x, y, z] = &self.columns;
        for place in group.clone() {
            region = region.including(DVec3::new(x[place], y[place], z[place]));
            support = support.max(self.supports[place]);
        }
        let reach = NEIGHBOURHOOD * support;
        // Where the curve jumps.
        if group.len() > 1 && region.size().max_element() > LONGEST * reach {
            let half = group.len() / 2;
            let (low, high) = found.split_at_mut(half);
            self.shapes(group.start..group.start + half, near, low);
            self.shapes(group.start + half..group.end, near, high);
            return;
        }
        near.find(&region, reach, self.points);
        let level = Level::new();
        dispatch!(level, simd => {
            near.take(simd, &region, reach, &self.places);
            for (block, found) in found.chunks_mut(LANES).enumerate() {
                let first = group.start + block * LANES;
                let at = self.places.block(simd, first, found.len(), near.middle);
                let mut per_reach = [0.0; LANES];
                for lane in 0..found.len() {
                    per_reach[lane] = (1.0 / (NEIGHBOURHOOD * self.supports[first + lane])) as f32;
                }
                let list = near.narrowed(simd, &at, reach);
                let numbers = shapes(simd, list.columns(), &at, &per_reach);
                for (lane, found) in found.iter_mut().enumerate() {
                    for (number, lanes) in found.iter_mut().zip(&numbers) {
                        *number = lanes[lane];
                    }
                }
            }
        });
    }
}

#[cfg(test)]
mod tests;
