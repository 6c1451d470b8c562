//! Visits the leaves that a packet pierces, nearest first.
//!
//! Inner nodes are tested for the whole packet at once, with lanes for the eight children: from the
//! extreme origins and inverse directions follow bounds of where any of its rays enters and leaves a
//! box. Only the boxes of leaves are tested ray by ray.

use super::Lanes;
use crate::accel::cells::layout::{DEEP, LEAF, Node};
use crate::accel::cells::traverse::{Level, Octant, STACK};
use crate::accel::cells::{Cells, Part};
use crate::math::number::Number;
use crate::math::simd::xyz;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f32x16, mask32x16};

/// A subtree or leaf to visit.
#[derive(Debug, Clone, Copy)]
struct Visit {
    reference: u32,
    /// Of the tree that it lies in.
    level: u32,
    /// Its parent and its place there.
    parent: u32,
    slot: u32,
}

/// Subtrees and leaves to visit.
#[derive(Debug)]
pub(super) struct PacketStack(Box<[Visit; STACK]>);

impl Default for PacketStack {
    fn default() -> Self {
        const ROOT: Visit = Visit {
            reference: 0,
            level: 0,
            parent: 0,
            slot: 0,
        };
        Self(Box::new([ROOT; STACK]))
    }
}

/// The smallest value in the lanes of `mask`.
#[inline(always)]
pub(super) fn least<S: Simd>(simd: S, mask: mask32x16<S>, values: f32x16<S>) -> f32 {
    let none = f32x16::splat(simd, f32::INFINITY);
    mask.select(values, none).reduce_min()
}

/// The largest value in the lanes of `mask`.
#[inline(always)]
pub(super) fn most<S: Simd>(simd: S, mask: mask32x16<S>, values: f32x16<S>) -> f32 {
    let none = f32x16::splat(simd, f32::NEG_INFINITY);
    mask.select(values, none).reduce_max()
}

/// What a packet's rays have in common: along each axis the extremes of their origins and inverse
/// directions, eight times each.
struct Beam<S: Simd> {
    /// The origins nearest to and farthest from the faces ahead.
    origin_ahead: [f32x8<S>; 3],
    origin_behind: [f32x8<S>; 3],
    inverse_low: [f32x8<S>; 3],
    inverse_high: [f32x8<S>; 3],
    length: f32x8<S>,
    /// How much of the shutter's time is over for the first and the last of the rays.
    elapsed: [f32x8<S>; 2],
}

impl<S: Simd> Beam<S> {
    #[inline(always)]
    fn new(simd: S, lanes: &Lanes<'_, S>, present: u32) -> Self {
        let mask = mask32x16::from_bitmask(simd, u64::from(present));
        let zero = f32x8::splat(simd, 0.0);
        let mut beam = Self {
            origin_ahead: [zero; 3],
            origin_behind: [zero; 3],
            inverse_low: [zero; 3],
            inverse_high: [zero; 3],
            length: f32x8::splat(simd, most(simd, mask, lanes.length)),
            elapsed: [
                f32x8::splat(simd, elapsed(lanes.phases[0])),
                f32x8::splat(simd, elapsed(lanes.phases[1])),
            ],
        };
        for axis in 0..3 {
            let ends = (
                least(simd, mask, lanes.origin[axis]),
                most(simd, mask, lanes.origin[axis]),
            );
            let (behind, ahead) = if lanes.negative[axis] {
                (ends.1, ends.0)
            } else {
                ends
            };
            beam.origin_ahead[axis] = f32x8::splat(simd, ahead);
            beam.origin_behind[axis] = f32x8::splat(simd, behind);
            beam.inverse_low[axis] = f32x8::splat(simd, least(simd, mask, lanes.inverse[axis]));
            beam.inverse_high[axis] = f32x8::splat(simd, most(simd, mask, lanes.inverse[axis]));
        }
        beam
    }

    /// The children that some ray of the beam may pierce; `ends` is a node, followed by that of its boxes
    /// when the shutter closes where blobs move.
    #[inline(always)]
    fn pierced<const MOVES: bool>(&self, simd: S, ends: &[Node], octant: &Octant) -> u32 {
        let [open, close] = [&ends[0], &ends[ends.len() - 1]];
        let near = xyz(
            #[inline(always)]
            |axis| {
                let row = octant.near_row[axis];
                let mut faces = f32x8::from_slice(simd, &open.bounds[row]);
                if MOVES {
                    // Those that come first, at whichever time.
                    let [a, b] = self.faces_at_ends(simd, faces, &close.bounds[row]);
                    faces = if octant.near_row[axis] > 2 {
                        a.max(b)
                    } else {
                        a.min(b)
                    };
                }
                let way = faces - self.origin_ahead[axis];
                (way * self.inverse_low[axis]).min(way * self.inverse_high[axis])
            },
        );
        let far = xyz(
            #[inline(always)]
            |axis| {
                let row = octant.far_row[axis];
                let mut faces = f32x8::from_slice(simd, &open.bounds[row]);
                if MOVES {
                    let [a, b] = self.faces_at_ends(simd, faces, &close.bounds[row]);
                    faces = if octant.far_row[axis] > 2 {
                        a.max(b)
                    } else {
                        a.min(b)
                    };
                }
                let way = faces - self.origin_behind[axis];
                (way * self.inverse_low[axis]).max(way * self.inverse_high[axis])
            },
        );
        let zero = f32x8::splat(simd, 0.0);
        let near = near[0].max(near[1]).max(near[2].max(zero));
        let far = far[0].min(far[1]).min(far[2].min(self.length));
        near.simd_le(far).to_bitmask() as u32
    }

    /// Faces for the first and for the last of the rays.
    #[inline(always)]
    fn faces_at_ends(&self, simd: S, open: f32x8<S>, close: &[f32; 8]) -> [f32x8<S>; 2] {
        let way = f32x8::from_slice(simd, close) - open;
        [
            Number::mul_add(way, self.elapsed[0], open),
            Number::mul_add(way, self.elapsed[1], open),
        ]
    }
}

/// How much of the shutter's time is over at a time from −1 to 1.
fn elapsed(phase: f32) -> f32 {
    0.5 + 0.5 * phase
}

/// Calls `leaf(lanes, part, block, mask, t near, t far)` for the leaves that lanes of `alive` pierce,
/// from near to far; it returns the lanes that are done. `open` gives the inside of a coarse cell,
/// or of a deep one of a part. Returns the nodes visited, once per lane that was still under way.
#[inline(always)]
pub(super) fn visit_leaves<'a, S: Simd, const MOVES: bool>(
    simd: S,
    cells: &'a Cells,
    lanes: &mut Lanes<'_, S>,
    mut alive: u32,
    stack: &mut PacketStack,
    mut open: impl FnMut(Option<&'a Part>, u32) -> Option<&'a Part>,
    mut leaf: impl FnMut(&mut Lanes<'_, S>, &'a Part, u32, u32, f32x16<S>, f32x16<S>) -> u32,
) -> u64 {
    let visits = &mut stack.0;
    let octant = Octant::new(lanes.negative);
    let per_node = 1 + usize::from(MOVES);
    let beam = Beam::new(simd, lanes, alive);
    let mut nodes_visited = 0;
    let mut level = Level::top(cells);
    let mut depth = 0;
    let mut visit = Visit {
        reference: 0,
        level: 0,
        parent: 0,
        slot: 0,
    };
    loop {
        let mut is_leaf = visit.reference & LEAF != 0;
        if is_leaf {
            let index = visit.parent as usize;
            let ends = &level.nodes[index..index + per_node];
            let (near, far) = range_in::<_, MOVES>(simd, lanes, ends, &octant, visit.slot as usize);
            let mask = near.simd_le(far).to_bitmask() as u32 & alive;
            let part = level.part();
            let index = visit.reference & !(LEAF | DEEP);
            match part {
                _ if mask == 0 => {}
                Some(part) if visit.reference & DEEP == 0 => {
                    alive &= !leaf(lanes, part, index, mask, near, far);
                    if alive == 0 {
                        return nodes_visited;
                    }
                }
                _ => {
                    if let Some(inside) = open(part, index) {
                        level.enter(inside);
                        (visit.reference, visit.level) = (0, level.number());
                        is_leaf = false;
                    }
                }
            }
        }
        if !is_leaf {
            nodes_visited += u64::from(alive.count_ones());
            let index = visit.reference as usize;
            let ends = &level.nodes[index..index + per_node];
            let node = &ends[0];
            let pierced = beam.pierced::<MOVES>(simd, ends, &octant);
            let mut rest = pierced;
            while rest != 0 {
                let slot = rest.trailing_zeros() as usize & 7;
                rest &= rest - 1;
                visits[(depth + octant.height(node, pierced, slot)) % STACK] = Visit {
                    reference: node.children[slot],
                    level: visit.level,
                    parent: visit.reference,
                    slot: slot as u32,
                };
            }
            depth += pierced.count_ones() as usize;
        }
        if depth == 0 {
            return nodes_visited;
        }
        depth -= 1;
        visit = visits[depth % STACK];
        level.back_to(visit.level);
    }
}

/// Face `row` of child `slot` of a node, for each lane when so much of the shutter's time is over.
#[inline(always)]
fn face_at<S: Simd, const MOVES: bool>(
    simd: S,
    ends: &[Node],
    row: usize,
    slot: usize,
    elapsed: f32x16<S>,
) -> f32x16<S> {
    let open = f32x16::splat(simd, ends[0].bounds[row][slot]);
    if !MOVES {
        return open;
    }
    let way = f32x16::splat(simd, ends[1].bounds[row][slot]) - open;
    Number::mul_add(elapsed, way, open)
}

/// Where each lane enters and leaves the box of child `slot`.
#[inline(always)]
fn range_in<S: Simd, const MOVES: bool>(
    simd: S,
    lanes: &Lanes<'_, S>,
    ends: &[Node],
    octant: &Octant,
    slot: usize,
) -> (f32x16<S>, f32x16<S>) {
    let slot = slot % 8;
    let elapsed = Number::mul_add(
        lanes.phase,
        f32x16::splat(simd, 0.5),
        f32x16::splat(simd, 0.5),
    );
    let near = xyz(
        #[inline(always)]
        |axis| {
            let face = face_at::<_, MOVES>(simd, ends, octant.near_row[axis], slot, elapsed);
            Number::mul_add(face, lanes.inverse[axis], lanes.shift[axis])
        },
    );
    let far = xyz(
        #[inline(always)]
        |axis| {
            let face = face_at::<_, MOVES>(simd, ends, octant.far_row[axis], slot, elapsed);
            Number::mul_add(face, lanes.inverse[axis], lanes.shift[axis])
        },
    );
    (
        near[0]
            .max(near[1])
            .max(near[2].max(f32x16::splat(simd, 0.0))),
        far[0].min(far[1]).min(far[2].min(lanes.length)),
    )
}
