//! Visits the leaves that a packet pierces, nearest first.

use super::Lanes;
use crate::accel::cells::Cells;
use crate::accel::cells::layout::{LANES, LEAF, Node};
use crate::accel::cells::traverse::STACK;
use crate::math::simd::xyz;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Subtrees and leaves to visit: which lanes pierce them, and their ranges in them.
#[derive(Debug)]
pub(super) struct PacketStack {
    references: Box<[(u32, u32); STACK]>,
    ranges: Box<[[[f32; LANES]; 2]; STACK]>,
}

impl Default for PacketStack {
    fn default() -> Self {
        Self {
            references: Box::new([(0, 0); STACK]),
            ranges: vec![[[0.0; LANES]; 2]; STACK]
                .into_boxed_slice()
                .try_into()
                .expect("made with this length"),
        }
    }
}

/// Calls `leaf(lanes, block, mask, t near, t far)` for the leaves that lanes of `alive` pierce, from
/// near to far; it returns the lanes that are done. Returns the nodes visited, once per lane.
#[inline(always)]
pub(super) fn visit_leaves<S: Simd>(
    simd: S,
    cells: &Cells,
    lanes: &mut Lanes<S>,
    mut alive: u32,
    stack: &mut PacketStack,
    mut leaf: impl FnMut(&mut Lanes<S>, u32, u32, f32x16<S>, f32x16<S>) -> u32,
) -> u64 {
    let PacketStack { references, ranges } = stack;
    let near_row = [0, 1, 2].map(|axis| if lanes.negative[axis] { axis + 3 } else { axis });
    let far_row = [0, 1, 2].map(|axis| if lanes.negative[axis] { axis } else { axis + 3 });
    let signs = lanes.negative.map(usize::from);
    let reversed = lanes.negative[2];
    let row = (signs[0] ^ signs[2]) | (signs[1] ^ signs[2]) << 1;
    let (start, end) = (f32x16::splat(simd, 0.0), lanes.length);
    let (origin, inverse) = (lanes.origin, lanes.inverse);
    references[0] = (0, alive);
    let mut depth = 1;
    let mut nodes_visited = 0;
    while depth > 0 && alive != 0 {
        depth -= 1;
        let (reference, mask) = references[depth % STACK];
        let mask = mask & alive;
        if mask == 0 {
            continue;
        }
        if reference & LEAF != 0 {
            let [near, far] = &ranges[depth % STACK];
            let near = f32x16::from_slice(simd, near);
            let far = f32x16::from_slice(simd, far);
            alive &= !leaf(lanes, reference & !LEAF, mask, near, far);
            continue;
        }
        nodes_visited += u64::from(mask.count_ones());
        let node: &Node = &cells.nodes[reference as usize];
        let before = &node.before[row];
        let mut pierced = 0;
        let mut masks = [0; 8];
        let mut spans = [[start; 2]; 8];
        for slot in 0..8 {
            let near = xyz(
                #[inline(always)]
                |axis| {
                    let face = f32x16::splat(simd, node.bounds[near_row[axis]][slot]);
                    (face - origin[axis]) * inverse[axis]
                },
            );
            let far = xyz(
                #[inline(always)]
                |axis| {
                    let face = f32x16::splat(simd, node.bounds[far_row[axis]][slot]);
                    (face - origin[axis]) * inverse[axis]
                },
            );
            let near = near[0].max(near[1]).max(near[2].max(start));
            let far = far[0].min(far[1]).min(far[2].min(end));
            let lanes_in = near.simd_le(far).to_bitmask() as u32 & mask;
            masks[slot] = lanes_in;
            spans[slot] = [near, far];
            pierced |= u32::from(lanes_in != 0) << slot;
        }
        let count = pierced.count_ones() as usize;
        let mut rest = pierced;
        while rest != 0 {
            let slot = rest.trailing_zeros() as usize & 7;
            rest &= rest - 1;
            let rank = (pierced & u32::from(before[slot])).count_ones() as usize;
            let at = (depth + if reversed { rank } else { count - 1 - rank }) % STACK;
            references[at] = (node.children[slot], masks[slot]);
            let [near, far] = &mut ranges[at];
            spans[slot][0].store_slice(near);
            spans[slot][1].store_slice(far);
        }
        depth += count;
    }
    nodes_visited
}
