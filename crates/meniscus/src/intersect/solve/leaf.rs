//! A leaf's packed blobs.

use super::local::LocalRay;
use crate::accel::blocks::{Block, LANES, LeafHeader, blocks_per_chunk};
use crate::frame::Blobs;
use crate::primitive::Primitive;

/// The blobs of the leaf at `block`, chunk after chunk.
#[inline(always)]
pub(in crate::intersect) fn leaf_chunks<P: Primitive>(
    blocks: &[Block],
    block: u32,
    count: usize,
) -> &[Block] {
    let first = block as usize + 1;
    &blocks[first..first + count.div_ceil(LANES) * blocks_per_chunk(P::COLUMNS)]
}

/// By how much f32 may see a blob at the limit of [`fine_limit`](crate::accel::blocks::fine_limit)
/// wider than it is, in its support.
const ROUNDING: f64 = 2e-5;

/// Whether the ray meets a blob that is too small for f32 in the leaf's coordinates.
#[cold]
pub(in crate::intersect) fn meets_fine<P: Primitive>(
    blobs: &Blobs,
    chunks: &[Block],
    header: &LeafHeader,
    ray: &LocalRay,
) -> bool {
    let field = &blobs.field;
    let indices = chunks
        .chunks_exact(blocks_per_chunk(P::COLUMNS))
        .flat_map(|chunk| {
            chunk[4 + P::COLUMNS]
                .0
                .map(|index| index.to_bits() as usize)
        });
    indices.take(header.count).any(|i| {
        let v = field.shapes.transform(i, ray.direction);
        let beta = v.length_squared();
        let steepness = (beta / f64::from(header.fine_beta)).sqrt();
        if steepness < 1.0 {
            return false;
        }
        let y = field
            .shapes
            .transform(i, ray.origin - field.center(i).as_dvec3());
        let nearest = (-y.dot(v) / beta).max(0.0);
        (y + v * nearest).length() < 1.0 + ROUNDING * steepness
    })
}
