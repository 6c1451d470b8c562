//! Which blobs of a leaf a packet can meet at all, with lanes for blobs.
//!
//! The packet's segments lie within a tube about the line of one of its rays, of radius r. Where a
//! blob's q stays above (1 + |A| r)² along that line, none of the rays reaches its support.

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

/// Lanes to take the tube's axis from, the middle ones of four by four neighbours first.
const MIDDLE: [usize; 4] = [5, 10, 6, 9];

/// Rounding of q, with a margin.
const Q_MARGIN: f32 = 1e-4;

/// A tube that holds a packet's segments in a leaf.
struct Tube {
    origin: [f32; 3],
    direction: [f32; 3],
    radius: f32,
    /// Where along the axis the segments lie.
    from: f32,
    to: f32,
}

impl Tube {
    #[inline(always)]
    fn new<S: Simd>(
        simd: S,
        lanes: &Lanes<'_, S>,
        (mask, origin, length): (u32, [f32x16<S>; 3], f32x16<S>),
    ) -> Self {
        let mut middle = mask.trailing_zeros() as usize % LANES;
        for lane in MIDDLE {
            if mask >> lane & 1 == 1 {
                middle = lane;
                break;
            }
        }
        let axis_origin = xyz(
            #[inline(always)]
            |k| {
                let origin: [f32; LANES] = origin[k].to_array();
                origin[middle]
            },
        );
        let axis_direction = xyz(
            #[inline(always)]
            |k| lanes.prepared.direction_f32[k][middle],
        );
        let direction: [f32x16<S>; 3] = splat3(simd, axis_direction);
        let start = xyz(
            #[inline(always)]
            |k| origin[k] - axis_origin[k],
        );
        let end = xyz(
            #[inline(always)]
            |k| Number::mul_add(lanes.direction[k], length, start[k]),
        );
        let (start_along, end_along) = (dot(start, direction), dot(end, direction));
        let square =
            square_away(start, start_along, direction).max(square_away(end, end_along, direction));
        let mask = mask32x16::from_bitmask(simd, u64::from(mask));
        Self {
            origin: axis_origin,
            direction: axis_direction,
            radius: most(simd, mask, square).sqrt(),
            from: least(simd, mask, start_along),
            to: most(simd, mask, end_along),
        }
    }
}

/// Squared distance of points from a line through the origin.
#[inline(always)]
fn square_away<S: Simd>(
    point: [f32x16<S>; 3],
    along: f32x16<S>,
    direction: [f32x16<S>; 3],
) -> f32x16<S> {
    let away = xyz(
        #[inline(always)]
        |k| point[k] - along * direction[k],
    );
    dot(away, away)
}

impl LeafView<'_> {
    /// Puts the places of the blobs that some segment of the packet may meet into `kept`, and returns
    /// how many. The segments begin at `origin`, relative to the leaf's centre.
    #[inline(always)]
    pub(super) fn cull<S: Simd, P: Primitive, const MOVES: bool>(
        &self,
        simd: S,
        lanes: &Lanes<'_, S>,
        (mask, origin, length): (u32, [f32x16<S>; 3], f32x16<S>),
        kept: &mut Vec<u32>,
    ) -> usize {
        let room = self.header.count.next_multiple_of(LANES) + LANES;
        if kept.len() < room {
            kept.resize(room, 0);
        }
        let tube = Tube::new(simd, lanes, (mask, origin, length));
        let origin: [f32x16<S>; 3] = splat3(simd, tube.origin);
        let direction: [f32x16<S>; 3] = splat3(simd, tube.direction);
        let (from, to) = (f32x16::splat(simd, tube.from), f32x16::splat(simd, tube.to));
        let one = f32x16::splat(simd, 1.0);
        let [first, last] = lanes.phases;
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let mut slots = u32x16::from_slice(simd, &SLOTS);
        let mut count = 0;
        let per_chunk = self.stored.blocks_per_chunk::<P>();
        for chunk in self.chunks.chunks_exact(per_chunk) {
            let w = xyz(
                #[inline(always)]
                |k| {
                    let center = if MOVES {
                        center_lanes::<S, P>(simd, self.stored, chunk, k, middle)
                    } else {
                        column(simd, chunk, k)
                    };
                    center - origin[k]
                },
            );
            let shape = shape_lanes::<S, P>(simd, self.stored, chunk);
            let line = P::along(&shape[..P::COLUMNS], w, direction);
            let away = line.c.max(from).min(to) - line.c;
            let q = one - line.g0 + line.beta * away * away;
            let mut norm = shape[0] * shape[0];
            for a in &shape[1..P::COLUMNS] {
                norm = Number::mul_add(*a, *a, norm);
            }
            let mut radius = f32x16::splat(simd, tube.radius);
            if MOVES {
                radius += self.way::<S, P>(simd, chunk, (middle, half));
            }
            let reach = Number::mul_add(norm.sqrt(), radius, one);
            let limit = Number::mul_add(reach, reach, f32x16::splat(simd, Q_MARGIN));
            let meets = q.simd_lt(limit);
            let bits = meets.to_bitmask();
            if bits != 0 {
                slots
                    .compress(meets)
                    .store_slice(&mut kept[count..count + LANES]);
                count += bits.count_ones() as usize;
            }
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
