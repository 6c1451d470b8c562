//! The field's gradient at a crossing, from the blobs that are there.

use super::pool::{Pool, chunk_columns};
use crate::accel::blocks::{Block, LANES, LeafHeader};
use crate::accel::particles::ParticleTree;
use crate::intersect::solve::outward_and_strongest;
use crate::kernel::KernelShape;
use crate::primitive::Primitive;
use fearless_simd::Simd;
use glam::DVec3;

/// The blobs about a crossing, packed as in a leaf, relative to it.
#[derive(Debug, Default)]
pub(super) struct NearHit {
    chunks: Vec<Block>,
}

impl NearHit {
    /// Copies the blobs of the pool whose support holds the point `along` from its origin, which is
    /// the local point `at`.
    pub(super) fn collect<P: Primitive>(
        &mut self,
        tree: &ParticleTree,
        pool: &Pool,
        along: f32,
        at: DVec3,
    ) {
        self.chunks.clear();
        let columns = chunk_columns::<P>();
        let mut lane_to = LANES;
        pool.for_each_at(along, |leaf, lane| {
            let block = leaf as usize * ParticleTree::leaf_blocks::<P>();
            let header = LeafHeader::from_block(&tree.blocks[block]);
            let from = &tree.blocks[block + 1..][..columns];
            if lane_to == LANES {
                lane_to = 0;
                let first = self.chunks.len();
                self.chunks.resize(first + columns, Block::ZERO);
            }
            let first = self.chunks.len() - columns;
            let to = &mut self.chunks[first..];
            let offset = glam::Vec3::from_array(header.center).as_dvec3() - at;
            for axis in 0..3 {
                to[axis].0[lane_to] = (f64::from(from[axis].0[lane]) + offset[axis]) as f32;
            }
            for k in 3..columns {
                to[k].0[lane_to] = from[k].0[lane];
            }
            lane_to += 1;
        });
    }

    /// −∇F and the index of the blob with the largest |w·k| at the crossing.
    #[inline(always)]
    pub(super) fn outward_and_strongest<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
    ) -> (DVec3, u32) {
        simd.vectorize(
            #[inline(always)]
            || outward_and_strongest::<S, K, P>(simd, &self.chunks, [0.0; 3]),
        )
    }
}
