//! A packet in one leaf: gathers the blobs that any of its rays meets, steps to the crossings, and
//! takes the gradient there.

use super::step::{self, Stepped};
use super::{Job, Lanes, Outcome};
use crate::accel::cells::layout::{Block, Columns, LANES};
use crate::intersect::cells::LeafView;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};

/// A blob that a packet meets: a parabola g(s) = g₀ − β(s − c)² per lane.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct ActiveBlob {
    pub(super) c: [f32; LANES],
    beta: [f32; LANES],
    pub(super) g0: [f32; LANES],
    pub(super) weight: f32,
    /// β where it is the same for every ray; `beta` is not set then.
    common_beta: f32,
    /// Which blob of the leaf.
    slot: u32,
}

impl ActiveBlob {
    /// β per lane.
    #[inline(always)]
    pub(super) fn beta_lanes<S: Simd, P: Primitive>(&self, simd: S) -> f32x16<S> {
        if P::BETA_TURNS {
            f32x16::from_slice(simd, &self.beta)
        } else {
            f32x16::splat(simd, self.common_beta)
        }
    }
}

/// The blobs that a packet meets in a leaf.
#[derive(Debug, Default)]
pub(super) struct ActiveLanes {
    blobs: Vec<ActiveBlob>,
    count: usize,
    /// Places of the leaf's blobs near the packet.
    kept: Vec<u32>,
}

impl ActiveLanes {
    /// Makes room for every blob of a leaf of `count` blobs and one more.
    #[inline(always)]
    fn reserve(&mut self, count: usize) {
        if self.blobs.len() <= count {
            self.grow(count + 1);
        }
    }

    #[cold]
    fn grow(&mut self, len: usize) {
        const NONE: ActiveBlob = ActiveBlob {
            c: [0.0; LANES],
            beta: [0.0; LANES],
            g0: [0.0; LANES],
            weight: 0.0,
            common_beta: 0.0,
            slot: 0,
        };
        self.blobs.resize(len, NONE);
    }

    #[inline(always)]
    pub(super) fn blobs(&self) -> &[ActiveBlob] {
        &self.blobs[..self.count]
    }
}

/// Bounds over the packet's segments in a leaf.
struct Gathered<S: Simd> {
    /// Upper bound of the field.
    upper: f32x16<S>,
    /// Upper bound of the field's second derivative along the ray.
    rise: f32x16<S>,
    /// From here on all blobs recede, so that the field falls; infinite where some weight is negative.
    last_approach: f32x16<S>,
}

impl LeafView<'_> {
    /// Centre of blob `lane` of a chunk at the rays' times.
    #[inline(always)]
    fn center_of<S: Simd, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        chunk: &[Block],
        lane: usize,
        phase: f32x16<S>,
    ) -> [f32x16<S>; 3] {
        let lane = lane % LANES;
        let chunk = &chunk[..self.stored.blocks_per_chunk::<P>()];
        let number = |k: usize| f32x16::splat(simd, chunk[k].0[lane]);
        let first = self.stored.motion_at::<P>();
        xyz(
            #[inline(always)]
            |k| {
                if !MOVES {
                    return number(k);
                }
                let mut speed = number(first + k);
                if self.stored.is_accelerated() {
                    speed = Number::mul_add(number(first + 3 + k), phase, speed);
                }
                Number::mul_add(speed, phase, number(k))
            },
        )
    }

    /// Shape and weight of blob `lane` of a chunk.
    #[inline(always)]
    fn blob<P: Primitive>(&self, chunk: &[Block], lane: usize) -> ([f32; 6], f32) {
        let lane = lane % LANES;
        let chunk = &chunk[..self.stored.blocks_per_chunk::<P>()];
        let shape = match self.stored.shape {
            Some(constant) => constant,
            None => {
                let mut shape = [0.0; 6];
                for k in 0..P::COLUMNS {
                    shape[k] = chunk[Columns::SHAPE + k].0[lane];
                }
                shape
            }
        };
        let weight = match self.stored.weight {
            Some(constant) => constant,
            None => chunk[self.stored.weight_at::<P>()].0[lane],
        };
        (shape, weight)
    }

    /// Where the lanes' segments begin, relative to the leaf's centre.
    #[inline(always)]
    fn origin<S: Simd>(&self, simd: S, lanes: &Lanes<'_, S>, near: f32x16<S>) -> [f32x16<S>; 3] {
        let near: [f32; LANES] = near.to_array();
        xyz(
            #[inline(always)]
            |axis| {
                let origin = &lanes.prepared.origin[axis];
                let direction = &lanes.prepared.direction[axis];
                let center = f64::from(self.header.center[axis]);
                let mut relative = [0.0; LANES];
                for lane in 0..LANES {
                    let along = direction[lane] * f64::from(near[lane]);
                    relative[lane] = (origin[lane] + along - center) as f32;
                }
                f32x16::from_slice(simd, &relative)
            },
        )
    }

    /// Traces the lanes of `mask` through the leaf; returns those that are done.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "one call, inlined")]
    pub(super) fn trace<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        job: &Job,
        lanes: &mut Lanes<'_, S>,
        active: &mut ActiveLanes,
        (mask, near, far): (u32, f32x16<S>, f32x16<S>),
        seen_leaf: &mut u32,
        outcomes: &mut [Outcome; LANES],
    ) -> u32 {
        if self.header.fine_beta < f32::INFINITY {
            set(outcomes, mask, Outcome::Alone);
            return mask;
        }
        let origin = self.origin(simd, lanes, near);
        let length = far - near;
        let gathered = self.gather::<S, K, P, MOVES>(simd, lanes, (mask, origin, length), active);
        // The ray starts in a dropped cell, and whether that agrees with what it states is not known.
        let away = near
            .simd_gt(f32x16::splat(simd, job.start_margin))
            .to_bitmask() as u32;
        let doubtful =
            mask & away & !*seen_leaf & !lanes.on_stated_side & !lanes.prepared.side_is_proven;
        *seen_leaf |= mask;
        let reached = gathered
            .upper
            .simd_ge(f32x16::splat(simd, job.threshold))
            .to_bitmask() as u32;
        lanes.on_stated_side |= mask & !doubtful & !reached;
        let todo = mask & reached & !doubtful;
        let mut alone = doubtful;
        let mut done = 0;
        if todo != 0 {
            // Elsewhere a field above the threshold at entry means that the surface lies at this seam.
            let at_start = todo
                & !lanes.prepared.side_is_proven
                & !(lanes.on_stated_side & (away | !lanes.prepared.starts_at_t_min));
            let Stepped {
                crossed,
                unclear,
                at,
            } = step::first_crossings::<S, K, P>(
                simd,
                job,
                active,
                (todo, at_start),
                (length, gathered.rise, gathered.last_approach),
                origin[0]
                    .abs()
                    .max(origin[1].abs())
                    .max(origin[2].abs())
                    .max(length),
            );
            let at_own_start = (near + at)
                .simd_lt(f32x16::splat(simd, job.near_start))
                .to_bitmask() as u32
                & lanes.prepared.starts_at_t_min
                & !lanes.prepared.side_is_proven;
            let unclear = unclear | crossed & at_own_start;
            let crossed = crossed & !unclear;
            alone |= unclear;
            done = crossed;
            lanes.on_stated_side |= todo & !crossed & !unclear;
            if crossed != 0 && job.any {
                set(
                    outcomes,
                    crossed,
                    Outcome::Hit {
                        t: 0.0,
                        outward: [0.0; 3],
                        strongest: 0,
                    },
                );
            } else if crossed != 0 {
                let point = xyz(
                    #[inline(always)]
                    |axis| Number::mul_add(lanes.direction[axis], at, origin[axis]),
                );
                let (outward, strongest) =
                    self.gradient::<S, K, P, MOVES>(simd, active, point, lanes.phase);
                let (near, at): ([f32; LANES], [f32; LANES]) = (near.to_array(), at.to_array());
                for lane in 0..LANES {
                    if crossed >> lane & 1 == 1 {
                        outcomes[lane] = Outcome::Hit {
                            t: f64::from(near[lane]) + f64::from(at[lane]),
                            outward: [outward[0][lane], outward[1][lane], outward[2][lane]],
                            strongest: strongest[lane],
                        };
                    }
                }
            }
        }
        set(outcomes, alone, Outcome::Alone);
        done | alone
    }

    #[inline(always)]
    fn gather<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        lanes: &Lanes<'_, S>,
        (mask, origin, length): (u32, [f32x16<S>; 3], f32x16<S>),
        active: &mut ActiveLanes,
    ) -> Gathered<S> {
        let zero = f32x16::splat(simd, 0.0);
        let (mut upper, mut rise) = (zero, zero);
        let mut last_approach = f32x16::splat(simd, f32::MIN);
        let mut count = 0;
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        active.reserve(self.header.count);
        let kept = self.cull::<S, P, MOVES>(simd, lanes, (mask, origin, length), &mut active.kept);
        for &slot in &active.kept[..kept] {
            let chunk = &self.chunks[slot as usize / LANES * per_chunk..];
            let (columns, weight) = self.blob::<P>(chunk, slot as usize);
            let center = self.center_of::<S, P, MOVES>(simd, chunk, slot as usize, lanes.phase);
            let w = xyz(
                #[inline(always)]
                |k| center[k] - origin[k],
            );
            let mut shape = [zero; 6];
            for k in 0..P::COLUMNS {
                shape[k] = f32x16::splat(simd, columns[k]);
            }
            let line = P::along(&shape[..P::COLUMNS], w, lanes.direction);
            let away = line.c.max(zero).min(length) - line.c;
            let most = (line.g0 - line.beta * away * away).max(zero);
            let meets = most.simd_gt(zero);
            let g0 = meets.select(line.g0, zero);
            // No branch that depends on the blob: half of them meet the packet, and which is
            // anybody's guess.
            let positive = f32x16::splat(simd, weight.max(0.0));
            upper = Number::mul_add(K::of_g(most), positive, upper);
            let bound = line.beta * K::convex_bound(g0);
            rise = Number::mul_add(bound, positive, rise);
            last_approach = meets.select(line.c, last_approach).max(last_approach);
            if weight < 0.0 {
                last_approach = f32x16::splat(simd, f32::INFINITY);
                let bound = line.beta * K::concave_bound(g0);
                rise = Number::mul_add(bound, f32x16::splat(simd, -weight), rise);
            }
            let blob = &mut active.blobs[count];
            line.c.store_slice(&mut blob.c);
            if P::BETA_TURNS {
                line.beta.store_slice(&mut blob.beta);
            } else {
                blob.common_beta = columns[0] * columns[0];
            }
            line.g0.store_slice(&mut blob.g0);
            blob.weight = weight;
            blob.slot = slot;
            count += usize::from(meets.to_bitmask() as u32 & mask != 0);
        }
        active.count = count;
        Gathered {
            upper,
            rise,
            last_approach,
        }
    }

    /// −∇F and the strongest blob at one point per lane.
    #[inline(always)]
    fn gradient<S: Simd, K: KernelShape, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        active: &ActiveLanes,
        point: [f32x16<S>; 3],
        phase: f32x16<S>,
    ) -> ([[f32; LANES]; 3], [u32; LANES]) {
        let zero = f32x16::splat(simd, 0.0);
        let mut sum = [zero; 3];
        let mut best = f32x16::splat(simd, -1.0);
        let mut best_index = u32x16::splat(simd, 0);
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        for blob in active.blobs() {
            let slot = blob.slot as usize;
            let chunk = &self.chunks[slot / LANES * per_chunk..];
            let (columns, weight) = self.blob::<P>(chunk, slot);
            let center = self.center_of::<S, P, MOVES>(simd, chunk, slot, phase);
            let d = xyz(
                #[inline(always)]
                |k| point[k] - center[k],
            );
            let mut shape = [zero; 6];
            for k in 0..P::COLUMNS {
                shape[k] = f32x16::splat(simd, columns[k]);
            }
            let y = P::transform(&shape[..P::COLUMNS], d);
            let g = (dot(y, y) * -1.0 + 1.0).max(zero);
            // ∂g/∂x = −2 Aᵀy, so −∇F sums w·k′(g)·2·Aᵀy.
            let scale = K::slope(g) * (2.0 * weight);
            let pull = P::transform_transposed(&shape[..P::COLUMNS], y);
            for k in 0..3 {
                sum[k] = Number::mul_add(scale, pull[k], sum[k]);
            }
            let strength = (K::of_g(g) * weight).abs();
            let stronger = strength.simd_gt(best);
            best = stronger.select(strength, best);
            best_index = stronger.select(
                u32x16::splat(simd, chunk[per_chunk - 1].0[slot % LANES].to_bits()),
                best_index,
            );
        }
        (
            [sum[0].to_array(), sum[1].to_array(), sum[2].to_array()],
            best_index.to_array(),
        )
    }
}

#[inline(always)]
fn set(outcomes: &mut [Outcome; LANES], mask: u32, outcome: Outcome) {
    for (lane, slot) in outcomes.iter_mut().enumerate() {
        if mask >> lane & 1 == 1 {
            *slot = outcome;
        }
    }
}
