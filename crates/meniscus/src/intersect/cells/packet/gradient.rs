//! The field's gradient and strongest blob where lanes of a packet cross the surface.

use super::gather::{ActiveLanes, Alike};
use crate::accel::cells::layout::LANES;
use crate::intersect::cells::LeafView;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};

impl LeafView<'_> {
    /// −∇F and the strongest blob at one point per lane, relative to the leaf's centre.
    #[inline(always)]
    pub(super) fn gradient<
        S: Simd,
        K: KernelShape,
        P: Primitive,
        const MOVES: bool,
        const ALIKE: bool,
    >(
        &self,
        simd: S,
        alike: &Alike,
        active: &ActiveLanes,
        point: [f32x16<S>; 3],
        phase: f32x16<S>,
    ) -> ([[f32; LANES]; 3], [u32; LANES]) {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let mut sum = [zero; 3];
        let mut best = f32x16::splat(simd, -1.0);
        let mut best_index = u32x16::splat(simd, 0);
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        let beta = alike.per_radius * alike.per_radius;
        for blob in active.blobs() {
            let slot = blob.slot as usize;
            let chunk = &self.chunks[slot / LANES * per_chunk..];
            let center = self.center_of::<S, P, MOVES, ALIKE>(simd, chunk, slot, phase);
            let d = xyz(
                #[inline(always)]
                |k| point[k] - center[k],
            );
            // ∂g/∂x = −2 Aᵀy, so −∇F sums w·k′(g)·2·Aᵀy.
            let (scale, pull, strength);
            if ALIKE {
                let g = Number::neg_mul_add(dot(d, d), f32x16::splat(simd, beta), one).max(zero);
                (scale, pull, strength) = (K::slope_in_part(g), d, g);
            } else {
                let (columns, weight) = self.blob::<P>(chunk, slot);
                let mut shape = [zero; 6];
                for k in 0..P::COLUMNS {
                    shape[k] = f32x16::splat(simd, columns[k]);
                }
                let y = P::transform(&shape[..P::COLUMNS], d);
                let g = (one - dot(y, y)).max(zero);
                scale = K::slope_in_part(g) * weight;
                pull = P::transform_transposed(&shape[..P::COLUMNS], y);
                strength = (K::of_g(g) * weight).abs();
            }
            for k in 0..3 {
                sum[k] = Number::mul_add(scale, pull[k], sum[k]);
            }
            let stronger = strength.simd_gt(best);
            best = stronger.select(strength, best);
            let index = chunk[per_chunk - 1].0[slot % LANES].to_bits();
            best_index = stronger.select(u32x16::splat(simd, index), best_index);
        }
        let mut factor = 2.0 * K::SLOPE_FACTOR;
        if ALIKE {
            factor *= alike.weight * beta;
        }
        let outward = xyz(
            #[inline(always)]
            |k| (sum[k] * factor).to_array(),
        );
        (outward, best_index.to_array())
    }
}
