//! Turns the binary tree of cells into eight-wide nodes.

use super::build::BinaryNode;
use super::layout::{LEAF, Node};
use crate::math::aabb::Aabb;

/// Eight-wide nodes, root first, from a binary tree; boxes are stored grown by `pad`.
pub(super) fn collapse(root: &BinaryNode, pad: f32) -> Vec<Node> {
    let mut nodes = vec![Node::EMPTY];
    match root {
        BinaryNode::Split { .. } => fill(root, 0, &mut nodes, pad),
        BinaryNode::Leaf { .. } => place(root, 0, 0, &mut nodes, pad),
    }
    nodes
}

/// Makes node `index` of a split: opens the largest child until eight are there.
fn fill(split: &BinaryNode, index: usize, nodes: &mut Vec<Node>, pad: f32) {
    let mut children: Vec<&BinaryNode> = vec![split];
    while children.len() < 8 {
        let widest = children
            .iter()
            .enumerate()
            .filter(|(_, child)| matches!(child, BinaryNode::Split { .. }))
            .max_by(|(_, a), (_, b)| a.bounds().half_area().total_cmp(&b.bounds().half_area()))
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
        place(child, index, slot, nodes, pad);
    }
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

fn place(child: &BinaryNode, parent: usize, slot: usize, nodes: &mut Vec<Node>, pad: f32) {
    let reference = match child {
        BinaryNode::Leaf { block, .. } => LEAF | block,
        BinaryNode::Split { .. } => {
            let index = nodes.len();
            nodes.push(Node::EMPTY);
            fill(child, index, nodes, pad);
            index as u32
        }
    };
    let Aabb { min, max } = child.bounds().padded(pad);
    let node = &mut nodes[parent];
    for axis in 0..3 {
        node.bounds[axis][slot] = min[axis];
        node.bounds[3 + axis][slot] = max[axis];
    }
    node.children[slot] = reference;
}
