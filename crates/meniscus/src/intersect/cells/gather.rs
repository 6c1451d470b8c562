//! Which blobs of a leaf the ray's segment meets, as parabolas g(s) = g₀ − β(s − c)².

use super::LeafView;
use crate::accel::cells::layout::{Block, Columns, LANES};
use crate::intersect::solve::Active;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Column `k` of a chunk.
#[inline(always)]
pub(in crate::intersect) fn lanes<S: Simd>(simd: S, chunk: &[Block], k: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &chunk[k].0)
}

/// The shape of a chunk's blobs.
#[inline(always)]
pub(super) fn shape_lanes<S: Simd, P: Primitive>(
    simd: S,
    stored: &Columns,
    chunk: &[Block],
) -> [f32x16<S>; 6] {
    let mut shape = [f32x16::splat(simd, 0.0); 6];
    match &stored.shape {
        Some(constant) => {
            for k in 0..P::COLUMNS {
                shape[k] = f32x16::splat(simd, constant[k]);
            }
        }
        None => {
            for k in 0..P::COLUMNS {
                shape[k] = lanes(simd, chunk, Columns::SHAPE + k);
            }
        }
    }
    shape
}

/// The weights of a chunk's blobs.
#[inline(always)]
pub(super) fn weight_lanes<S: Simd, P: Primitive>(
    simd: S,
    stored: &Columns,
    chunk: &[Block],
) -> f32x16<S> {
    match stored.weight {
        Some(constant) => f32x16::splat(simd, constant),
        None => lanes(simd, chunk, stored.weight_at::<P>()),
    }
}

/// Coordinate `axis` of a chunk's blobs, relative to the leaf's centre, at a time within the shutter.
#[inline(always)]
pub(super) fn center_lanes<S: Simd, P: Primitive>(
    simd: S,
    stored: &Columns,
    chunk: &[Block],
    axis: usize,
    phase: f32,
) -> f32x16<S> {
    let first = stored.motion_at::<P>();
    let velocity = lanes(simd, chunk, first + axis);
    let phase = f32x16::splat(simd, phase);
    let speed = if stored.is_accelerated() {
        Number::mul_add(lanes(simd, chunk, first + 3 + axis), phase, velocity)
    } else {
        velocity
    };
    Number::mul_add(speed, phase, lanes(simd, chunk, axis))
}

/// A part of a ray: origin + s·direction for s in [0, length].
pub(super) struct Segment {
    /// Relative to the leaf's centre.
    pub(super) origin: [f32; 3],
    /// Unit direction.
    pub(super) direction: [f32; 3],
    pub(super) length: f32,
    /// When, from −1 to 1 over the shutter.
    pub(super) phase: f32,
}

/// Fills `active` with the blobs that the segment meets and returns an upper bound of the field on it.
#[inline(always)]
pub(super) fn gather<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
    simd: S,
    leaf: &LeafView<'_>,
    segment: &Segment,
    active: &mut Active,
) -> f32 {
    let stored = leaf.stored;
    let common_beta = match stored.shape {
        Some(shape) if !P::BETA_TURNS => Some(shape[0] * shape[0]),
        _ => None,
    };
    let room = active.room(leaf.header.count, [common_beta, stored.weight]);
    let origin: [f32x16<S>; 3] = splat3(simd, segment.origin);
    let direction: [f32x16<S>; 3] = splat3(simd, segment.direction);
    let length = f32x16::splat(simd, segment.length);
    let zero = f32x16::splat(simd, 0.0);
    let mut upper = zero;
    let mut count = 0;
    let per_chunk = stored.blocks_per_chunk::<P>();
    let mut rest = leaf.chunks;
    while let Some((chunk, behind)) = rest.split_at_checked(per_chunk) {
        rest = behind;
        let w = xyz(
            #[inline(always)]
            |k| {
                let center = if MOVES {
                    center_lanes::<S, P>(simd, stored, chunk, k, segment.phase)
                } else {
                    lanes(simd, chunk, k)
                };
                center - origin[k]
            },
        );
        let shape = shape_lanes::<S, P>(simd, stored, chunk);
        let line = P::along(&shape[..P::COLUMNS], w, direction);
        let away = line.c.max(zero).min(length) - line.c;
        let most = Number::neg_mul_add(line.beta * away, away, line.g0);
        let meets = most.simd_gt(zero);
        let bits = meets.to_bitmask();
        let weight = weight_lanes::<S, P>(simd, stored, chunk);
        upper = Number::mul_add(weight.max(zero), K::of_g(most.max(zero)), upper);
        let end = count + LANES;
        line.c.compress(meets).store_slice(&mut room.c[count..end]);
        line.g0
            .compress(meets)
            .store_slice(&mut room.g0[count..end]);
        if common_beta.is_none() {
            line.beta
                .compress(meets)
                .store_slice(&mut room.beta[count..end]);
        }
        if stored.weight.is_none() {
            weight
                .compress(meets)
                .store_slice(&mut room.weight[count..end]);
        }
        count += bits.count_ones() as usize;
    }
    active.finish(count);
    upper.reduce_sum()
}
