//! Turns the binary tree of cells into eight-wide nodes.

use super::build::BinaryNode;
use super::layout::{LEAF, Node};
use crate::math::aabb::Aabb;

/// Eight-wide nodes, root first, from a binary tree; boxes are stored grown by `pad`.
pub(super) fn collapse(root: &BinaryNode, pad: f32, moves: bool) -> Vec<Node> {
    let mut nodes = Vec::new();
    push(&mut nodes, moves);
    match root {
        BinaryNode::Split { .. } => fill(root, 0, &mut nodes, pad, moves),
        BinaryNode::Leaf { .. } => place(root, 0, 0, &mut nodes, pad, moves),
    }
    nodes
}

/// Appends a node without children.
fn push(nodes: &mut Vec<Node>, moves: bool) {
    nodes.push(Node::EMPTY);
    if moves {
        nodes.push(Node::EMPTY);
    }
}

/// Makes node `index` of a split: opens the largest child until eight are there.
fn fill(split: &BinaryNode, index: usize, nodes: &mut Vec<Node>, pad: f32, moves: bool) {
    let mut children: Vec<&BinaryNode> = vec![split];
    while children.len() < 8 {
        let widest = children
            .iter()
            .enumerate()
            .filter(|(_, child)| matches!(child, BinaryNode::Split { .. }))
            .max_by(|(_, a), (_, b)| half_area(a).total_cmp(&half_area(b)))
            .map(|(slot, _)| slot);
        let Some(slot) = widest else { break };
        if let BinaryNode::Split { axis, halves, .. } = children[slot] {
            let [low, high] = &**halves;
            part_slot(&mut nodes[index].before, slot, children.len(), *axis);
            children[slot] = low;
            children.push(high);
        }
    }
    for (slot, child) in children.into_iter().enumerate() {
        place(child, index, slot, nodes, pad, moves);
    }
}

fn half_area(node: &BinaryNode) -> f32 {
    node.bounds().middle().half_area()
}

/// Notes in `before` that the child at `slot` was parted across `axis`: its lower half stays there,
/// its upper half is the new child `upper`.
fn part_slot(before: &mut [[u8; 8]; 4], slot: usize, upper: usize, axis: usize) {
    for (signs, before) in before.iter_mut().enumerate() {
        for other in &mut before[..upper] {
            *other |= (*other >> slot & 1) << upper;
        }
        before[upper] = before[slot];
        if axis < 2 && signs >> axis & 1 == 1 {
            before[slot] |= 1 << upper;
        } else {
            before[upper] |= 1 << slot;
        }
    }
}

fn place(
    child: &BinaryNode,
    parent: usize,
    slot: usize,
    nodes: &mut Vec<Node>,
    pad: f32,
    moves: bool,
) {
    let reference = match child {
        BinaryNode::Leaf { block, .. } => LEAF | block,
        BinaryNode::Split { .. } => {
            let index = nodes.len();
            push(nodes, moves);
            fill(child, index, nodes, pad, moves);
            index as u32
        }
    };
    let [open, close] = child.bounds().padded(pad).ends;
    nodes[parent].children[slot] = reference;
    set_box(&mut nodes[parent].bounds, slot, open);
    if moves {
        set_box(&mut nodes[parent + 1].bounds, slot, close);
    }
}

fn set_box(bounds: &mut [[f32; 8]; 6], slot: usize, Aabb { min, max }: Aabb) {
    for axis in 0..3 {
        bounds[axis][slot] = min[axis];
        bounds[3 + axis][slot] = max[axis];
    }
}
