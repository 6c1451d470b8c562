//! Visits the leaves that a ray pierces, nearest box first.

use crate::accel::cells::traverse::SlabRay;
use crate::accel::metaballs::{LEAF, MAX_DEPTH, MetaballTree};

/// Room for one sibling per level; a power of two, so that an index is checked by a mask.
const STACK: usize = 128;
const _: () = assert!(MAX_DEPTH < STACK);

/// A subtree to visit and the ray's range in its box.
#[derive(Debug, Clone, Copy, Default)]
struct Visit {
    reference: u32,
    near: f32,
    far: f32,
}

/// Work buffer of a traversal.
#[derive(Debug)]
pub(super) struct Stack {
    visits: Box<[Visit; STACK]>,
}

impl Default for Stack {
    fn default() -> Self {
        Self {
            visits: Box::new([Visit::default(); STACK]),
        }
    }
}

/// Calls `leaf(block index, t near, t far)` for the pierced leaves, nearer boxes first. What it returns
/// is how far along the ray leaves are still of interest; negative: none. Returns the number of nodes
/// visited.
#[inline(always)]
pub(super) fn visit_leaves(
    tree: &MetaballTree,
    ray: &SlabRay,
    stack: &mut Stack,
    mut leaf: impl FnMut(u32, f32, f32) -> f32,
) -> u64 {
    let Some(root) = tree.root else {
        return 0;
    };
    let rows = [0, 1, 2].map(|axis| {
        if ray.inverse[axis] < 0.0 {
            [axis + 3, axis]
        } else {
            [axis, axis + 3]
        }
    });
    let visits = &mut stack.visits;
    let (mut depth, mut nodes) = (0, 0);
    let mut limit = ray.t_max;
    let mut current = Visit {
        reference: root,
        near: 0.0,
        far: ray.t_max,
    };
    loop {
        if current.reference & LEAF != 0 {
            limit = leaf(
                current.reference & !LEAF,
                current.near,
                current.far.min(limit),
            );
        } else {
            nodes += 1;
            let node = &tree.nodes[current.reference as usize];
            let (mut near, mut far) = ([0.0_f32; 2], [limit; 2]);
            for axis in 0..3 {
                let [first, last] = rows[axis];
                let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
                for child in 0..2 {
                    near[child] = near[child].max((node.bounds[first][child] - origin) * inverse);
                    far[child] = far[child].min((node.bounds[last][child] - origin) * inverse);
                }
            }
            let visit = |child: usize| Visit {
                reference: node.children[child],
                near: near[child],
                far: far[child],
            };
            let pierced = [near[0] <= far[0], near[1] <= far[1]];
            if pierced[0] && pierced[1] {
                let second_first = near[1] < near[0];
                visits[depth % STACK] = visit(usize::from(!second_first));
                depth += 1;
                current = visit(usize::from(second_first));
                continue;
            }
            if pierced[0] || pierced[1] {
                current = visit(usize::from(pierced[1]));
                continue;
            }
        }
        loop {
            if depth == 0 {
                return nodes;
            }
            depth -= 1;
            current = visits[depth % STACK];
            if current.near <= limit {
                break;
            }
        }
    }
}
