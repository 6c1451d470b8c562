//! The field's gradient at a crossing, from the blobs that are there.

use super::pool::Pool;
use crate::accel::cells::layout::{Block, LANES, LeafHeader};
use crate::accel::particles::ParticleTree;
use crate::accel::particles::layout::{columns, leaf_blocks};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::{DVec3, Vec3};

/// The blobs about a crossing in chunks of the leaves' columns, relative to it.
#[derive(Debug, Default)]
pub(super) struct NearHit {
    chunks: Vec<Block>,
}

impl NearHit {
    /// Copies the blobs of the pool whose support holds the point at `place` (`along` behind `from`)
    /// of the ray, the local point `at`.
    #[inline(always)]
    pub(super) fn collect<S: Simd, P: Primitive>(
        &mut self,
        simd: S,
        (tree, since_middle_secs): (&ParticleTree, f32),
        pool: &Pool,
        place: (f32, f32),
        at: DVec3,
    ) {
        self.chunks.clear();
        let mut lane_to = LANES;
        let per_leaf = leaf_blocks::<P>(tree.moves());
        let secs = f64::from(since_middle_secs);
        pool.for_each_at(
            simd,
            place,
            #[inline(always)]
            |leaf, lane| {
                let block = leaf as usize * per_leaf;
                let header = LeafHeader::from_block(&tree.blocks[block]);
                let leaf = &tree.blocks[block + 1..][..per_leaf - 1];
                let (from, rates) = leaf.split_at(columns::<P>());
                if lane_to == LANES {
                    lane_to = 0;
                    let longer = self.chunks.len() + columns::<P>();
                    self.chunks.resize(longer, Block::ZERO);
                }
                let first = self.chunks.len() - columns::<P>();
                let to = &mut self.chunks[first..];
                let offset = Vec3::from_array(header.center).as_dvec3() - at;
                for axis in 0..3 {
                    let mut center = f64::from(from[axis].0[lane]) + offset[axis];
                    if !rates.is_empty() {
                        let velocity = f64::from(rates[axis].0[lane]);
                        center += (velocity + f64::from(rates[3 + axis].0[lane]) * secs) * secs;
                    }
                    to[axis].0[lane_to] = center as f32;
                }
                for k in 3..columns::<P>() {
                    to[k].0[lane_to] = from[k].0[lane];
                }
                lane_to += 1;
            },
        );
    }

    /// −∇F and the index of the blob with the largest |w·k| at the crossing.
    #[inline(always)]
    pub(super) fn outward_and_strongest<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
    ) -> (DVec3, u32) {
        let zero = f32x16::splat(simd, 0.0);
        let mut sum = [zero; 3];
        let mut best = f32x16::splat(simd, -1.0);
        let mut best_index = u32x16::splat(simd, u32::MAX);
        for chunk in self.chunks.chunks_exact(columns::<P>()) {
            let column = |k: usize| f32x16::from_slice(simd, &chunk[k].0);
            let mut shape = [zero; 6];
            for k in 0..P::COLUMNS {
                shape[k] = column(3 + k);
            }
            let shape = &shape[..P::COLUMNS];
            let y = P::transform(
                shape,
                xyz(
                    #[inline(always)]
                    |k| -column(k),
                ),
            );
            let g = (dot(y, y) * -1.0 + 1.0).max(zero);
            let weight = column(3 + P::COLUMNS);
            // ∂g/∂x = −2 Aᵀy, so −∇F sums w·k′(g)·2·Aᵀy.
            let scale = weight * K::slope(g) * 2.0;
            let pull = P::transform_transposed(shape, y);
            for k in 0..3 {
                sum[k] = Number::mul_add(scale, pull[k], sum[k]);
            }
            let strength = (weight * K::of_g(g)).abs();
            let index = column(4 + P::COLUMNS).to_bits();
            let stronger = strength.simd_gt(best);
            best = stronger.select(strength, best);
            best_index = stronger.select(index, best_index);
        }
        let (strengths, indices): ([f32; LANES], [u32; LANES]) =
            (best.to_array(), best_index.to_array());
        let strongest = (1..LANES).fold(0, |strongest, lane| {
            let (a, b) = (strengths[lane], strengths[strongest]);
            let first = a == b && indices[lane] < indices[strongest];
            if a > b || first { lane } else { strongest }
        });
        let [x, y, z] = sum;
        let outward = Vec3::new(x.reduce_sum(), y.reduce_sum(), z.reduce_sum());
        (outward.as_dvec3(), indices[strongest])
    }
}
