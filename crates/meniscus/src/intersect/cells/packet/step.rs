//! The first crossing of each lane by safe steps of second order.
//!
//! With φ = F − T < 0 and K ≥ φ″ on the segment, φ stays below the parabola φ + φ′δ + Kδ²/2, so no
//! crossing lies before its root. Near a crossing the steps become Newton's.

use super::gather::{ActiveBlob, ActiveLanes};
use super::{Job, few};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

/// Steps after which a lane is left to the solver for single rays.
const MOST_STEPS: usize = 48;

/// Below this part of the threshold φ may be rounding.
const NOISE: f32 = 1e-5;

/// Rounding of positions in a leaf, in parts of their size, times a margin for the steepness of a
/// field that is known only by its curvature.
const POSITION_NOISE: f32 = 2e-6;

/// What stepping found.
pub(super) struct Stepped<S: Simd> {
    /// Lanes with a crossing.
    pub(super) crossed: u32,
    /// Lanes that need the solver for single rays.
    pub(super) unclear: u32,
    /// Where the crossings are.
    pub(super) at: f32x16<S>,
}

/// First crossings on [0, length] of the lanes of `todo`, which travel outside; those of `at_start`
/// may be at their own start. `rise` bounds |φ″|, behind `last_approach` φ falls, `extent` bounds the
/// coordinates.
#[inline(always)]
pub(super) fn first_crossings<S: Simd, K: KernelShape, P: Primitive, const ALIKE: bool>(
    simd: S,
    job: &Job,
    active: &ActiveLanes,
    (todo, at_start): (u32, u32),
    (length, rise, last_approach): (f32x16<S>, f32x16<S>, f32x16<S>),
    extent: f32x16<S>,
) -> Stepped<S> {
    let zero = f32x16::splat(simd, 0.0);
    let tolerance = f32x16::splat(simd, job.tolerance);
    // A field that cannot bend upwards still gets a finite step.
    let rise = rise.max(f32x16::splat(simd, 1e-20));
    let mut at = zero;
    let mut crossings = zero;
    let (mut crossed, mut unclear, mut rest) = (0, 0, todo);
    // Where φ has not reached 0 by then it never will.
    let rounding = extent * POSITION_NOISE;
    let turn = last_approach + rounding;
    let end = length.min(turn);
    if at_start == 0 {
        if let [blob] = active.blobs() {
            return few::lone_blob::<S, K, P, ALIKE>(simd, job, blob, (todo, length));
        }
        at = few::first_support::<S, P, ALIKE>(simd, active);
        rest &= at.simd_le(length).to_bitmask() as u32;
    } else {
        // All blobs recede from a ray that leaves them.
        rest &= !(at_start & turn.simd_le(zero).to_bitmask() as u32);
        if rest == 0 {
            return Stepped {
                crossed,
                unclear,
                at,
            };
        }
    }
    for step in 0..MOST_STEPS {
        let (phi, slope) = sample::<S, K, P, ALIKE>(simd, job, active, at);
        let root = (slope * slope - rise * phi * 2.0).max(zero).sqrt();
        let inwards = slope.simd_gt(zero);
        // The larger root of the parabola, in the form that does not cancel.
        let ahead = inwards.select(phi * -2.0 / (root + slope), (root - slope) / rise);
        let mut delta = ahead;
        let mut beyond = phi.simd_ge(zero).to_bitmask() as u32;
        if step == 0 && at_start != 0 {
            // Leaving the surface, φ falls at least to the parabola's lowest point.
            let lowest = slope / -rise;
            let depth = phi + slope * lowest * 0.5;
            let scale = job.threshold.max(1.0);
            let noise = (rise * scale).sqrt() * rounding + NOISE * scale;
            let near_surface = (phi + noise).simd_gt(zero).to_bitmask() as u32;
            let leaves = (depth + noise * 4.0).simd_lt(zero).to_bitmask() as u32
                & !(inwards.to_bitmask() as u32);
            let leaving = at_start & near_surface & leaves;
            unclear |= at_start & near_surface & !leaves;
            rest &= !unclear;
            beyond &= !leaving;
            delta = phi.simd_ge(zero).select(lowest, ahead);
        }
        let next = at + delta;
        let bend = rise * delta;
        let close = delta.simd_le(tolerance).to_bitmask() as u32;
        // Steep enough for the crossing to be there: φ reaches 0 before it can bend back.
        let steep = slope.simd_gt(bend * 4.0).to_bitmask() as u32;
        unclear |= rest & close & !beyond & !steep;
        rest &= !unclear;
        // Where φ′ > 8Kδ the crossing lies at most 6Kδ²/φ′ behind the next step (−φ″ ≤ 2K).
        let in_leaf = next.simd_le(end).to_bitmask() as u32;
        let room = if job.any { length - next } else { tolerance };
        let near = (bend * delta * 6.0).simd_le(room * slope).to_bitmask() as u32;
        let sure = in_leaf & near & slope.simd_gt(bend * 8.0).to_bitmask() as u32;
        let found = rest & (beyond | close | sure);
        if found != 0 {
            let place = phi.simd_ge(zero).select(at, next).min(length);
            let lanes = mask32x16::from_bitmask(simd, u64::from(found));
            crossings = lanes.select(place, crossings);
            crossed |= found;
            rest &= !found;
        }
        rest &= in_leaf;
        if rest == 0 {
            break;
        }
        at = next;
    }
    Stepped {
        crossed,
        unclear: unclear | rest,
        at: crossings,
    }
}

/// φ and φ′ at one point per lane.
#[inline(always)]
fn sample<S: Simd, K: KernelShape, P: Primitive, const ALIKE: bool>(
    simd: S,
    job: &Job,
    active: &ActiveLanes,
    at: f32x16<S>,
) -> (f32x16<S>, f32x16<S>) {
    let none = [f32x16::splat(simd, 0.0); 2];
    // Two sums of each: one would wait for itself from blob to blob.
    let (mut even, mut odd) = (none, none);
    let (pairs, last) = active.blobs().as_chunks::<2>();
    for [first, second] in pairs {
        even = with_blob::<S, K, P, ALIKE>(simd, first, at, even);
        odd = with_blob::<S, K, P, ALIKE>(simd, second, at, odd);
    }
    if let [last] = last {
        even = with_blob::<S, K, P, ALIKE>(simd, last, at, even);
    }
    let ([sum, slope], [other_sum, other_slope]) = (even, odd);
    (
        sum + other_sum - job.threshold,
        (slope + other_slope) * (2.0 * K::SLOPE_FACTOR),
    )
}

/// Sums of F and of its slope in part, with one blob more.
#[inline(always)]
fn with_blob<S: Simd, K: KernelShape, P: Primitive, const ALIKE: bool>(
    simd: S,
    blob: &ActiveBlob,
    at: f32x16<S>,
    [sum, slope]: [f32x16<S>; 2],
) -> [f32x16<S>; 2] {
    let away = f32x16::from_slice(simd, &blob.c) - at;
    let pull = away * blob.beta_lanes::<S, P, ALIKE>(simd);
    let g0 = f32x16::from_slice(simd, &blob.g0);
    let g = Number::neg_mul_add(pull, away, g0).max(f32x16::splat(simd, 0.0));
    if ALIKE {
        let slope = Number::mul_add(K::slope_in_part(g), pull, slope);
        return [K::plus(g, sum), slope];
    }
    let weight = f32x16::splat(simd, blob.weight);
    [
        Number::mul_add(K::of_g(g), weight, sum),
        Number::mul_add(K::slope_in_part(g) * weight, pull, slope),
    ]
}
