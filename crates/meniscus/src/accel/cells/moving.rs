//! What [`filter`](super::filter) does for blobs that move and boxes whose faces move.
//!
//! The shutter's time s runs from −1 to 1 and is cut into pieces [u − h, u + h]. There the centre of the
//! box less that of a blob is d + r·δ − a'·δ² with |δ| ≤ h, d their distance at u, r their relative
//! velocity and a' half the blob's acceleration. So A(x − p) stays within
//! E = |A|(half + h|ḣalf|) + h|A·r| + h²|A·a'| of A·d, and bounds follow as for boxes at rest; those over
//! the shutter are the widest of its pieces.

use super::filter::{BlobLanes, FieldBounds, Sums, qmin};
use super::layout::LANES;
use super::list::{BlobList, copy_lanes, lanes_at};
use super::place::Place;
use crate::field::{BlobField, Span};
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, Shapes, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// More pieces cost more than they find.
const MOST_PIECES: usize = 16;

/// A piece is short enough when blobs move less than this against the cell, in supports.
const PIECE_SUPPORTS: f32 = 0.1;

/// Cells above this side, in supports, take the shutter as one piece.
const ONE_PIECE_SIDE: f32 = 6.0;

/// Cells of balls that move more than this against each other, in supports, are crossed by too many of
/// them to pay; and those of ellipsoids, whose leaves are large as it is.
const COHERENT_BALLS: f64 = 0.3;
const COHERENT_ELLIPSOIDS: f64 = 0.1;

/// How much blobs move against their neighbours.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unrest {
    /// How far they depart from the way of the group that they are in while the shutter is open, over
    /// their support, in the root mean square: at their own velocities, and by acceleration alone.
    straight: f64,
    bent: f64,
    /// Up to which departure cells are worth building.
    limit: f64,
}

impl Unrest {
    /// How far they depart in each of `slabs` slabs of the time, over how far they may.
    pub(super) fn within(self, slabs: u32) -> f64 {
        let slabs = f64::from(slabs);
        (self.straight / slabs + self.bent / (slabs * slabs)) / self.limit
    }

    /// That of a field; `None` where shapes turn, which cells do not know.
    pub(super) fn of(field: &BlobField) -> Option<Self> {
        let limit = match field.shapes {
            Shapes::Balls(_) => COHERENT_BALLS,
            Shapes::Ellipsoids(_) => COHERENT_ELLIPSOIDS,
        };
        let Some(motion) = &field.motion else {
            return Some(Self {
                straight: 0.0,
                bent: 0.0,
                limit,
            });
        };
        if motion.turns() {
            return None;
        }
        let groups: Vec<&[u32]> = field.support_tree().groups().collect();
        // Groups in a fixed order, so that the sums do not depend on the number of threads.
        let parts: Vec<[f64; 2]> = groups
            .par_iter()
            .map(|blobs| {
                let ways = || {
                    blobs.iter().map(|&blob| {
                        let blob = blob as usize;
                        let [_, velocity, half] =
                            motion.by_phase(motion.whole(), blob, DVec3::ZERO);
                        (velocity, half, 2.0 / field.shapes.mean_radius(blob))
                    })
                };
                let mean =
                    ways().map(|(velocity, ..)| velocity).sum::<DVec3>() / blobs.len() as f64;
                ways().fold(
                    [0.0; 2],
                    |[straight, bent], (velocity, half, per_radius)| {
                        [
                            straight + ((velocity - mean) * per_radius).length_squared(),
                            bent + (half * per_radius).length_squared(),
                        ]
                    },
                )
            })
            .collect();
        let root_mean = |kind: usize| {
            let sum: f64 = parts.iter().map(|part| part[kind]).sum();
            (sum / field.len() as f64).sqrt()
        };
        Some(Self {
            straight: root_mean(0),
            bent: root_mean(1),
            limit,
        })
    }
}

/// How far blobs move in `span`, in the root mean square; 0 where nothing moves.
pub(super) fn way_spacings(field: &BlobField, span: Span) -> f32 {
    let Some(motion) = &field.motion else {
        return 0.0;
    };
    let squares: f64 = (0..field.len())
        .map(|i| motion.by_phase(span, i, DVec3::ZERO)[1].length_squared())
        .sum();
    2.0 * (squares / field.len() as f64).sqrt() as f32 / field.spacing
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

/// The smallest support of the blobs of `list`, each widened by how it moves against `place`: what leaves
/// are measured by. `support_of` takes a shape.
pub(super) fn leaf_scale<S: Simd, P: Primitive>(
    simd: S,
    list: &BlobList,
    place: &Place,
    support_of: impl Fn(&[f32]) -> f32,
) -> f32 {
    let drift = place.drift().to_array();
    let common = list.stored.shape.map(|shape| support_of(&shape));
    simd.vectorize(
        #[inline(always)]
        || {
            let drift: [f32x16<S>; 3] = splat3(simd, drift);
            let none = f32x16::splat(simd, f32::INFINITY);
            let mut least = none;
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
            }
            least.reduce_min()
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

/// [`super::filter::is_settled`] for blobs that move: what one piece of the shutter leaves open, the
/// others do not settle.
#[inline(never)]
pub(super) fn is_settled<S: Simd, K: KernelShape, P: Primitive>(
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

/// [`super::filter::filter`] for blobs that move; blobs that reach the box at any time are kept.
#[inline(never)]
pub(super) fn filter<S: Simd, K: KernelShape, P: Primitive>(
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
