//! Ellipsoids from the arrangement of neighbours (Yu & Turk 2013, §4): smoothed centres, and supports
//! stretched along the weighted covariance.
//!
//! With weights w = 1 − (d/r)³ within r: centre x̄ = x + λ(μ − x), μ the weighted mean, and
//! G = Q diag(1/σ̃) Qᵀ / R from the covariance Q diag(σ) Qᵀ about μ. The scale of σ is such that a
//! neighbourhood that fills its ball gives 1 (the paper's k_s), none is below a quarter of the largest
//! (k_r = 4), and all go to 1, and λ to 0, where there are few neighbours (the paper switches at a
//! count, which would show between frames).

use crate::math::aabb::DAabb;
use crate::math::simd::Level;
use crate::math::symmetric::eigen;
use crate::particles::neighbours::BoxTree;
use crate::primitive::Ellipsoid;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};
use glam::{DMat3, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// r over the support radius.
const NEIGHBOURHOOD: f64 = 1.5;
/// λ where there are enough neighbours.
const SMOOTHING: f64 = 0.9;
/// Largest ratio of axes.
const LARGEST_RATIO: f64 = 4.0;
/// Variance along any axis of a filled ball of radius 1 under the weights: ∫(1−u³)u⁴ / 3∫(1−u³)u².
const FILLED: f64 = 0.15;
/// Sums of weights (the particle's own is 1) at which the arrangement begins to count and counts fully.
const FEW: [f64; 2] = [2.0, 6.0];

const LANES: usize = 16;
/// Groups of particles per task.
const GROUPS: usize = 16;

/// What the neighbours say of each particle.
#[derive(Debug)]
pub(super) struct Estimate {
    /// Smoothed centres.
    pub(super) centers: Vec<DVec3>,
    /// Upper-triangular factors of the metrics.
    pub(super) factors: Vec<[f64; 6]>,
}

/// The estimate for particles with these support radii; `points` is a tree over the positions.
pub(super) fn estimate(positions: &[DVec3], supports: &[f64], points: &BoxTree) -> Estimate {
    // In the order of the tree, so that neighbours in space are neighbours in memory.
    let order = points.order();
    let column = |axis: usize| -> Vec<f64> {
        let coordinate = |&item: &u32| positions[item as usize][axis];
        order.par_iter().map(coordinate).collect()
    };
    let columns = [column(0), column(1), column(2)];
    let mut first = 0;
    let ranges: Vec<Range<usize>> = points
        .groups()
        .map(|group| {
            first += group.len();
            first - group.len()..first
        })
        .collect();
    let found: Vec<Vec<(DVec3, [f64; 6])>> = ranges
        .par_chunks(GROUPS)
        .map_init(Neighbours::default, |neighbours, ranges| {
            let mut found = Vec::new();
            for range in ranges {
                let group = &order[range.clone()];
                let largest = group.iter().fold(0.0, |largest: f64, &item| {
                    largest.max(supports[item as usize])
                });
                neighbours.gather(range.clone(), largest, &columns, points);
                for &item in group {
                    let (position, support) = (positions[item as usize], supports[item as usize]);
                    let moments = neighbours.moments(position, support);
                    found.push(moments.settle(position, support));
                }
            }
            found
        })
        .collect();
    let mut estimate = Estimate {
        centers: vec![DVec3::ZERO; positions.len()],
        factors: vec![[0.0; 6]; positions.len()],
    };
    for (&item, (center, factor)) in order.iter().zip(found.into_iter().flatten()) {
        estimate.centers[item as usize] = center;
        estimate.factors[item as usize] = factor;
    }
    estimate
}

/// Positions about a group of particles, relative to its middle.
#[derive(Default)]
struct Neighbours {
    middle: DVec3,
    places: [Vec<f32>; 3],
}

impl Neighbours {
    /// Takes all particles that one of `group`, places in `columns`, may reach; `support` is the largest
    /// of theirs.
    fn gather(
        &mut self,
        group: Range<usize>,
        support: f64,
        columns: &[Vec<f64>; 3],
        points: &BoxTree,
    ) {
        let mut region = DAabb::EMPTY;
        for place in group {
            let [x, y, z] = columns;
            region = region.including(DVec3::new(x[place], y[place], z[place]));
        }
        region.min -= NEIGHBOURHOOD * support;
        region.max += NEIGHBOURHOOD * support;
        self.middle = region.center();
        let mut farthest = region;
        for places in &mut self.places {
            places.clear();
        }
        points.for_each_range(
            |bounds| bounds.min.cmple(region.max).all() && region.min.cmple(bounds.max).all(),
            |bounds, range| {
                farthest = farthest.union(*bounds);
                for (axis, places) in self.places.iter_mut().enumerate() {
                    let middle = self.middle[axis];
                    let near = columns[axis][range.clone()].iter();
                    places.extend(near.map(|coordinate| (coordinate - middle) as f32));
                }
            },
        );
        // Out of everybody's reach.
        let nowhere = 8.0 * (farthest.size().max_element() as f32).max(f32::MIN_POSITIVE);
        let filled = self.places[0].len().next_multiple_of(LANES);
        for places in &mut self.places {
            places.resize(filled, nowhere);
        }
    }

    fn moments(&self, position: DVec3, support: f64) -> Moments {
        let at = (position - self.middle).as_vec3().to_array();
        let per_reach = (1.0 / (NEIGHBOURHOOD * support)) as f32;
        let level = Level::new();
        let sums = dispatch!(level, simd => sums(simd, &self.places, at, per_reach));
        let mut moments = Moments::default();
        for lane in 0..LANES {
            moments.weight += f64::from(sums[0][lane]);
            for k in 0..3 {
                moments.first[k] += f64::from(sums[1 + k][lane]);
            }
            for k in 0..6 {
                moments.second[k] += f64::from(sums[4 + k][lane]);
            }
        }
        moments
    }
}

/// Σw, Σw·e and Σw·e·eᵀ (xx xy xz yy yz zz) in lanes, e = (neighbour − `at`)·`per_reach`. Products and
/// sums are not fused, so that every SIMD level gives the same bits.
#[inline(always)]
fn sums<S: Simd>(
    simd: S,
    [x, y, z]: &[Vec<f32>; 3],
    at: [f32; 3],
    per_reach: f32,
) -> [[f32; LANES]; 10] {
    let zero = f32x16::splat(simd, 0.0);
    let one = f32x16::splat(simd, 1.0);
    let scale = f32x16::splat(simd, per_reach);
    let (ax, ay, az) = (
        f32x16::splat(simd, at[0]),
        f32x16::splat(simd, at[1]),
        f32x16::splat(simd, at[2]),
    );
    let mut weight = zero;
    let mut first = [zero; 3];
    let mut second = [zero; 6];
    for start in (0..x.len()).step_by(LANES) {
        let range = start..start + LANES;
        let ex = (f32x16::from_slice(simd, &x[range.clone()]) - ax) * scale;
        let ey = (f32x16::from_slice(simd, &y[range.clone()]) - ay) * scale;
        let ez = (f32x16::from_slice(simd, &z[range]) - az) * scale;
        let square = ex * ex + ey * ey + ez * ez;
        let w = (one - square * square.sqrt()).max(zero);
        let (wx, wy, wz) = (w * ex, w * ey, w * ez);
        weight += w;
        first[0] += wx;
        first[1] += wy;
        first[2] += wz;
        second[0] += wx * ex;
        second[1] += wx * ey;
        second[2] += wx * ez;
        second[3] += wy * ey;
        second[4] += wy * ez;
        second[5] += wz * ez;
    }
    [
        weight.to_array(),
        first[0].to_array(),
        first[1].to_array(),
        first[2].to_array(),
        second[0].to_array(),
        second[1].to_array(),
        second[2].to_array(),
        second[3].to_array(),
        second[4].to_array(),
        second[5].to_array(),
    ]
}

/// Weighted sums over the neighbours of a particle, relative to it and in parts of r.
#[derive(Debug, Default)]
struct Moments {
    weight: f64,
    first: [f64; 3],
    /// xx xy xz yy yz zz.
    second: [f64; 6],
}

impl Moments {
    /// The smoothed centre and the factor of the metric.
    fn settle(&self, position: DVec3, support: f64) -> (DVec3, [f64; 6]) {
        let mean = DVec3::from_array(self.first) / self.weight;
        let [xx, xy, xz, yy, yz, zz] = self.second.map(|sum| sum / self.weight);
        let about_origin = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
        let outer = DMat3::from_cols(mean * mean.x, mean * mean.y, mean * mean.z);
        let (mut sigma, axes) = eigen((about_origin - outer) * (1.0 / FILLED));
        let counts = smoothstep(FEW, self.weight);
        let largest = sigma.max_element();
        sigma = sigma.max(DVec3::splat(largest / LARGEST_RATIO));
        sigma = DVec3::ONE.lerp(sigma, counts);
        let inverse = (sigma * sigma * (support * support)).recip();
        let scaled = DMat3::from_cols(
            axes.x_axis * inverse.x,
            axes.y_axis * inverse.y,
            axes.z_axis * inverse.z,
        );
        let metric = scaled * axes.transpose();
        let center = position + mean * (SMOOTHING * counts * NEIGHBOURHOOD * support);
        match Ellipsoid::factor_of(metric) {
            Ok(factor) => (center, factor),
            // A heap of particles at one place has no shape.
            Err(_) => {
                let a = 1.0 / support;
                (center, [a, 0.0, 0.0, a, 0.0, a])
            }
        }
    }
}

fn smoothstep([low, high]: [f64; 2], x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests;
