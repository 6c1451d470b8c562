//! Visits the leaves that a ray pierces, nearest first.

use super::layout::{DEEP, LEAF, Node};
use super::{Cells, Part};
use crate::math::simd::{splat3, xyz};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Deep enough for any tree of `MAX_DEPTH` levels, each of which leaves at most
/// seven siblings behind; a power of two, so that an index is checked by a mask.
pub const STACK: usize = 1024;

/// Smaller components of directions count as this, so that no slab distance is NaN.
pub const TINY_COMPONENT: f32 = 1e-18;

/// A ray prepared for slab tests, in local f32 coordinates with a unit direction.
#[derive(Debug, Clone, Copy)]
pub struct SlabRay {
    /// Start.
    pub origin: [f32; 3],
    /// 1/direction, with zero components replaced by tiny ones so that no NaN arises.
    pub inverse: [f32; 3],
    /// Largest parameter of interest.
    pub t_max: f32,
}

impl SlabRay {
    /// A ray from a unit direction.
    pub fn new(origin: [f32; 3], direction: [f32; 3], t_max: f32) -> Self {
        let inverse = direction.map(|d| {
            let d = if d.abs() < TINY_COMPONENT {
                TINY_COMPONENT.copysign(d)
            } else {
                d
            };
            1.0 / d
        });
        Self {
            origin,
            inverse,
            t_max,
        }
    }
}

/// What the signs of a direction decide.
#[derive(Debug, Clone, Copy)]
pub struct Octant {
    /// Which of a node's six bounds the ray meets first on each axis.
    pub near_row: [usize; 3],
    /// Which it meets last.
    pub far_row: [usize; 3],
    /// Which row of [`Node::before`] holds.
    row: usize,
    /// Whether it counts from the far end.
    reversed: bool,
}

impl Octant {
    /// That of directions whose components are negative or not.
    #[inline(always)]
    pub fn new(negative: [bool; 3]) -> Self {
        let signs = negative.map(usize::from);
        Self {
            near_row: [0, 1, 2].map(|axis| axis + 3 * signs[axis]),
            far_row: [0, 1, 2].map(|axis| axis + 3 * (1 - signs[axis])),
            row: (signs[0] ^ signs[2]) | (signs[1] ^ signs[2]) << 1,
            reversed: negative[2],
        }
    }

    /// Whether child `slot` comes before child `other`.
    #[inline(always)]
    fn comes_first(&self, node: &Node, slot: usize, other: usize) -> bool {
        (node.before[self.row][other] >> slot & 1 == 1) != self.reversed
    }

    /// Where child `slot` of the `pierced` ones belongs on a stack whose top is the nearest.
    #[inline(always)]
    pub fn height(&self, node: &Node, pierced: u32, slot: usize) -> usize {
        let before = u32::from(node.before[self.row][slot]);
        let rank = (pierced & before).count_ones();
        (if self.reversed {
            rank
        } else {
            pierced.count_ones() - 1 - rank
        }) as usize
    }
}

/// The tree that a traversal is in: that of the coarse cells, one of their parts, or a part of a deep
/// cell in that one. Each is done before the next of its kind begins, so a stack needs no more than
/// the level of an entry.
#[derive(Debug, Clone, Copy)]
pub struct Level<'a> {
    cells: &'a Cells,
    parts: [Option<&'a Part>; 2],
    level: u32,
    /// Its nodes.
    pub nodes: &'a [Node],
}

impl<'a> Level<'a> {
    /// That of the coarse cells.
    #[inline(always)]
    pub fn top(cells: &'a Cells) -> Self {
        Self {
            cells,
            parts: [None; 2],
            level: 0,
            nodes: &cells.nodes,
        }
    }

    /// The number of this level, for [`Level::back_to`].
    #[inline(always)]
    pub fn number(&self) -> u32 {
        self.level
    }

    /// The part that this level lies in; `None` at the top.
    #[inline(always)]
    pub fn part(&self) -> Option<&'a Part> {
        match self.level {
            0 => None,
            1 => self.parts[0],
            _ => self.parts[1],
        }
    }

    /// Goes down into a part of this level.
    #[inline(always)]
    pub fn enter(&mut self, part: &'a Part) {
        self.parts[self.level as usize & 1] = Some(part);
        self.level += 1;
        self.nodes = &part.nodes;
    }

    /// Returns to a level above, or stays.
    #[inline(always)]
    pub fn back_to(&mut self, level: u32) {
        if self.level != level {
            self.level = level;
            self.nodes = self.part().map_or(&self.cells.nodes, |part| &part.nodes);
        }
    }
}

/// A subtree or leaf to visit and the ray's range in its box.
#[derive(Debug, Clone, Copy)]
struct Visit {
    reference: u32,
    /// Of the tree that it lies in.
    level: u32,
    near: f32,
    far: f32,
}

/// Work buffers of a traversal.
#[derive(Debug)]
pub struct Stack {
    visits: Box<[Visit; STACK]>,
}

impl Default for Stack {
    fn default() -> Self {
        const NOWHERE: Visit = Visit {
            reference: 0,
            level: 0,
            near: 0.0,
            far: 0.0,
        };
        Self {
            visits: Box::new([NOWHERE; STACK]),
        }
    }
}

/// Calls `leaf(part, block index, t near, t far)` for the pierced leaves from near to far until it
/// returns true; `open` gives the inside of a coarse cell, or of a deep one of a part. With `MOVES`
/// faces are where they are once the part `elapsed` of the shutter's time is over. Returns the number
/// of nodes visited.
#[inline(always)]
pub fn visit_leaves<'a, S: Simd, const MOVES: bool>(
    simd: S,
    cells: &'a Cells,
    (ray, elapsed): (&SlabRay, f32),
    stack: &mut Stack,
    mut open: impl FnMut(Option<&'a Part>, u32) -> Option<&'a Part>,
    mut leaf: impl FnMut(&'a Part, u32, f32, f32) -> bool,
) -> u64 {
    if cells.nodes.is_empty() {
        return 0;
    }
    let elapsed = f32x8::splat(simd, elapsed);
    let inverse: [f32x8<S>; 3] = splat3(simd, ray.inverse);
    // (face − origin)/direction; boxes are padded by more than this rounds.
    let shift: [f32x8<S>; 3] = splat3(simd, [0, 1, 2].map(|k| -ray.origin[k] * ray.inverse[k]));
    let octant = Octant::new([
        ray.inverse[0] < 0.0,
        ray.inverse[1] < 0.0,
        ray.inverse[2] < 0.0,
    ]);
    let (start, end) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, ray.t_max));
    let visits = &mut stack.visits;
    let mut depth = 0;
    let mut nodes_visited = 0;
    let mut current = Visit {
        reference: 0,
        level: 0,
        near: 0.0,
        far: ray.t_max,
    };
    let mut level = Level::top(cells);
    loop {
        if current.reference & LEAF != 0 {
            let part = level.part();
            let index = current.reference & !(LEAF | DEEP);
            match part {
                Some(part) if current.reference & DEEP == 0 => {
                    if leaf(part, index, current.near, current.far) {
                        return nodes_visited;
                    }
                }
                _ => {
                    if let Some(inside) = open(part, index) {
                        level.enter(inside);
                        (current.reference, current.level) = (0, level.number());
                        continue;
                    }
                }
            }
        } else {
            nodes_visited += 1;
            let index = current.reference as usize;
            let ends = &level.nodes[index..index + 1 + usize::from(MOVES)];
            let node = &ends[0];
            let near = xyz(
                #[inline(always)]
                |axis| {
                    let row = octant.near_row[axis];
                    let faces = faces_at::<_, MOVES>(simd, ends, row, elapsed);
                    faces.mul_add(inverse[axis], shift[axis])
                },
            );
            let far = xyz(
                #[inline(always)]
                |axis| {
                    let row = octant.far_row[axis];
                    let faces = faces_at::<_, MOVES>(simd, ends, row, elapsed);
                    faces.mul_add(inverse[axis], shift[axis])
                },
            );
            let near = near[0].max(near[1]).max(near[2].max(start));
            let far = far[0].min(far[1]).min(far[2].min(end));
            let pierced = near.simd_le(far).to_bitmask() as u32;
            let near: [f32; 8] = near.to_array();
            let far: [f32; 8] = far.to_array();
            if pierced != 0 {
                // The nearest goes on without the stack: what was just written could not be read back
                // at once.
                let top = pierced.count_ones() as usize - 1;
                let mut nearest = pierced.trailing_zeros() as usize & 7;
                if top < 2 {
                    // No branch that depends on the order, nor on whether there are one or two.
                    let last = (7 - (pierced as u8).leading_zeros() as usize) & 7;
                    let swap = octant.comes_first(node, last, nearest);
                    let other = if swap { nearest } else { last };
                    nearest = if swap { last } else { nearest };
                    visits[depth % STACK] = Visit {
                        reference: node.children[other],
                        near: near[other],
                        far: far[other],
                        level: current.level,
                    };
                } else {
                    let mut rest = pierced;
                    loop {
                        let slot = rest.trailing_zeros() as usize & 7;
                        let height = octant.height(node, pierced, slot);
                        visits[(depth + height) % STACK] = Visit {
                            reference: node.children[slot],
                            near: near[slot],
                            far: far[slot],
                            level: current.level,
                        };
                        nearest = if height == top { slot } else { nearest };
                        rest &= rest - 1;
                        if rest == 0 {
                            break;
                        }
                    }
                }
                current.reference = node.children[nearest];
                (current.near, current.far) = (near[nearest], far[nearest]);
                depth += top;
                continue;
            }
        }
        if depth == 0 {
            return nodes_visited;
        }
        depth -= 1;
        current = visits[depth % STACK];
        level.back_to(current.level);
    }
}

/// One of the six faces of a node's children at a time.
#[inline(always)]
fn faces_at<S: Simd, const MOVES: bool>(
    simd: S,
    ends: &[Node],
    row: usize,
    elapsed: f32x8<S>,
) -> f32x8<S> {
    let open = f32x8::from_slice(simd, &ends[0].bounds[row]);
    if MOVES {
        let close = f32x8::from_slice(simd, &ends[1].bounds[row]);
        (close - open).mul_add(elapsed, open)
    } else {
        open
    }
}
