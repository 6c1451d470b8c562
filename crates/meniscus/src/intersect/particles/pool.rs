//! The blobs that a ray has met and not yet left behind.

use super::ends::Ends;
use super::turning::Turning;
use crate::accel::cells::layout::{Block, LANES};
use crate::accel::particles::LeafTimes;
use crate::accel::particles::layout::{MOTION_COLUMNS, columns};
use crate::intersect::solve::Active;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Blobs as parabolas g(s) = g₀ − β(s − offset − c)², s counted from the ray's start; columns that are
/// longer than `count`. Two numbers for the middle, so that f32 is as good far along the ray as near
/// its start.
#[derive(Debug, Default)]
pub(super) struct Pool {
    pub(super) count: usize,
    c: Vec<f32>,
    offset: Vec<f32>,
    beta: Vec<f32>,
    g0: Vec<f32>,
    weight: Vec<f32>,
    /// Leaf number · 16 + lane, in the bits.
    place: Vec<f32>,
}

/// A leaf as a ray meets it.
pub(super) struct LeafRay<'a> {
    /// Its chunk of blobs.
    pub(super) chunk: &'a [Block],
    /// Its number.
    pub(super) leaf: u32,
    /// The ray's time.
    pub(super) times: LeafTimes,
    /// Where the ray enters it, relative to its centre.
    pub(super) origin: [f32; 3],
    /// Unit direction.
    pub(super) direction: [f32; 3],
    /// What is left of the ray there.
    pub(super) length: f32,
    /// How far along the ray that is.
    pub(super) near: f32,
}

impl Pool {
    /// Empties the pool.
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Makes room for `chunks` more chunks.
    #[inline(always)]
    fn reserve(&mut self, chunks: usize) {
        let wanted = self.count + (chunks + 1) * LANES;
        if self.c.len() < wanted {
            self.grow(wanted);
        }
    }

    #[cold]
    fn grow(&mut self, wanted: usize) {
        let length = wanted.next_power_of_two();
        for column in [
            &mut self.c,
            &mut self.offset,
            &mut self.beta,
            &mut self.g0,
            &mut self.weight,
            &mut self.place,
        ] {
            column.resize(length, 0.0);
        }
    }

    /// Sixteen lanes of all columns.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, at: usize) -> [f32x16<S>; 6] {
        let end = at + LANES;
        [
            f32x16::from_slice(simd, &self.c[at..end]),
            f32x16::from_slice(simd, &self.beta[at..end]),
            f32x16::from_slice(simd, &self.g0[at..end]),
            f32x16::from_slice(simd, &self.weight[at..end]),
            f32x16::from_slice(simd, &self.place[at..end]),
            f32x16::from_slice(simd, &self.offset[at..end]),
        ]
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, at: usize, lanes: [f32x16<S>; 6]) {
        let end = at + LANES;
        lanes[0].store_slice(&mut self.c[at..end]);
        lanes[1].store_slice(&mut self.beta[at..end]);
        lanes[2].store_slice(&mut self.g0[at..end]);
        lanes[3].store_slice(&mut self.weight[at..end]);
        lanes[4].store_slice(&mut self.place[at..end]);
        lanes[5].store_slice(&mut self.offset[at..end]);
    }

    /// Adds the blobs of a leaf that the ray meets.
    #[inline(always)]
    pub(super) fn add<S: Simd, P: Primitive>(&mut self, simd: S, ray: &LeafRay, ends: &mut Ends) {
        self.reserve(1);
        let zero = f32x16::splat(simd, 0.0);
        let origin: [f32x16<S>; 3] = splat3(simd, ray.origin);
        let since_middle = ray.times.since_middle_secs;
        let mut w = xyz(
            #[inline(always)]
            |k| center_at::<S, P>(simd, ray.chunk, k, since_middle) - origin[k],
        );
        let mut direction = splat3(simd, ray.direction);
        let motion = &ray.chunk[columns::<P>()..];
        if motion.len() > MOTION_COLUMNS {
            let turning = Turning::of(simd, &motion[MOTION_COLUMNS..], ray.times);
            (w, direction) = (turning.turned(w), turning.turned(direction));
        }
        let mut shape = [zero; 6];
        for k in 0..P::COLUMNS {
            shape[k] = f32x16::from_slice(simd, &ray.chunk[3 + k].0);
        }
        let line = P::along(&shape[..P::COLUMNS], w, direction);
        let away = line.c.max(zero).min(f32x16::splat(simd, ray.length)) - line.c;
        let meets = (line.g0 - line.beta * away * away).simd_gt(zero);
        let bits = meets.to_bitmask();
        if bits == 0 {
            return;
        }
        let weight = f32x16::from_slice(simd, &ray.chunk[3 + P::COLUMNS].0);
        let place = f32x16::from_slice(simd, &places(ray.leaf));
        self.store(
            self.count,
            [
                line.c.compress(meets),
                line.beta.compress(meets),
                line.g0.compress(meets),
                weight.compress(meets),
                place.compress(meets),
                f32x16::splat(simd, ray.near),
            ],
        );
        self.count += bits.count_ones() as usize;
        ends.note(simd, &line, meets, ray.near);
    }

    /// Drops what the ray leaves before `from`, and puts the blobs that the stretch of that length from
    /// there meets into `active`, relative to `from`. Returns an upper bound of the field on it.
    #[inline(always)]
    pub(super) fn advance<S: Simd, K: KernelShape>(
        &mut self,
        simd: S,
        from: f32,
        length: f32,
        active: &mut Active,
    ) -> f32 {
        let room = active.room(self.count, [None; 2]);
        let zero = f32x16::splat(simd, 0.0);
        let (kept, mut met) = (self.count, 0);
        self.count = 0;
        let mut upper = zero;
        let end = f32x16::splat(simd, length);
        for at in (0..kept).step_by(LANES) {
            let [middle, beta, g0, weight, place, offset] = self.lanes(simd, at);
            let c = middle + (offset - from);
            let behind = c.min(zero);
            let present = lanes_below(simd, kept - at);
            let keep = (g0 - beta * behind * behind).simd_gt(zero) & present;
            let away = c.max(zero).min(end) - c;
            let most = g0 - beta * away * away;
            let meets = most.simd_gt(zero) & present;
            let meets_bits = meets.to_bitmask();
            // Never behind what is still to be read.
            self.store(
                self.count,
                [
                    middle.compress(keep),
                    beta.compress(keep),
                    g0.compress(keep),
                    weight.compress(keep),
                    place.compress(keep),
                    offset.compress(keep),
                ],
            );
            self.count += keep.to_bitmask().count_ones() as usize;
            if meets_bits == 0 {
                continue;
            }
            let reached = meets.select(K::of_g(most.max(zero)), zero);
            upper = Number::mul_add(weight.max(zero), reached, upper);
            let target = met..met + LANES;
            c.compress(meets).store_slice(&mut room.c[target.clone()]);
            beta.compress(meets)
                .store_slice(&mut room.beta[target.clone()]);
            g0.compress(meets).store_slice(&mut room.g0[target.clone()]);
            weight.compress(meets).store_slice(&mut room.weight[target]);
            met += meets_bits.count_ones() as usize;
        }
        active.finish(met);
        upper.reduce_sum()
    }

    /// Calls `visit(leaf, lane)` with the blobs whose support holds the point `along` behind `from`, and
    /// with some whose border is next to it.
    #[inline(always)]
    pub(super) fn for_each_at<S: Simd>(
        &self,
        simd: S,
        (from, along): (f32, f32),
        mut visit: impl FnMut(u32, usize),
    ) {
        for first in (0..self.count).step_by(LANES) {
            let [c, beta, g0, _, _, offset] = self.lanes(simd, first);
            let away = c + (offset - from) - along;
            let reached = (g0 - beta * away * away).simd_gt(f32x16::splat(simd, -NEXT_TO))
                & lanes_below(simd, self.count - first);
            let mut bits = reached.to_bitmask() as u32;
            while bits != 0 {
                let place = self.place[first + bits.trailing_zeros() as usize].to_bits();
                bits &= bits - 1;
                visit(place / LANES as u32, place as usize % LANES);
            }
        }
    }
}

/// Coordinate `axis` of the blobs of a chunk, relative to the leaf's centre.
#[inline(always)]
pub(super) fn center_at<S: Simd, P: Primitive>(
    simd: S,
    chunk: &[Block],
    axis: usize,
    since_middle_secs: f32,
) -> f32x16<S> {
    let center = f32x16::from_slice(simd, &chunk[axis].0);
    let Some(rates) = chunk
        .get(columns::<P>()..)
        .filter(|rates| !rates.is_empty())
    else {
        return center;
    };
    let velocity = f32x16::from_slice(simd, &rates[axis].0);
    let half_acceleration = f32x16::from_slice(simd, &rates[3 + axis].0);
    let secs = f32x16::splat(simd, since_middle_secs);
    center + (velocity + half_acceleration * secs) * secs
}

/// g this little below 0 may be rounding.
const NEXT_TO: f32 = 1e-3;

/// The first `count` lanes.
#[inline(always)]
fn lanes_below<S: Simd>(simd: S, count: usize) -> <f32x16<S> as SimdBase<S>>::Mask {
    f32x16::from_slice(simd, &LANE_NUMBERS).simd_lt(f32x16::splat(simd, count as f32))
}

const LANE_NUMBERS: [f32; LANES] = {
    let mut numbers = [0.0; LANES];
    let mut lane = 0;
    while lane < LANES {
        numbers[lane] = lane as f32;
        lane += 1;
    }
    numbers
};

/// The places of a leaf's lanes.
#[inline(always)]
fn places(leaf: u32) -> [f32; LANES] {
    let mut places = [0.0; LANES];
    for (lane, place) in places.iter_mut().enumerate() {
        *place = f32::from_bits(leaf * LANES as u32 + lane as u32);
    }
    places
}
