//! The blobs of a leaf that any ray of a packet meets, as a parabola g(s) = g₀ − β(s − c)² per ray.
//!
//! Most sets are balls of one radius and one weight. Those are [`Alike`]: with lengths along rays in
//! radii and fields in weights every β and every weight is 1, and half of the work falls away.

use super::Lanes;
use crate::accel::cells::layout::{Block, Columns, LANES};
use crate::intersect::cells::LeafView;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::{AlongLine, Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// What all blobs have in common where they are balls of one support radius and one positive weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Alike {
    /// Whether they are such balls.
    pub(super) are: bool,
    /// 1/R; 1 where they are not.
    pub(super) per_radius: f32,
    /// 1 where they are not.
    pub(super) weight: f32,
}

impl Alike {
    /// Those of a set with these columns.
    pub(super) fn of<P: Primitive>(stored: &Columns) -> Self {
        match (stored.shape, stored.weight) {
            (Some(shape), Some(weight)) if !P::BETA_TURNS && weight > 0.0 => Self {
                are: true,
                per_radius: shape[0],
                weight,
            },
            _ => Self {
                are: false,
                per_radius: 1.0,
                weight: 1.0,
            },
        }
    }
}

/// Rays among blobs that are alike.
struct AmongAlike<S: Simd> {
    /// Directions over R and times R.
    per_radius: [f32x16<S>; 3],
    times_radius: [f32x16<S>; 3],
    beta: f32,
}

impl<S: Simd> AmongAlike<S> {
    #[inline(always)]
    fn new(direction: [f32x16<S>; 3], alike: &Alike) -> Self {
        let times = |factor: f32| {
            xyz(
                #[inline(always)]
                |k| direction[k] * factor,
            )
        };
        Self {
            per_radius: times(alike.per_radius),
            times_radius: times(1.0 / alike.per_radius),
            beta: alike.per_radius * alike.per_radius,
        }
    }

    /// A blob along the rays in radii, `w` from their origins.
    #[inline(always)]
    fn along(&self, simd: S, w: [f32x16<S>; 3]) -> AlongLine<f32x16<S>> {
        let one = f32x16::splat(simd, 1.0);
        let c = dot(w, self.per_radius);
        let e = xyz(
            #[inline(always)]
            |k| Number::neg_mul_add(c, self.times_radius[k], w[k]),
        );
        AlongLine {
            c,
            beta: one,
            g0: Number::neg_mul_add(dot(e, e), f32x16::splat(simd, self.beta), one),
        }
    }
}

/// A blob that a packet meets.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct ActiveBlob {
    pub(super) c: [f32; LANES],
    pub(super) g0: [f32; LANES],
    beta: [f32; LANES],
    pub(super) weight: f32,
    /// β where it is the same for every ray; `beta` is not set then.
    common_beta: f32,
    /// Which blob of the leaf.
    pub(super) slot: u32,
}

impl ActiveBlob {
    /// β per lane.
    #[inline(always)]
    pub(super) fn beta_lanes<S: Simd, P: Primitive, const ALIKE: bool>(
        &self,
        simd: S,
    ) -> f32x16<S> {
        if ALIKE {
            f32x16::splat(simd, 1.0)
        } else if P::BETA_TURNS {
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
            g0: [0.0; LANES],
            beta: [0.0; LANES],
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
pub(super) struct Gathered<S: Simd> {
    /// Upper bound of the field.
    pub(super) upper: f32x16<S>,
    /// Upper bound of the field's second derivative along the ray.
    pub(super) rise: f32x16<S>,
    /// From here on all blobs recede, so that the field falls; infinite where some weight is negative.
    pub(super) last_approach: f32x16<S>,
}

/// Columns `first` and the two behind it of blob `lane` of a chunk, for every ray.
#[inline(always)]
fn three<S: Simd>(simd: S, chunk: &[Block], first: usize, lane: usize) -> [f32x16<S>; 3] {
    let columns = &chunk[first..first + 3];
    xyz(
        #[inline(always)]
        |k| f32x16::splat(simd, columns[k].0[lane]),
    )
}

impl LeafView<'_> {
    /// Centre of blob `lane` of a chunk at the rays' times.
    #[inline(always)]
    pub(super) fn center_of<S: Simd, P: Primitive, const MOVES: bool, const ALIKE: bool>(
        &self,
        simd: S,
        chunk: &[Block],
        lane: usize,
        phase: f32x16<S>,
    ) -> [f32x16<S>; 3] {
        let lane = lane % LANES;
        let place = three(simd, chunk, 0, lane);
        if !MOVES {
            return place;
        }
        let first = if ALIKE {
            // Neither shapes nor weights are stored.
            Columns::SHAPE
        } else {
            self.stored.motion_at::<P>()
        };
        let mut speed = three(simd, chunk, first, lane);
        if self.stored.is_accelerated() {
            let bend = three(simd, chunk, first + 3, lane);
            speed = xyz(
                #[inline(always)]
                |k| Number::mul_add(bend[k], phase, speed[k]),
            );
        }
        xyz(
            #[inline(always)]
            |k| Number::mul_add(speed[k], phase, place[k]),
        )
    }

    /// Shape and weight of blob `lane` of a chunk.
    #[inline(always)]
    pub(super) fn blob<P: Primitive>(&self, chunk: &[Block], lane: usize) -> ([f32; 6], f32) {
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

    /// Fills `active` with the blobs that lanes of `mask` meet on their segments, from `origin`
    /// relative to the leaf's centre, of `length`. With `ALIKE` what comes out is in radii and weights.
    #[inline(always)]
    pub(super) fn gather<
        S: Simd,
        K: KernelShape,
        P: Primitive,
        const MOVES: bool,
        const ALIKE: bool,
    >(
        &self,
        simd: S,
        alike: &Alike,
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
        let among = AmongAlike::new(lanes.direction, alike);
        let length = if ALIKE {
            length * alike.per_radius
        } else {
            length
        };
        for &slot in &active.kept[..kept] {
            let chunk = &self.chunks[slot as usize / LANES * per_chunk..];
            let center =
                self.center_of::<S, P, MOVES, ALIKE>(simd, chunk, slot as usize, lanes.phase);
            let w = xyz(
                #[inline(always)]
                |k| center[k] - origin[k],
            );
            let (line, weight, common_beta);
            if ALIKE {
                (line, weight, common_beta) = (among.along(simd, w), 1.0, 1.0);
            } else {
                let columns;
                (columns, weight) = self.blob::<P>(chunk, slot as usize);
                let mut shape = [zero; 6];
                for k in 0..P::COLUMNS {
                    shape[k] = f32x16::splat(simd, columns[k]);
                }
                line = P::along(&shape[..P::COLUMNS], w, lanes.direction);
                common_beta = columns[0] * columns[0];
            }
            let away = line.c.max(zero).min(length) - line.c;
            let most = Number::neg_mul_add(line.beta * away, away, line.g0).max(zero);
            let meets = most.simd_gt(zero);
            let g0 = meets.select(line.g0, zero);
            // No branch that depends on the blob: half of them meet the packet, and which is
            // anybody's guess.
            let positive = f32x16::splat(simd, weight.max(0.0));
            upper = if ALIKE {
                K::plus(most, upper)
            } else {
                Number::mul_add(K::of_g(most), positive, upper)
            };
            rise = Number::mul_add(line.beta * K::convex_bound(g0), positive, rise);
            last_approach = meets.select(line.c, last_approach).max(last_approach);
            if weight < 0.0 {
                last_approach = f32x16::splat(simd, f32::INFINITY);
                let bound = line.beta * K::concave_bound(g0);
                rise = Number::mul_add(bound, f32x16::splat(simd, -weight), rise);
            }
            let blob = &mut active.blobs[count];
            line.c.store_slice(&mut blob.c);
            line.g0.store_slice(&mut blob.g0);
            if P::BETA_TURNS {
                line.beta.store_slice(&mut blob.beta);
            }
            (blob.common_beta, blob.weight, blob.slot) = (common_beta, weight, slot);
            count += usize::from(meets.to_bitmask() as u32 & mask != 0);
        }
        active.count = count;
        Gathered {
            upper,
            rise,
            last_approach,
        }
    }
}
