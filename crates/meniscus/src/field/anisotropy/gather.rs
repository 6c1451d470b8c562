//! The particles that a few near each other may reach.

use super::lanes::LANES;
use crate::math::aabb::DAabb;
use crate::particles::neighbours::BoxTree;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec3;
use std::ops::Range;

/// With as many in reach a whole block is taken.
const MOST: u32 = 10;

/// Places about a few particles, relative to their middle.
#[derive(Default)]
pub(super) struct Near {
    pub(super) middle: DVec3,
    /// How many there are.
    count: usize,
    places: [Vec<f32>; 3],
    runs: Vec<Range<usize>>,
}

impl Near {
    /// x, y and z.
    pub(super) fn places(&self) -> [&[f32]; 3] {
        let [x, y, z] = &self.places;
        [&x[..self.count], &y[..self.count], &z[..self.count]]
    }

    /// Finds all particles that one within `region` may reach; `columns` are in the order of `points`.
    pub(super) fn find(&mut self, region: &DAabb, reach: f64, points: &BoxTree) {
        self.middle = region.center();
        self.runs.clear();
        let square = reach * reach;
        points.for_each_range(
            |bounds| {
                let apart = (bounds.min - region.max).max(region.min - bounds.max);
                apart.max(DVec3::ZERO).length_squared() <= square
            },
            |_, range| match self.runs.last_mut() {
                Some(last) if last.end == range.start => last.end = range.end,
                _ => self.runs.push(range),
            },
        );
    }

    /// Takes what was found, without what is out of reach.
    #[inline(always)]
    pub(super) fn take<S: Simd>(
        &mut self,
        simd: S,
        region: &DAabb,
        reach: f64,
        columns: &[Vec<f64>; 3],
    ) {
        let total: usize = self.runs.iter().map(|run| run.len()).sum();
        for places in &mut self.places {
            if places.len() < total + LANES {
                places.resize(total + LANES, 0.0);
            }
        }
        let half = (0.5 * region.size()).as_vec3().to_array();
        let half = half.map(|half| f32x16::splat(simd, half));
        // A little more, for what rounding takes.
        let square = f32x16::splat(simd, ((reach * reach) as f32) * 1.001);
        let zero = f32x16::splat(simd, 0.0);
        let middle = self.middle.to_array();
        let mut count = 0;
        for run in &self.runs {
            let mut first = run.start;
            while first < run.end {
                let filled = (run.end - first).min(LANES);
                let mut block = [[0.0; LANES]; 3];
                for axis in 0..3 {
                    let column: &[f64; LANES] = columns[axis][first..]
                        .first_chunk()
                        .unwrap_or(&[0.0; LANES]);
                    for lane in 0..LANES {
                        block[axis][lane] = (column[lane] - middle[axis]) as f32;
                    }
                }
                first += filled;
                let mut apart = zero;
                for axis in 0..3 {
                    let place = f32x16::from_slice(simd, &block[axis]);
                    let beyond = (place.abs() - half[axis]).max(zero);
                    apart = beyond.mul_add(beyond, apart);
                }
                let inside = apart.simd_le(square).to_bitmask() as u32;
                // What is out of reach counts nothing, but takes time.
                if filled == LANES && inside.count_ones() >= MOST {
                    for axis in 0..3 {
                        self.places[axis][count..count + LANES].copy_from_slice(&block[axis]);
                    }
                    count += LANES;
                    continue;
                }
                let mut inside = inside & ((1 << filled) - 1);
                while inside != 0 {
                    let lane = inside.trailing_zeros() as usize % LANES;
                    inside &= inside - 1;
                    for axis in 0..3 {
                        self.places[axis][count] = block[axis][lane];
                    }
                    count += 1;
                }
            }
        }
        self.count = count;
    }
}
