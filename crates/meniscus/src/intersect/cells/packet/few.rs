//! Packets that meet few blobs of a leaf: what can be told without stepping.

use super::Job;
use super::gather::{ActiveBlob, ActiveLanes};
use super::step::Stepped;
use crate::kernel::KernelShape;
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// With so many blobs or fewer it pays to step from where the first support begins.
const FEW: usize = 4;

/// Half the chord on which g exceeds `level`, squared; negative where it never does.
#[inline(always)]
fn half_chord_squared<S: Simd, P: Primitive, const ALIKE: bool>(
    simd: S,
    blob: &ActiveBlob,
    level: f32,
) -> f32x16<S> {
    let above = f32x16::from_slice(simd, &blob.g0) - level;
    above / blob.beta_lanes::<S, P, ALIKE>(simd)
}

/// The crossings of rays from outside with the only blob that the packet meets, in closed form.
#[inline(always)]
pub(super) fn lone_blob<S: Simd, K: KernelShape, P: Primitive, const ALIKE: bool>(
    simd: S,
    job: &Job,
    blob: &ActiveBlob,
    (todo, length): (u32, f32x16<S>),
) -> Stepped<S> {
    let zero = f32x16::splat(simd, 0.0);
    let mut stepped = Stepped {
        crossed: 0,
        unclear: 0,
        at: zero,
    };
    let level = job.threshold / blob.weight;
    if level > 0.0 && level < 1.0 {
        let square =
            half_chord_squared::<S, P, ALIKE>(simd, blob, K::g_at(f64::from(level)) as f32);
        let half = square.max(zero).sqrt();
        let center = f32x16::from_slice(simd, &blob.c);
        let (enter, leave) = (center - half, center + half);
        let meets = square.simd_ge(zero).to_bitmask()
            & enter.simd_le(length).to_bitmask()
            & leave.simd_ge(zero).to_bitmask();
        stepped.crossed = meets as u32 & todo;
        stepped.at = enter.max(zero);
    }
    stepped
}

/// Where the field may first differ from 0; 0 where that is not worth finding out.
#[inline(always)]
pub(super) fn first_support<S: Simd, P: Primitive, const ALIKE: bool>(
    simd: S,
    active: &ActiveLanes,
) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    if active.blobs().len() > FEW {
        return zero;
    }
    let nowhere = f32x16::splat(simd, f32::MAX);
    let mut first = nowhere;
    for blob in active.blobs() {
        let square = half_chord_squared::<S, P, ALIKE>(simd, blob, 0.0);
        // A little early, for rounding.
        let half = square.max(zero).sqrt() * 1.000_01;
        let enter = f32x16::from_slice(simd, &blob.c) - half;
        first = first.min(square.simd_gt(zero).select(enter, nowhere));
    }
    first.max(zero)
}
