//! Blobs that move: how they move against a cell, and what that means for its parts.

mod filter;
mod unrest;

use super::layout::LANES;
use super::list::{BlobList, lanes_at};
use super::place::Place;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

pub(super) use filter::{filter, is_settled};
pub(super) use unrest::{Unrest, way_spacings};

/// More pieces cost more than they find.
const MOST_PIECES: usize = 16;

/// A piece is short enough when blobs move less than this against the cell, in supports.
const PIECE_SUPPORTS: f32 = 0.1;

/// Cells above this side, in supports, take the shutter as one piece.
const ONE_PIECE_SIDE: f32 = 6.0;

/// How sixteen blobs move: place and velocity in the middle of the shutter, half the acceleration.
#[inline(always)]
fn motion_at<S: Simd, P: Primitive>(simd: S, list: &BlobList, at: usize) -> [[f32x16<S>; 3]; 3] {
    let first = list.stored.motion_at::<P>();
    let column = |k: usize| lanes_at(simd, list, k, at);
    [
        [column(0), column(1), column(2)],
        [column(first), column(first + 1), column(first + 2)],
        if list.stored.is_accelerated() {
            [column(first + 3), column(first + 4), column(first + 5)]
        } else {
            [f32x16::splat(simd, 0.0); 3]
        },
    ]
}

/// How sixteen blobs of a list move against a box.
struct Ways<S: Simd> {
    /// Velocity against it, in the middle of the shutter, and half the acceleration.
    velocity: [f32x16<S>; 3],
    bend: [f32x16<S>; 3],
    /// Lanes with a blob.
    is_blob: mask32x16<S>,
}

impl<S: Simd> Ways<S> {
    #[inline(always)]
    fn new<P: Primitive>(simd: S, list: &BlobList, drift: [f32x16<S>; 3], at: usize) -> Self {
        let [_, velocity, bend] = motion_at::<S, P>(simd, list, at);
        let blobs = LANES.min(list.count - at);
        Self {
            velocity: xyz(
                #[inline(always)]
                |k| velocity[k] - drift[k],
            ),
            bend,
            is_blob: mask32x16::from_bitmask(simd, (1 << blobs) - 1),
        }
    }
}

/// In how many pieces of the shutter bounds over parts of `place` are best taken.
pub(super) fn pieces_for<S: Simd, P: Primitive>(
    simd: S,
    list: &BlobList,
    place: &Place,
    support: f32,
) -> usize {
    if !list.stored.moves() || place.middle().size().max_element() > ONE_PIECE_SIDE * support {
        return 1;
    }
    let drift = place.drift().to_array();
    let squares = simd.vectorize(
        #[inline(always)]
        || {
            let drift: [f32x16<S>; 3] = splat3(simd, drift);
            let zero = f32x16::splat(simd, 0.0);
            let mut squares = zero;
            for at in (0..list.count).step_by(LANES) {
                let ways = Ways::new::<P>(simd, list, drift, at);
                let mut square = dot(ways.velocity, ways.velocity);
                if list.stored.is_accelerated() {
                    square += dot(ways.bend, ways.bend) * 4.0;
                }
                squares += ways.is_blob.select(square, zero);
            }
            squares.reduce_sum()
        },
    );
    let way = 2.0 * (squares / list.count.max(1) as f32).sqrt();
    let wanted = way / (PIECE_SUPPORTS * support);
    // Also where it is not a number.
    if wanted < MOST_PIECES as f32 {
        (wanted.ceil() as usize).next_power_of_two()
    } else {
        MOST_PIECES
    }
}

/// Part of the way that a blob moves against its cell which counts as its size: smaller cells would only
/// be crossed by more blobs.
const SIZE_OF_WAY: f32 = 0.5;

/// The smallest and the largest support of the blobs of `list`, each widened by how it moves against
/// `place`: what leaves are measured by. `support_of` takes a shape.
pub(super) fn leaf_scales<S: Simd, P: Primitive>(
    simd: S,
    list: &BlobList,
    place: &Place,
    support_of: impl Fn(&[f32]) -> f32,
) -> [f32; 2] {
    let drift = place.drift().to_array();
    let common = list.stored.shape.map(|shape| support_of(&shape));
    simd.vectorize(
        #[inline(always)]
        || {
            let drift: [f32x16<S>; 3] = splat3(simd, drift);
            let none = f32x16::splat(simd, f32::INFINITY);
            let zero = f32x16::splat(simd, 0.0);
            let (mut least, mut most) = (none, zero);
            for at in (0..list.count).step_by(LANES) {
                let ways = Ways::new::<P>(simd, list, drift, at);
                let mut way = dot(ways.velocity, ways.velocity).sqrt();
                if list.stored.is_accelerated() {
                    way += dot(ways.bend, ways.bend).sqrt();
                }
                let mut supports = [common.unwrap_or(f32::INFINITY); LANES];
                if common.is_none() {
                    for i in at..list.count.min(at + LANES) {
                        supports[i - at] = support_of(&list.shape::<P>(i));
                    }
                }
                let scale = way * (2.0 * SIZE_OF_WAY) + f32x16::from_slice(simd, &supports);
                least = ways.is_blob.select(scale, none).min(least);
                most = ways.is_blob.select(scale, zero).max(most);
            }
            [least.reduce_min(), most.reduce_max()]
        },
    )
}

/// How far the blobs near the middle of `place` move along `axis` between the middle of the shutter and
/// its end, on average.
pub(super) fn drift<P: Primitive>(list: &BlobList, place: &Place, axis: usize) -> f32 {
    if !list.stored.moves() {
        return 0.0;
    }
    let middle = place.middle();
    let at = middle.center()[axis];
    let near = 0.25 * middle.size()[axis];
    let places = &list.columns[axis][..list.count];
    let velocities = &list.columns[list.stored.motion_at::<P>() + axis][..list.count];
    let (mut sum, mut count) = (0.0, 0.0);
    for (place, velocity) in places.iter().zip(velocities) {
        let counts = if (place - at).abs() <= near { 1.0 } else { 0.0 };
        sum += counts * velocity;
        count += counts;
    }
    if count > 0.0 { sum / count } else { 0.0 }
}
