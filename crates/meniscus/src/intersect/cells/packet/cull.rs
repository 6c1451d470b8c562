//! Which blobs of a leaf a packet can meet at all, with lanes for blobs.
//!
//! The packet's segments lie within a box along its rays. A ball whose centre is farther from the box
//! than its support reaches meets none of them. For ellipsoids the box is widened to a tube of radius r:
//! where a blob's q stays above (1 + |A| r)² along the tube's axis, none of the rays reaches its support.

use super::Lanes;
use super::visit::{least, most};
use crate::accel::cells::layout::{Block, LANES};
use crate::intersect::cells::LeafView;
use crate::intersect::cells::gather::{center_lanes, lanes as column, shape_lanes};
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

/// Rounding of q, with a margin.
const Q_MARGIN: f32 = 1e-4;

/// The axes of boxes about the rays of a packet.
pub(super) struct Frame<S: Simd> {
    /// Unit vectors at right angles: the direction of one of the rays, and two across.
    axes: [[f32; 3]; 3],
    /// How far each ray goes along them for its length.
    along: [f32x16<S>; 3],
}

impl<S: Simd> Frame<S> {
    /// For rays of these directions, `middle` being one of them.
    #[inline(always)]
    pub(super) fn new(simd: S, directions: [f32x16<S>; 3], middle: [f32; 3]) -> Self {
        let (across, other) = glam::Vec3::from_array(middle).any_orthonormal_pair();
        let axes = [middle, across.to_array(), other.to_array()];
        Self {
            axes,
            along: xyz(
                #[inline(always)]
                |k| dot(directions, splat3(simd, axes[k])),
            ),
        }
    }
}

/// A box that holds a packet's segments in a leaf, in the coordinates of a [`Frame`].
struct Around {
    middle: [f32; 3],
    half: [f32; 3],
}

impl Around {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        frame: &Frame<S>,
        (mask, origin, length): (u32, [f32x16<S>; 3], f32x16<S>),
    ) -> Self {
        let mask = mask32x16::from_bitmask(simd, u64::from(mask));
        let ends = xyz(
            #[inline(always)]
            |k| {
                let start = dot(origin, splat3(simd, frame.axes[k]));
                let end = Number::mul_add(frame.along[k], length, start);
                [
                    least(simd, mask, start.min(end)),
                    most(simd, mask, start.max(end)),
                ]
            },
        );
        Self {
            middle: xyz(
                #[inline(always)]
                |k| 0.5 * (ends[k][0] + ends[k][1]),
            ),
            half: xyz(
                #[inline(always)]
                |k| 0.5 * (ends[k][1] - ends[k][0]),
            ),
        }
    }

    /// Its middle in the coordinates of the leaf.
    #[inline(always)]
    fn place<S: Simd>(&self, frame: &Frame<S>) -> [f32; 3] {
        let column = xyz(
            #[inline(always)]
            |k| [frame.axes[0][k], frame.axes[1][k], frame.axes[2][k]],
        );
        xyz(
            #[inline(always)]
            |k| dot(self.middle, column[k]),
        )
    }
}

impl LeafView<'_> {
    /// Puts the places of the blobs that some segment of the packet may meet into `kept`, and returns
    /// how many. The segments begin at `origin`, relative to the leaf's centre.
    #[inline(always)]
    pub(super) fn cull<S: Simd, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        lanes: &Lanes<'_, S>,
        segments: (u32, [f32x16<S>; 3], f32x16<S>),
        kept: &mut Vec<u32>,
    ) -> usize {
        let room = self.header.count.next_multiple_of(LANES) + LANES;
        if kept.len() < room {
            kept.resize(room, 0);
        }
        let kept = &mut kept[..room];
        let frame = &lanes.frame;
        let around = Around::new(simd, frame, segments);
        let place: [f32x16<S>; 3] = splat3(simd, around.place(frame));
        let [_, across, other] = around.half;
        let radius = f32x16::splat(simd, (across * across + other * other).sqrt());
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let [first, last] = lanes.phases;
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let mut slots = u32x16::from_slice(simd, &SLOTS);
        let mut count = 0;
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        let mut rest = self.chunks;
        while let Some((chunk, behind)) = rest.split_at_checked(per_chunk) {
            rest = behind;
            let w = xyz(
                #[inline(always)]
                |k| {
                    let center = if MOVES {
                        center_lanes::<S, P>(simd, self.stored, chunk, k, middle)
                    } else {
                        column(simd, chunk, k)
                    };
                    center - place[k]
                },
            );
            let shape = shape_lanes::<S, P>(simd, self.stored, chunk);
            let mut reach = if MOVES {
                self.way::<S, P>(simd, chunk, (middle, half))
            } else {
                zero
            };
            let (q, norm);
            if P::BETA_TURNS {
                let axis: [f32x16<S>; 3] = splat3(simd, frame.axes[0]);
                let line = P::along(&shape[..P::COLUMNS], w, axis);
                let far = f32x16::splat(simd, around.half[0]);
                let away = line.c.max(-far).min(far) - line.c;
                q = one - line.g0 + line.beta * away * away;
                let mut square = shape[0] * shape[0];
                for a in &shape[1..P::COLUMNS] {
                    square = Number::mul_add(*a, *a, square);
                }
                norm = square.sqrt();
                reach += radius;
            } else {
                let away = xyz(
                    #[inline(always)]
                    |k| {
                        let along = dot(w, splat3(simd, frame.axes[k]));
                        (along.abs() - around.half[k]).max(zero)
                    },
                );
                norm = shape[0];
                q = dot(away, away) * (norm * norm);
            }
            let reach = Number::mul_add(norm, reach, one);
            let limit = Number::mul_add(reach, reach, f32x16::splat(simd, Q_MARGIN));
            let meets = q.simd_lt(limit);
            slots
                .compress(meets)
                .store_slice(&mut kept[count..count + LANES]);
            count += meets.to_bitmask().count_ones() as usize;
            slots += 16;
        }
        count
    }

    /// How far a chunk's blobs are at most from where they are in the middle of a stretch of time,
    /// (middle, half length) from −1 to 1.
    #[inline(always)]
    fn way<S: Simd, P: Primitive>(
        &self,
        simd: S,
        chunk: &[Block],
        (middle, half): (f32, f32),
    ) -> f32x16<S> {
        let first = self.stored.motion_at::<P>();
        let velocity: [f32x16<S>; 3] = xyz(
            #[inline(always)]
            |k| column(simd, chunk, first + k),
        );
        if !self.stored.is_accelerated() {
            return dot(velocity, velocity).sqrt() * half;
        }
        let bend = xyz(
            #[inline(always)]
            |k| column(simd, chunk, first + 3 + k),
        );
        let speed = xyz(
            #[inline(always)]
            |k| bend[k] * (2.0 * middle) + velocity[k],
        );
        // Bends are short, so a sum of sizes does for their length.
        let bend = bend[0].abs() + bend[1].abs() + bend[2].abs();
        Number::mul_add(bend, f32x16::splat(simd, half), dot(speed, speed).sqrt()) * half
    }
}

/// The places of the first chunk's blobs.
const SLOTS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
