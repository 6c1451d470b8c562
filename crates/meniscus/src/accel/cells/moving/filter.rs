//! What [`filter`](crate::accel::cells::filter) does for blobs that move and boxes whose faces move.
//!
//! The shutter's time s runs from −1 to 1 and is cut into pieces [u − h, u + h]. There the centre of the
//! box less that of a blob is d + r·δ − a'·δ² with |δ| ≤ h, d their distance at u, r their relative
//! velocity and a' half the blob's acceleration. So A(x − p) stays within
//! E = |A|(half + h|ḣalf|) + h|A·r| + h²|A·a'| of A·d, and bounds follow as for boxes at rest; those of
//! second order with displacements of up to half + h|r| + h²|a'| along each axis. Bounds over the shutter
//! are the widest of its pieces.

use super::motion_at;
use crate::accel::cells::filter::{BlobLanes, FieldBounds, Sums, qmin};
use crate::accel::cells::layout::LANES;
use crate::accel::cells::list::{BlobList, copy_lanes};
use crate::accel::cells::place::Place;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::Vec3;

/// Blobs against a box during one piece of the shutter: A(x − p) stays within `e` of `y`, and the box
/// moves against them at `r`.
struct Against<S: Simd> {
    y: [f32x16<S>; 3],
    e: [f32x16<S>; 3],
    r: [f32x16<S>; 3],
}

/// A box during one piece of the shutter.
struct Piece<S: Simd> {
    at: f32x16<S>,
    reach: f32x16<S>,
    center: [f32x16<S>; 3],
    velocity: [f32x16<S>; 3],
    half: Vec3,
    sums: Sums<S>,
    /// Σ ∇(w·k)·r and Σ |∇(w·k)·a'|.
    along: f32x16<S>,
    bent: f32x16<S>,
}

impl<S: Simd> Piece<S> {
    #[inline(always)]
    fn new(simd: S, place: &Place, piece: usize, pieces: usize) -> Self {
        let reach = 1.0 / pieces as f32;
        let at = (2 * piece + 1) as f32 * reach - 1.0;
        let [open, close] = place.ends;
        let middle = place.middle();
        let velocity = place.drift();
        let widening = 0.25 * (close.size() - open.size());
        let half = 0.5 * middle.size() + at * widening + reach * widening.abs();
        let zero = f32x16::splat(simd, 0.0);
        Self {
            at: f32x16::splat(simd, at),
            reach: f32x16::splat(simd, reach),
            center: splat3(simd, (middle.center() + velocity * at).to_array()),
            velocity: splat3(simd, velocity.to_array()),
            // Rounded so that the box is covered.
            half: half * 1.000_000_4,
            sums: Sums::new(simd),
            along: zero,
            bent: zero,
        }
    }

    /// Where sixteen blobs are.
    #[inline(always)]
    fn against<P: Primitive>(
        &self,
        simd: S,
        blobs: &BlobLanes<S, P>,
        [place, velocity, bend]: &[[f32x16<S>; 3]; 3],
    ) -> Against<S> {
        let d = xyz(
            #[inline(always)]
            |k| {
                let speed = Number::mul_add(bend[k], self.at, velocity[k]);
                Number::mul_add(speed, -self.at, self.center[k] - place[k])
            },
        );
        let r = xyz(
            #[inline(always)]
            |k| self.velocity[k] - velocity[k] - bend[k] * self.at * 2.0,
        );
        let y = blobs.transformed(d);
        let (turned, bent) = (blobs.transformed(r), blobs.transformed(*bend));
        let still = blobs.extent(splat3(simd, self.half.to_array()));
        let h = self.reach;
        let e = xyz(
            #[inline(always)]
            |k| {
                let turned = Number::mul_add(bent[k].abs(), h, turned[k].abs());
                Number::mul_add(turned, h, still[k])
            },
        );
        Against { y, e, r }
    }

    /// Adds sixteen blobs; returns their qmin.
    #[inline(always)]
    fn add<K: KernelShape, P: Primitive>(
        &mut self,
        simd: S,
        blobs: &BlobLanes<S, P>,
        motion: &[[f32x16<S>; 3]; 3],
        close: bool,
    ) -> f32x16<S> {
        let Against { y, e, r } = self.against::<P>(simd, blobs, motion);
        let reached = self.sums.add_reached::<K, P>(simd, blobs, y, e);
        if close {
            let (h, bend, half) = (self.reach, motion[2], self.half.to_array());
            let away = xyz(
                #[inline(always)]
                |k| {
                    let speed = Number::mul_add(bend[k].abs(), h, r[k].abs());
                    Number::mul_add(speed, h, f32x16::splat(simd, half[k]))
                },
            );
            let reach = dot(away, away) * 0.5;
            let gradient = self
                .sums
                .add_close::<K, P>(simd, blobs, y, &reached, Some(reach));
            self.along += dot(gradient, r);
            self.bent += dot(gradient, bend).abs();
        }
        reached.qmin
    }

    #[inline(always)]
    fn bounds(&self, close: bool, reach: f32) -> FieldBounds {
        let bounds = self.sums.interval();
        if !close {
            return bounds;
        }
        let (value, slope) = self.sums.value_and_slope(self.half);
        let in_time = (self.along.reduce_sum().abs() + self.bent.reduce_sum() * reach) * reach;
        bounds.and(self.sums.second_order((value, slope + in_time), 1.0))
    }
}

/// [`crate::accel::cells::filter::is_settled`] for blobs that move: what one piece of the shutter leaves open, the
/// others do not settle.
#[inline(never)]
pub(in crate::accel::cells) fn is_settled<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    place: &Place,
    mut settled: impl FnMut(FieldBounds) -> bool,
) -> bool {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut bounds = FieldBounds::NONE;
            let pieces = list.pieces.max(1);
            for piece in 0..pieces {
                let mut piece = Piece::new(simd, place, piece, pieces);
                for at in (0..list.count).step_by(LANES) {
                    let blobs = BlobLanes::<S, P>::new(simd, list, at);
                    let motion = motion_at::<S, P>(simd, list, at);
                    piece.add::<K, P>(simd, &blobs, &motion, true);
                }
                bounds = bounds.or(piece.bounds(true, 1.0 / pieces as f32));
                if !settled(bounds) {
                    return false;
                }
            }
            true
        },
    )
}

/// [`crate::accel::cells::filter::filter`] for blobs that move; blobs that reach the box at any time are kept.
#[inline(never)]
pub(in crate::accel::cells) fn filter<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    from: &BlobList,
    place: &Place,
    close: bool,
    to: &mut BlobList,
    mut settled: impl FnMut(FieldBounds) -> bool,
) -> bool {
    to.reset::<P>(from.stored, from.count);
    let chunks = from.count.div_ceil(LANES);
    let mut reached = std::mem::take(&mut to.reached);
    reached.clear();
    reached.resize(chunks, 0_u16);
    let mut bounds = FieldBounds::NONE;
    let mut is_settled = true;
    simd.vectorize(
        #[inline(always)]
        || {
            let one = f32x16::splat(simd, 1.0);
            let pieces = from.pieces.max(1);
            for piece in 0..pieces {
                let mut piece = Piece::new(simd, place, piece, pieces);
                for (chunk, reached) in reached.iter_mut().enumerate() {
                    if !is_settled && *reached == u16::MAX {
                        continue;
                    }
                    let at = chunk * LANES;
                    let blobs = BlobLanes::<S, P>::new(simd, from, at);
                    let motion = motion_at::<S, P>(simd, from, at);
                    let qmin = if is_settled {
                        piece.add::<K, P>(simd, &blobs, &motion, close)
                    } else {
                        // What is left to be known is who reaches the box.
                        let Against { y, e, .. } = piece.against::<P>(simd, &blobs, &motion);
                        qmin(simd, y, e)
                    };
                    *reached |= qmin.simd_lt(one).to_bitmask() as u16;
                }
                if is_settled {
                    bounds = bounds.or(piece.bounds(close, 1.0 / pieces as f32));
                    is_settled = settled(bounds);
                }
            }
            let mut count = 0;
            for (chunk, &bits) in reached.iter().enumerate() {
                if bits != 0 {
                    let mask = mask32x16::from_bitmask(simd, u64::from(bits));
                    copy_lanes(simd, from, chunk * LANES, mask, to, count);
                    count += bits.count_ones() as usize;
                }
            }
            to.count = count;
        },
    );
    to.reached = reached;
    to.pad::<P>();
    is_settled
}
