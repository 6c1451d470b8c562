//! The particles that a few near each other may reach.

use super::lanes::LANES;
use crate::math::aabb::DAabb;
use crate::math::simd::splat3;
use crate::particles::neighbours::BoxTree;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::DVec3;
use std::ops::Range;

/// Coordinates in the order of a tree as sums of two f32, whose differences are as good as those of f64
/// and take a quarter of the time; a block longer than there are particles.
pub(super) struct Places {
    high: [Vec<f32>; 3],
    low: [Vec<f32>; 3],
}

impl Places {
    /// Of coordinates that are followed by a block of others.
    pub(super) fn new(columns: &[Vec<f64>; 3]) -> Self {
        let high = |x: f64| x as f32;
        Self {
            high: columns
                .each_ref()
                .map(|column| column.iter().map(|&x| high(x)).collect()),
            low: columns.each_ref().map(|column| {
                let rest = |&x: &f64| (x - f64::from(high(x))) as f32;
                column.iter().map(rest).collect()
            }),
        }
    }

    /// Sixteen coordinates from `first` on, relative to `middle`.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, axis: usize, first: usize, middle: (f32, f32)) -> f32x16<S> {
        let lanes = first..first + LANES;
        let high = f32x16::from_slice(simd, &self.high[axis][lanes.clone()]);
        let low = f32x16::from_slice(simd, &self.low[axis][lanes]);
        (high - middle.0) + (low - middle.1)
    }

    /// Coordinates of `filled` particles relative to `middle`; lanes behind them are where the last is.
    #[inline(always)]
    pub(super) fn block<S: Simd>(
        &self,
        simd: S,
        first: usize,
        filled: usize,
        middle: DVec3,
    ) -> [f32x16<S>; 3] {
        let mut block = self.sixteen(simd, first, middle);
        if filled < LANES {
            for lanes in &mut block {
                let mut places: [f32; LANES] = (*lanes).to_array();
                let last = places[filled.max(1) - 1];
                places[filled..].fill(last);
                *lanes = f32x16::from_slice(simd, &places);
            }
        }
        block
    }

    #[inline(always)]
    fn sixteen<S: Simd>(&self, simd: S, first: usize, middle: DVec3) -> [f32x16<S>; 3] {
        let middle = middle.to_array().map(parted);
        [
            self.lanes(simd, 0, first, middle[0]),
            self.lanes(simd, 1, first, middle[1]),
            self.lanes(simd, 2, first, middle[2]),
        ]
    }
}

/// A number as the sum of two f32.
fn parted(x: f64) -> (f32, f32) {
    let high = x as f32;
    (high, (x - f64::from(high)) as f32)
}

/// Coordinates that are collected; longer than `count`.
#[derive(Default)]
pub(super) struct List {
    count: usize,
    columns: [Vec<f32>; 3],
}

impl List {
    /// x, y and z.
    pub(super) fn columns(&self) -> [&[f32]; 3] {
        let [x, y, z] = &self.columns;
        [&x[..self.count], &y[..self.count], &z[..self.count]]
    }

    /// Empties the list and makes room for `most`.
    fn start(&mut self, most: usize) {
        self.count = 0;
        for column in &mut self.columns {
            if column.len() < most + LANES {
                column.resize(most + LANES, 0.0);
            }
        }
    }

    /// Adds the lanes of `bits`.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, place: [f32x16<S>; 3], bits: u64) {
        let mask = mask32x16::from_bitmask(simd, bits);
        let lanes = self.count..self.count + LANES;
        for axis in 0..3 {
            let kept = place[axis].compress(mask);
            kept.store_slice(&mut self.columns[axis][lanes.clone()]);
        }
        self.count += bits.count_ones() as usize;
    }
}

/// What particles within a box can reach.
struct Reach<S: Simd> {
    middle: [f32x16<S>; 3],
    half: [f32x16<S>; 3],
    square: f32x16<S>,
}

impl<S: Simd> Reach<S> {
    #[inline(always)]
    fn new(simd: S, middle: [f32; 3], half: [f32; 3], reach: f64) -> Self {
        Self {
            middle: splat3(simd, middle),
            half: splat3(simd, half),
            // A little more, for what rounding takes.
            square: f32x16::splat(simd, ((reach * reach) as f32) * 1.001),
        }
    }

    /// Which of the first `filled` lanes are within it.
    #[inline(always)]
    fn holds(&self, simd: S, place: [f32x16<S>; 3], filled: usize) -> u64 {
        let zero = f32x16::splat(simd, 0.0);
        let mut apart = zero;
        for axis in 0..3 {
            let beyond = ((place[axis] - self.middle[axis]).abs() - self.half[axis]).max(zero);
            apart = beyond.mul_add(beyond, apart);
        }
        apart.simd_le(self.square).to_bitmask() & ((1 << filled) - 1)
    }
}

/// Places about a few particles, relative to their middle.
#[derive(Default)]
pub(super) struct Near {
    pub(super) middle: DVec3,
    group: List,
    block: List,
    runs: Vec<Range<usize>>,
}

impl Near {
    /// Finds all particles that one within `region` may reach; `points` is in the order of the places.
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
    pub(super) fn take<S: Simd>(&mut self, simd: S, region: &DAabb, reach: f64, places: &Places) {
        self.group
            .start(self.runs.iter().map(|run| run.len()).sum());
        let half = (0.5 * region.size()).as_vec3().to_array();
        let within = Reach::new(simd, [0.0; 3], half, reach);
        for run in &self.runs {
            for first in run.clone().step_by(LANES) {
                let place = places.sixteen(simd, first, self.middle);
                let bits = within.holds(simd, place, (run.end - first).min(LANES));
                if bits != 0 {
                    self.group.add(simd, place, bits);
                }
            }
        }
    }

    /// Of these what `at`, some of the particles, can reach.
    #[inline(always)]
    pub(super) fn narrowed<S: Simd>(&mut self, simd: S, at: &[f32x16<S>; 3], reach: f64) -> &List {
        let Self { group, block, .. } = self;
        block.start(group.count);
        let low = [0, 1, 2].map(|axis| at[axis].reduce_min());
        let high = [0, 1, 2].map(|axis| at[axis].reduce_max());
        let middle = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
        let half = [0, 1, 2].map(|axis| 0.5 * (high[axis] - low[axis]));
        let within = Reach::new(simd, middle, half, reach);
        for first in (0..group.count).step_by(LANES) {
            let lanes = first..first + LANES;
            let [x, y, z] = &group.columns;
            let place = [
                f32x16::from_slice(simd, &x[lanes.clone()]),
                f32x16::from_slice(simd, &y[lanes.clone()]),
                f32x16::from_slice(simd, &z[lanes]),
            ];
            let bits = within.holds(simd, place, (group.count - first).min(LANES));
            if bits != 0 {
                block.add(simd, place, bits);
            }
        }
        block
    }
}
