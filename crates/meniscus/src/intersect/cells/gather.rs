//! Which blobs of a leaf the ray's segment meets, as parabolas g(s) = g₀ − β(s − c)².

use crate::accel::cells::layout::{Block, LANES, blocks_per_chunk};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// The blobs that a segment meets, in structure-of-arrays form.
#[derive(Debug, Default)]
pub(super) struct Active {
    /// How many; the arrays are longer.
    pub(super) count: usize,
    pub(super) c: Vec<f32>,
    pub(super) beta: Vec<f32>,
    pub(super) g0: Vec<f32>,
    pub(super) weight: Vec<f32>,
}

impl Active {
    /// Makes room for every blob of a leaf of `largest` blobs, in whole chunks plus a spare one.
    pub(super) fn reserve(&mut self, largest: usize) {
        let capacity = largest.next_multiple_of(LANES) + LANES;
        if self.c.len() < capacity {
            for column in [&mut self.c, &mut self.beta, &mut self.g0, &mut self.weight] {
                column.resize(capacity, 0.0);
            }
        }
    }
}

impl Active {
    /// c, β, g₀ and weight of the sixteen blobs at `at`.
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
}

impl Active {
    /// The part of [0, length] from the first support's entry to the last one's exit, for at most
    /// one chunk of blobs.
    #[inline(always)]
    pub(super) fn span<S: Simd>(&self, simd: S, length: f32) -> (f32, f32) {
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

/// Column `k` of a chunk.
#[inline(always)]
pub(in crate::intersect) fn lanes<S: Simd>(simd: S, chunk: &[Block], k: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &chunk[k].0)
}

/// Fills `active` with the blobs that the segment origin + s·direction, s in [0, length], meets and
/// returns an upper bound of the field on it. Unit direction, leaf-relative origin.
#[inline(always)]
pub(super) fn gather<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    chunks: &[Block],
    origin: [f32; 3],
    direction: [f32; 3],
    length: f32,
    active: &mut Active,
) -> f32 {
    let origin: [f32x16<S>; 3] = splat3(simd, origin);
    let direction: [f32x16<S>; 3] = splat3(simd, direction);
    let length = f32x16::splat(simd, length);
    let zero = f32x16::splat(simd, 0.0);
    let mut upper = zero;
    let mut count = 0;
    for chunk in chunks.chunks_exact(blocks_per_chunk(P::COLUMNS)) {
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
        if bits == 0 {
            continue;
        }
        let weight = lanes(simd, chunk, 3 + P::COLUMNS);
        upper = Number::mul_add(weight.max(zero), K::of_g(most.max(zero)), upper);
        let end = count + LANES;
        line.c
            .compress(meets)
            .store_slice(&mut active.c[count..end]);
        line.beta
            .compress(meets)
            .store_slice(&mut active.beta[count..end]);
        line.g0
            .compress(meets)
            .store_slice(&mut active.g0[count..end]);
        weight
            .compress(meets)
            .store_slice(&mut active.weight[count..end]);
        count += bits.count_ones() as usize;
    }
    active.count = count;
    // Lanes behind the last blob are read in whole chunks: weight 0 and a parabola that stays at 0.
    let end = count + LANES;
    active.weight[count..end].fill(0.0);
    active.g0[count..end].fill(0.0);
    active.beta[count..end].fill(0.0);
    active.c[count..end].fill(0.0);
    upper.reduce_sum()
}
