//! The field's gradient at a crossing, from the blobs that are there.

use super::pool::Pool;
use super::turning::Turning;
use crate::accel::cells::layout::{Block, LANES, LeafHeader};
use crate::accel::particles::layout::{MOTION_COLUMNS, TURN_COLUMNS, columns, leaf_blocks};
use crate::accel::particles::{LeafTimes, ParticleTree};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{index_of_largest, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::{DVec3, Vec3};

/// The blobs about a crossing in chunks of the leaves' columns, relative to it.
#[derive(Debug, Default)]
pub(super) struct NearHit {
    chunks: Vec<Block>,
    /// Columns of a chunk.
    width: usize,
}

/// A leaf's columns of velocity gradients, if any, among those of its motion.
fn turns_of(motion: &[Block]) -> &[Block] {
    motion.get(MOTION_COLUMNS..).unwrap_or_default()
}

impl NearHit {
    /// Copies the blobs of the pool whose support holds the point at `place` (`along` behind `from`)
    /// of the ray, the local point `at`.
    #[inline(always)]
    pub(super) fn collect<S: Simd, P: Primitive>(
        &mut self,
        simd: S,
        (tree, times): (&ParticleTree, LeafTimes),
        pool: &Pool,
        place: (f32, f32),
        at: DVec3,
    ) {
        self.chunks.clear();
        let mut lane_to = LANES;
        let per_leaf = leaf_blocks::<P>(tree.motion_columns);
        let turns = tree.motion_columns > MOTION_COLUMNS;
        self.width = columns::<P>() + if turns { TURN_COLUMNS } else { 0 };
        let width = self.width;
        let secs = f64::from(times.since_middle_secs);
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
                    let longer = self.chunks.len() + width;
                    self.chunks.resize(longer, Block::ZERO);
                }
                let first = self.chunks.len() - width;
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
                for (to, rates) in to[columns::<P>()..].iter_mut().zip(turns_of(rates)) {
                    to.0[lane_to] = rates.0[lane];
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
        times: LeafTimes,
    ) -> (DVec3, u32) {
        let zero = f32x16::splat(simd, 0.0);
        let mut sum = [zero; 3];
        let mut best = f32x16::splat(simd, -1.0);
        let mut best_index = u32x16::splat(simd, u32::MAX);
        for chunk in self.chunks.chunks_exact(self.width.max(1)) {
            let column = |k: usize| f32x16::from_slice(simd, &chunk[k].0);
            let mut shape = [zero; 6];
            for k in 0..P::COLUMNS {
                shape[k] = column(3 + k);
            }
            let shape = &shape[..P::COLUMNS];
            let mut d = xyz(
                #[inline(always)]
                |k| -column(k),
            );
            let turns = chunk.len() > columns::<P>();
            if turns {
                d = Turning::of(simd, &chunk[columns::<P>()..], times).turned(d);
            }
            let y = P::transform(shape, d);
            let g = (dot(y, y) * -1.0 + 1.0).max(zero);
            let weight = column(3 + P::COLUMNS);
            // ∂g/∂x = −2 Aᵀy, so −∇F sums w·k′(g)·2·Aᵀy, with A·N in the place of A where blobs turn.
            let scale = weight * K::slope(g) * 2.0;
            let mut pull = P::transform_transposed(shape, y);
            if turns {
                pull = Turning::of(simd, &chunk[columns::<P>()..], times).turned_back(pull);
            }
            for k in 0..3 {
                sum[k] = Number::mul_add(scale, pull[k], sum[k]);
            }
            let strength = (weight * K::of_g(g)).abs();
            let index = column(4 + P::COLUMNS).to_bits();
            let stronger = strength.simd_gt(best);
            best = stronger.select(strength, best);
            best_index = stronger.select(index, best_index);
        }
        let [x, y, z] = sum;
        let outward = Vec3::new(x.reduce_sum(), y.reduce_sum(), z.reduce_sum());
        (outward.as_dvec3(), index_of_largest(simd, best, best_index))
    }
}
