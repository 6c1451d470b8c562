//! Which metaballs of a leaf the ray's segment meets, and where the field is looked at.

use crate::accel::cells::layout::{Block, Columns, LANES};
use crate::intersect::cells::gather::lanes;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// The metaballs that a segment meets, as parabolas g(s) = g₀ − β(s − c)², and points on the segment.
#[derive(Debug, Default)]
pub(super) struct Active {
    /// How many metaballs; the arrays are longer.
    pub(super) count: usize,
    /// How many of them, from the first on, are looked at.
    own: usize,
    pub(super) c: Vec<f32>,
    pub(super) beta: Vec<f32>,
    pub(super) g0: Vec<f32>,
    pub(super) weight: Vec<f32>,
    /// How many points, whole chunks.
    pub(super) point_count: usize,
    /// Parameters in [0, length], in no order; lanes to spare repeat one of them.
    pub(super) points: Vec<f32>,
    /// F at the points.
    pub(super) values: Vec<f32>,
}

impl Active {
    /// Makes room for every blob of a leaf of `largest` lanes.
    pub(super) fn reserve(&mut self, largest: usize) {
        let capacity = largest + LANES;
        if self.c.len() < capacity {
            for column in [&mut self.c, &mut self.beta, &mut self.g0, &mut self.weight] {
                column.resize(capacity, 0.0);
            }
            for column in [&mut self.points, &mut self.values] {
                column.resize(2 * capacity + LANES, 0.0);
            }
        }
    }

    /// c, β, g₀ and weight of the sixteen metaballs at `at`.
    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, simd: S, at: usize) -> [f32x16<S>; 4] {
        let end = at + LANES;
        [
            f32x16::from_slice(simd, &self.c[at..end]),
            f32x16::from_slice(simd, &self.beta[at..end]),
            f32x16::from_slice(simd, &self.g0[at..end]),
            f32x16::from_slice(simd, &self.weight[at..end]),
        ]
    }

    /// Fills the list with the metaballs that the segment origin + s·direction, s in [0, length], meets
    /// and returns an upper bound of the field on it. Unit direction, leaf-relative origin.
    #[inline(always)]
    pub(super) fn gather<S: Simd, K: KernelShape, P: Primitive>(
        &mut self,
        simd: S,
        chunks: &[Block],
        own_chunks: usize,
        origin: [f32; 3],
        direction: [f32; 3],
        length: f32,
    ) -> f32 {
        let origin: [f32x16<S>; 3] = splat3(simd, origin);
        let direction: [f32x16<S>; 3] = splat3(simd, direction);
        let length = f32x16::splat(simd, length);
        let zero = f32x16::splat(simd, 0.0);
        let mut upper = zero;
        let mut count = 0;
        self.own = 0;
        for (at, chunk) in chunks
            .chunks_exact(Columns::ALL.blocks_per_chunk::<P>())
            .enumerate()
        {
            let w = xyz(
                #[inline(always)]
                |k| lanes(simd, chunk, k) - origin[k],
            );
            let mut shape = [zero; 6];
            for k in 0..P::COLUMNS {
                shape[k] = lanes(simd, chunk, 3 + k);
            }
            let line = P::along(&shape[..P::COLUMNS], w, direction);
            let away = line.c.max(zero).min(length) - line.c;
            let most = line.g0 - line.beta * away * away;
            let meets = most.simd_gt(zero);
            let bits = meets.to_bitmask();
            if bits != 0 {
                let weight = lanes(simd, chunk, 3 + P::COLUMNS);
                upper = Number::mul_add(weight.max(zero), K::of_g(most.max(zero)), upper);
                let end = count + LANES;
                line.c.compress(meets).store_slice(&mut self.c[count..end]);
                line.beta
                    .compress(meets)
                    .store_slice(&mut self.beta[count..end]);
                line.g0
                    .compress(meets)
                    .store_slice(&mut self.g0[count..end]);
                weight
                    .compress(meets)
                    .store_slice(&mut self.weight[count..end]);
                count += bits.count_ones() as usize;
            }
            if at + 1 == own_chunks {
                self.own = count;
            }
        }
        self.count = count;
        // Lanes behind the last metaball are read in whole chunks: weight 0 and a parabola that stays 0.
        let end = count + LANES;
        self.weight[count..end].fill(0.0);
        self.g0[count..end].fill(0.0);
        self.beta[count..end].fill(0.0);
        self.c[count..end].fill(0.0);
        upper.reduce_sum()
    }

    /// Points for a ray from outside (§3): the centres' projections, within the segment, and its start.
    #[inline(always)]
    pub(super) fn project_centers<S: Simd>(&mut self, simd: S, length: f32) {
        let zero = f32x16::splat(simd, 0.0);
        let length = f32x16::splat(simd, length);
        self.points[..LANES].fill(0.0);
        for at in (0..self.own).step_by(LANES) {
            let c = f32x16::from_slice(simd, &self.c[at..at + LANES]);
            c.max(zero)
                .min(length)
                .store_slice(&mut self.points[at..at + LANES]);
        }
        let end = self.own.next_multiple_of(LANES).max(LANES);
        if self.own == end {
            self.points[end..end + LANES].fill(0.0);
            self.point_count = end + LANES;
        } else {
            self.points[self.own..end].fill(0.0);
            self.point_count = end;
        }
    }

    /// Points for a ray from inside, which leaves the surface where metaballs end: both ends of their
    /// supports, within the segment. `with_start`: also the segment's start, where all metaballs of the
    /// leaf are known.
    #[inline(always)]
    pub(super) fn support_ends<S: Simd>(&mut self, simd: S, length: f32, with_start: bool) {
        let zero = f32x16::splat(simd, 0.0);
        let one = f32x16::splat(simd, 1.0);
        let length = f32x16::splat(simd, length);
        let mut count = 0;
        for at in (0..self.own).step_by(LANES) {
            let [c, beta, g0, _] = self.lanes(simd, at);
            let present = beta.simd_gt(zero);
            let reach = (g0.max(zero) / present.select(beta, one)).sqrt();
            for end in [c - reach, c + reach] {
                let place = count..count + LANES;
                end.max(zero)
                    .min(length)
                    .store_slice(&mut self.points[place]);
                // Lanes behind the last own metaball repeat the first one.
                let whole = (self.own - at).min(LANES);
                let first = self.points[count];
                self.points[count + whole..count + LANES].fill(first);
                count += LANES;
            }
        }
        if with_start {
            self.points[count..count + LANES].fill(0.0);
            count += LANES;
        }
        self.point_count = count;
    }
}
