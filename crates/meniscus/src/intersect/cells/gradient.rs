//! The field's gradient and strongest blob at a point of a leaf.

use super::gather::{center_lanes, lanes, shape_lanes, weight_lanes};
use crate::accel::cells::layout::{Block, Columns};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{index_of_largest, splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::DVec3;

/// −∇F and the index of the blob with the largest |w·k| at `point` (leaf-relative), at a time within the
/// shutter (−1 to 1).
#[inline(always)]
pub(in crate::intersect) fn outward_and_strongest<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    (stored, phase): (&Columns, f32),
    chunks: &[Block],
    point: [f32; 3],
) -> (DVec3, u32) {
    let zero = f32x16::splat(simd, 0.0);
    let point: [f32x16<S>; 3] = splat3(simd, point);
    let mut sum = [zero; 3];
    let mut best = f32x16::splat(simd, -1.0);
    let mut best_index = u32x16::splat(simd, 0);
    let per_chunk = stored.blocks_per_chunk::<P>();
    for chunk in chunks.chunks_exact(per_chunk) {
        let d = xyz(
            #[inline(always)]
            |k| {
                let center = if stored.moves() {
                    center_lanes::<S, P>(simd, stored, chunk, k, phase)
                } else {
                    lanes(simd, chunk, k)
                };
                point[k] - center
            },
        );
        let shape = shape_lanes::<S, P>(simd, stored, chunk);
        let y = P::transform(&shape[..P::COLUMNS], d);
        let g = (dot(y, y) * -1.0 + 1.0).max(zero);
        let weight = weight_lanes::<S, P>(simd, stored, chunk);
        // ∂g/∂x = −2 Aᵀy, so −∇F sums w·k′(g)·2·Aᵀy.
        let scale = weight * K::slope(g) * 2.0;
        let pull = P::transform_transposed(&shape[..P::COLUMNS], y);
        for k in 0..3 {
            sum[k] = Number::mul_add(scale, pull[k], sum[k]);
        }
        let strength = (weight * K::of_g(g)).abs();
        let stronger = strength.simd_gt(best);
        best = stronger.select(strength, best);
        best_index = stronger.select(lanes(simd, chunk, per_chunk - 1).to_bits(), best_index);
    }
    let outward = DVec3::new(
        f64::from(sum[0].reduce_sum()),
        f64::from(sum[1].reduce_sum()),
        f64::from(sum[2].reduce_sum()),
    );
    (outward, index_of_largest(simd, best, best_index))
}
