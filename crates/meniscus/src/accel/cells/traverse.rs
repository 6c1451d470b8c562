//! Visits the leaves that a ray pierces, nearest first.

use super::Cells;
use super::layout::{LEAF, Node};
use crate::math::simd::{splat3, xyz};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// Deep enough for any tree of `MAX_DEPTH` levels, each of which leaves at most
/// seven siblings behind; a power of two, so that an index is checked by a mask.
pub const STACK: usize = 1024;

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
            let d = if d.abs() < 1e-18 {
                1e-18_f32.copysign(d)
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

/// A subtree or leaf to visit and the ray's range in its box.
#[derive(Debug, Clone, Copy)]
struct Visit {
    reference: u32,
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
        Self {
            visits: Box::new(
                [Visit {
                    reference: 0,
                    near: 0.0,
                    far: 0.0,
                }; STACK],
            ),
        }
    }
}

/// Calls `leaf(block index, t near, t far)` for the pierced leaves from near to far until it returns
/// true; returns the number of nodes visited.
#[inline(always)]
pub fn visit_leaves<S: Simd>(
    simd: S,
    cells: &Cells,
    ray: &SlabRay,
    stack: &mut Stack,
    mut leaf: impl FnMut(u32, f32, f32) -> bool,
) -> u64 {
    if cells.nodes.is_empty() {
        return 0;
    }
    let origin: [f32x8<S>; 3] = splat3(simd, ray.origin);
    let inverse: [f32x8<S>; 3] = splat3(simd, ray.inverse);
    // Which of the six bounds the ray meets first on each axis.
    let near_row = [0, 1, 2].map(|axis| {
        if ray.inverse[axis] < 0.0 {
            axis + 3
        } else {
            axis
        }
    });
    let far_row = [0, 1, 2].map(|axis| {
        if ray.inverse[axis] < 0.0 {
            axis
        } else {
            axis + 3
        }
    });
    // Which row of `before` holds, and whether it counts from the far end.
    let signs = [0, 1, 2].map(|axis| usize::from(ray.inverse[axis] < 0.0));
    let reversed = signs[2] == 1;
    let row = (signs[0] ^ signs[2]) | (signs[1] ^ signs[2]) << 1;
    let (start, end) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, ray.t_max));
    let visits = &mut stack.visits;
    let mut depth = 0;
    let mut nodes_visited = 0;
    let mut current = Visit {
        reference: 0,
        near: 0.0,
        far: ray.t_max,
    };
    loop {
        if current.reference & LEAF != 0 {
            if leaf(current.reference & !LEAF, current.near, current.far) {
                return nodes_visited;
            }
        } else {
            nodes_visited += 1;
            let node: &Node = &cells.nodes[current.reference as usize];
            let near = xyz(
                #[inline(always)]
                |axis| {
                    let faces = f32x8::from_slice(simd, &node.bounds[near_row[axis]]);
                    (faces - origin[axis]) * inverse[axis]
                },
            );
            let far = xyz(
                #[inline(always)]
                |axis| {
                    let faces = f32x8::from_slice(simd, &node.bounds[far_row[axis]]);
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
                };
                continue;
            }
            let count = pierced.count_ones() as usize;
            let before = &node.before[row];
            let mut rest = pierced;
            while rest != 0 {
                let slot = rest.trailing_zeros() as usize & 7;
                rest &= rest - 1;
                let rank = (pierced & u32::from(before[slot])).count_ones() as usize;
                // The nearest goes on top.
                let at = depth + if reversed { rank } else { count - 1 - rank };
                visits[at % STACK] = Visit {
                    reference: node.children[slot],
                    near: near[slot],
                    far: far[slot],
                };
            }
            depth += count;
        }
        if depth == 0 {
            return nodes_visited;
        }
        depth -= 1;
        current = visits[depth % STACK];
    }
}
