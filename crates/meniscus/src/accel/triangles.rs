//! A hierarchy of boxes over the triangles of a mesh; crate `obvhs` builds it.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use std::time::Duration;

/// A box and what is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Lower corner.
    pub min: [f32; 3],
    /// Upper corner.
    pub max: [f32; 3],
    /// Inner node: the first of its two children, which follow each other. Leaf: its first triangle.
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

/// The hierarchy: nodes with the root first, and which triangle stands at each place of the leaves.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleTree {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Triangles in the order of the leaves.
    pub order: Vec<u32>,
}

impl TriangleTree {
    /// The hierarchy over `triangles` with corners among `vertices`, whose coordinates f32 must be
    /// able to hold (it rounds boxes outwards).
    pub fn build(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|triangle| {
                let corners = triangle.map(|corner| vertices[corner as usize]);
                let [a, b, c] = corners;
                Aabb {
                    min: rounded(a.min(b).min(c), f32::next_down),
                    max: rounded(a.max(b).max(c), f32::next_up),
                }
            })
            .collect();
        if boxes.is_empty() {
            return Self::default();
        }
        let mut build_time = Duration::ZERO;
        let bvh = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut build_time);
        Self {
            nodes: bvh
                .nodes
                .iter()
                .map(|node| Node {
                    min: node.aabb.min.to_array(),
                    max: node.aabb.max.to_array(),
                    first: node.first_index,
                    count: node.prim_count,
                })
                .collect(),
            order: bvh.primitive_indices,
        }
    }

    /// Memory that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.order[..])
    }
}

/// One step beyond the nearest f32: never within.
fn rounded(corner: DVec3, beyond: fn(f32) -> f32) -> Vec3A {
    Vec3A::from_array(corner.to_array().map(|x| beyond(x as f32)))
}
