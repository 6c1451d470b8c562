//! Visits the leaves that a ray pierces, nearest first.

use super::layout::{LEAF, Node};
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

/// Instead of a coarse cell's index: in the tree of coarse cells.
pub const TOP: u32 = u32::MAX;

/// A subtree or leaf to visit and the ray's range in its box.
#[derive(Debug, Clone, Copy)]
struct Visit {
    reference: u32,
    /// The coarse cell that it lies in, or [`TOP`].
    coarse: u32,
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
            coarse: TOP,
            near: 0.0,
            far: 0.0,
        };
        Self {
            visits: Box::new([NOWHERE; STACK]),
        }
    }
}

/// Calls `leaf(part, block index, t near, t far)` for the pierced leaves from near to far until it
/// returns true; `open` gives the inside of a coarse cell. Returns the number of nodes visited.
#[inline(always)]
pub fn visit_leaves<'a, S: Simd>(
    simd: S,
    cells: &'a Cells,
    ray: &SlabRay,
    stack: &mut Stack,
    mut open: impl FnMut(u32) -> Option<&'a Part>,
    mut leaf: impl FnMut(&'a Part, u32, f32, f32) -> bool,
) -> u64 {
    if cells.nodes.is_empty() {
        return 0;
    }
    let origin: [f32x8<S>; 3] = splat3(simd, ray.origin);
    let inverse: [f32x8<S>; 3] = splat3(simd, ray.inverse);
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
        coarse: TOP,
        near: 0.0,
        far: ray.t_max,
    };
    let mut nodes: &[Node] = &cells.nodes;
    let mut inside: Option<&'a Part> = None;
    loop {
        if current.reference & LEAF != 0 {
            let index = current.reference & !LEAF;
            match inside {
                Some(part) => {
                    if leaf(part, index, current.near, current.far) {
                        return nodes_visited;
                    }
                }
                None => {
                    if let Some(part) = open(index) {
                        (inside, nodes) = (Some(part), &part.nodes);
                        (current.reference, current.coarse) = (0, index);
                        continue;
                    }
                }
            }
        } else {
            nodes_visited += 1;
            let node = &nodes[current.reference as usize];
            let near = xyz(
                #[inline(always)]
                |axis| {
                    let faces = f32x8::from_slice(simd, &node.bounds[octant.near_row[axis]]);
                    (faces - origin[axis]) * inverse[axis]
                },
            );
            let far = xyz(
                #[inline(always)]
                |axis| {
                    let faces = f32x8::from_slice(simd, &node.bounds[octant.far_row[axis]]);
                    (faces - origin[axis]) * inverse[axis]
                },
            );
            let near = near[0].max(near[1]).max(near[2].max(start));
            let far = far[0].min(far[1]).min(far[2].min(end));
            let pierced = near.simd_le(far).to_bitmask() as u32;
            let near: [f32; 8] = near.to_array();
            let far: [f32; 8] = far.to_array();
            if pierced != 0 && pierced & (pierced - 1) == 0 {
                let slot = pierced.trailing_zeros() as usize & 7;
                current = Visit {
                    reference: node.children[slot],
                    near: near[slot],
                    far: far[slot],
                    ..current
                };
                continue;
            }
            let mut rest = pierced;
            while rest != 0 {
                let slot = rest.trailing_zeros() as usize & 7;
                rest &= rest - 1;
                let at = depth + octant.height(node, pierced, slot);
                visits[at % STACK] = Visit {
                    reference: node.children[slot],
                    near: near[slot],
                    far: far[slot],
                    ..current
                };
            }
            depth += pierced.count_ones() as usize;
        }
        if depth == 0 {
            return nodes_visited;
        }
        depth -= 1;
        let next = visits[depth % STACK];
        if next.coarse != current.coarse {
            // Only back to the top: a coarse cell is done before the next begins.
            (inside, nodes) = (None, &cells.nodes);
        }
        current = next;
    }
}
