//! The blobs that a segment meets, as parabolas g(s) = g₀ − β(s − c)².

use crate::accel::cells::layout::LANES;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// The blobs that a segment meets, in structure-of-arrays form.
#[derive(Debug, Default)]
pub(in crate::intersect) struct Active {
    /// How many; the arrays are longer.
    pub(in crate::intersect) count: usize,
    pub(in crate::intersect) c: Vec<f32>,
    pub(in crate::intersect) beta: Vec<f32>,
    pub(in crate::intersect) g0: Vec<f32>,
    pub(in crate::intersect) weight: Vec<f32>,
    /// β and weight that all places of `beta` and `weight` hold, if they do.
    common: [Option<f32>; 2],
}

/// The arrays of [`Active`], all of one length, while they are filled.
pub(in crate::intersect) struct Room<'a> {
    pub(in crate::intersect) c: &'a mut [f32],
    pub(in crate::intersect) beta: &'a mut [f32],
    pub(in crate::intersect) g0: &'a mut [f32],
    pub(in crate::intersect) weight: &'a mut [f32],
}

impl Active {
    /// Room for `largest` blobs, in whole chunks plus a spare one. What all of them have in common,
    /// [β, weight], is there already, and stays there from leaf to leaf.
    #[inline(always)]
    pub(in crate::intersect) fn room(
        &mut self,
        largest: usize,
        common: [Option<f32>; 2],
    ) -> Room<'_> {
        let len = largest.next_multiple_of(LANES) + LANES;
        if self.c.len() < len || self.common != common {
            self.prepare(len, common);
        }
        Room {
            c: &mut self.c[..len],
            beta: &mut self.beta[..len],
            g0: &mut self.g0[..len],
            weight: &mut self.weight[..len],
        }
    }

    #[cold]
    fn prepare(&mut self, len: usize, common: [Option<f32>; 2]) {
        let len = len.max(self.c.len());
        for column in [&mut self.c, &mut self.beta, &mut self.g0, &mut self.weight] {
            column.resize(len, 0.0);
        }
        for (column, common) in [&mut self.beta, &mut self.weight].into_iter().zip(common) {
            if let Some(common) = common {
                column.fill(common);
            }
        }
        self.common = common;
    }

    /// c, β, g₀ and weight of the sixteen blobs at `at`.
    #[inline(always)]
    pub(in crate::intersect) fn lanes<S: Simd>(&self, simd: S, at: usize) -> [f32x16<S>; 4] {
        let end = at + LANES;
        [
            f32x16::from_slice(simd, &self.c[at..end]),
            f32x16::from_slice(simd, &self.beta[at..end]),
            f32x16::from_slice(simd, &self.g0[at..end]),
            f32x16::from_slice(simd, &self.weight[at..end]),
        ]
    }

    /// Ends a fill of `count` blobs.
    #[inline(always)]
    pub(in crate::intersect) fn finish(&mut self, count: usize) {
        self.count = count;
        // Lanes behind the last blob are read in whole chunks: parabolas that stay at 0.
        self.g0[count..count + LANES].fill(0.0);
    }

    /// Behind this place all blobs recede, so that their field falls; infinite where some weight is
    /// negative.
    #[inline(always)]
    pub(in crate::intersect) fn last_approach<S: Simd>(&self, simd: S) -> f32 {
        let mut last = f32x16::splat(simd, f32::MIN);
        let infinite = f32x16::splat(simd, f32::INFINITY);
        let zero = f32x16::splat(simd, 0.0);
        for at in (0..self.count).step_by(LANES) {
            let [c, _, g0, weight] = self.lanes(simd, at);
            let approach = weight.simd_lt(zero).select(infinite, c);
            last = g0.simd_gt(zero).select(approach, last).max(last);
        }
        last.reduce_max()
    }

    /// The part of [0, length] from the first support's entry to the last one's exit, for at most
    /// one chunk of blobs.
    #[inline(always)]
    pub(in crate::intersect) fn span<S: Simd>(&self, simd: S, length: f32) -> (f32, f32) {
        let [c, beta, g0, _] = self.lanes(simd, 0);
        let zero = f32x16::splat(simd, 0.0);
        let present = g0.simd_gt(zero);
        let one = f32x16::splat(simd, 1.0);
        let reach = (g0.max(zero) / present.select(beta, one)).sqrt() * 1.000_001;
        let enter = present.select(c - reach, f32x16::splat(simd, f32::MAX));
        let leave = present.select(c + reach, f32x16::splat(simd, f32::MIN));
        let from = enter.reduce_min().max(0.0);
        (from, leave.reduce_max().min(length).max(from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two surfaces of one picture take turns in the same arrays.
    #[test]
    fn what_blobs_have_in_common_is_that_of_the_leaf_at_hand() {
        let mut active = Active::default();
        for common in [
            [Some(2.0), Some(1.0)],
            [Some(8.0), Some(1.0)],
            [None, Some(3.0)],
            [Some(8.0), None],
            [Some(2.0), Some(1.0)],
        ] {
            let room = active.room(5, common);
            if common[0].is_none() {
                room.beta.fill(0.5);
            }
            if common[1].is_none() {
                room.weight.fill(-1.0);
            }
            active.finish(5);
            assert!(
                active.beta[..5]
                    .iter()
                    .all(|&b| b == common[0].unwrap_or(0.5))
            );
            assert!(
                active.weight[..5]
                    .iter()
                    .all(|&w| w == common[1].unwrap_or(-1.0))
            );
        }
    }

    #[test]
    fn lanes_behind_the_last_blob_hold_nothing_of_the_leaf_before() {
        let mut active = Active::default();
        active.room(40, [None; 2]).g0.fill(1.0);
        active.finish(40);
        active.room(3, [None; 2]);
        active.finish(3);
        assert_eq!(active.g0[3..3 + LANES], [0.0; LANES]);
    }
}
