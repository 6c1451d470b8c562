//! Whether a mesh encloses something, and which side of its faces is outside.

use super::TriangleMesh;
use glam::DVec3;
use std::collections::HashMap;

/// How the faces of a closed mesh were turned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// As the file has them.
    Kept,
    /// All of them turned round: the file had the inside out.
    Reversed,
    /// Neighbours disagreed; each connected part was turned so that its outside is outside.
    Repaired,
}

/// A mesh whose equal positions are one vertex, and what it encloses.
#[derive(Debug, Clone, PartialEq)]
pub struct Topology {
    /// Vertices, each position once.
    pub vertices: Vec<DVec3>,
    /// Corners of the triangles, as indices into `vertices`; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Which triangles have their corners in another order than in the mesh (the last two swapped).
    pub swapped: Vec<bool>,
    /// Edges with a face on one side only, or with faces that disagree; 0 for a closed mesh.
    pub open_edges: usize,
    /// What was done to the faces of a closed mesh.
    pub orientation: Orientation,
}

impl Topology {
    /// Joins equal positions and turns the faces of closed meshes outside. Inner shells that face the
    /// other way stay as they are: the space within them is outside.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (vertices, triangles) = joined(mesh);
        let mut topology = Self {
            swapped: vec![false; triangles.len()],
            vertices,
            triangles,
            open_edges: 0,
            orientation: Orientation::Kept,
        };
        topology.open_edges = topology.unbalanced_edges();
        if topology.open_edges > 0 && topology.repair() {
            topology.orientation = Orientation::Repaired;
            topology.open_edges = 0;
        }
        let is_inside_out = topology.volume(0..topology.triangles.len()) < 0.0;
        if topology.is_closed() && topology.orientation == Orientation::Kept && is_inside_out {
            topology.orientation = Orientation::Reversed;
            for triangle in 0..topology.triangles.len() {
                topology.swap(triangle);
            }
        }
        topology
    }

    /// Whether the mesh has an inside.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0
    }

    fn swap(&mut self, triangle: usize) {
        self.triangles[triangle].swap(1, 2);
        self.swapped[triangle] = !self.swapped[triangle];
    }

    /// Edges that are not walked as often one way as the other.
    fn unbalanced_edges(&self) -> usize {
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        for (from, to) in self.triangles.iter().flat_map(|&t| edges(t)) {
            let way = if from < to { 1 } else { -1 };
            *balance.entry((from.min(to), from.max(to))).or_insert(0) += way;
        }
        balance.values().filter(|&&balance| balance != 0).count()
    }

    /// Turns the faces of a mesh with exactly two faces at every edge so that neighbours agree, and
    /// each connected part so that its volume is positive. Whether that was possible.
    fn repair(&mut self) -> bool {
        let mut at_edge: HashMap<(u32, u32), [Option<u32>; 2]> = HashMap::new();
        for (index, &triangle) in self.triangles.iter().enumerate() {
            for (from, to) in edges(triangle) {
                let both = at_edge.entry((from.min(to), from.max(to))).or_default();
                match both {
                    [first @ None, _] => *first = Some(index as u32),
                    [_, second @ None] => *second = Some(index as u32),
                    _ => return false,
                }
            }
        }
        if at_edge.values().any(|both| both[1].is_none()) {
            return false;
        }
        let before = (self.triangles.clone(), self.swapped.clone());
        let mut seen = vec![false; self.triangles.len()];
        for start in 0..self.triangles.len() {
            if seen[start] {
                continue;
            }
            seen[start] = true;
            let mut part = vec![start];
            let mut next = 0;
            while let Some(&here) = part.get(next) {
                next += 1;
                for (from, to) in edges(self.triangles[here]) {
                    let both = at_edge[&(from.min(to), from.max(to))];
                    let Some(other) = both.into_iter().flatten().find(|&t| t as usize != here)
                    else {
                        continue;
                    };
                    let other = other as usize;
                    let disagrees = edges(self.triangles[other]).contains(&(from, to));
                    if !seen[other] {
                        seen[other] = true;
                        part.push(other);
                        if disagrees {
                            self.swap(other);
                        }
                    } else if disagrees {
                        // One-sided, as a Klein bottle.
                        (self.triangles, self.swapped) = before;
                        return false;
                    }
                }
            }
            if self.volume(part.iter().copied()) < 0.0 {
                for triangle in part {
                    self.swap(triangle);
                }
            }
        }
        true
    }

    /// Six times the signed volume of some triangles.
    fn volume(&self, triangles: impl Iterator<Item = usize>) -> f64 {
        let origin = self.vertices.first().copied().unwrap_or(DVec3::ZERO);
        triangles
            .map(|index| {
                let [a, b, c] = self.triangles[index].map(|v| self.vertices[v as usize] - origin);
                a.dot(b.cross(c))
            })
            .sum()
    }
}

fn edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// The vertices with equal positions as one, and the triangles over them.
fn joined(mesh: &TriangleMesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let mut vertices: Vec<DVec3> = Vec::new();
    let number = |index: u32| {
        let position = mesh.positions[index as usize];
        // −0 and 0 are the same place.
        let key = position.to_array().map(|x| (x + 0.0).to_bits());
        *numbers.entry(key).or_insert_with(|| {
            vertices.push(position);
            vertices.len() as u32 - 1
        })
    };
    let mut number = number;
    let triangles = mesh.triangles.iter().map(|t| t.map(&mut number)).collect();
    (vertices, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube with 24 corners of its own, as files with a normal per face have it.
    pub(crate) fn cube() -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for axis in 0..3 {
            for side in [0.0, 1.0] {
                let first = mesh.positions.len() as u32;
                for (u, v) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                    let mut place = DVec3::ZERO;
                    place[axis] = side;
                    place[(axis + 1) % 3] = u;
                    place[(axis + 2) % 3] = v;
                    mesh.positions.push(place);
                }
                let corners = if side == 1.0 {
                    [[0, 1, 2], [0, 2, 3]]
                } else {
                    [[0, 2, 1], [0, 3, 2]]
                };
                mesh.triangles.extend(corners.map(|t| t.map(|k| first + k)));
            }
        }
        mesh
    }

    #[test]
    fn a_cube_of_split_faces_is_closed() {
        let topology = Topology::new(&cube());
        assert_eq!(topology.vertices.len(), 8);
        assert!(topology.is_closed());
        assert_eq!(topology.orientation, Orientation::Kept);
        assert_eq!(topology.volume(0..12), 6.0);
    }

    #[test]
    fn holes_are_counted() {
        let mut mesh = cube();
        mesh.triangles.pop();
        let topology = Topology::new(&mesh);
        assert!(!topology.is_closed());
        assert_eq!(topology.open_edges, 3);
    }

    #[test]
    fn what_is_inside_out_is_turned() {
        let mut mesh = cube();
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let topology = Topology::new(&mesh);
        assert_eq!(topology.orientation, Orientation::Reversed);
        assert_eq!(topology.volume(0..12), 6.0);
        mesh.triangles[3].swap(0, 1);
        mesh.triangles[7].swap(0, 1);
        let topology = Topology::new(&mesh);
        assert_eq!(topology.orientation, Orientation::Repaired);
        assert!(topology.is_closed());
        assert_eq!(topology.volume(0..12), 6.0);
    }

    #[test]
    fn an_inner_shell_that_faces_inwards_stays() {
        let mut mesh = cube();
        let inner = cube();
        let first = mesh.positions.len() as u32;
        let shrunk = inner
            .positions
            .iter()
            .map(|p| *p * 0.5 + DVec3::splat(0.25));
        mesh.positions.extend(shrunk);
        let turned = inner
            .triangles
            .iter()
            .map(|&[a, b, c]| [a, c, b].map(|k| first + k));
        mesh.triangles.extend(turned);
        let topology = Topology::new(&mesh);
        assert_eq!(topology.orientation, Orientation::Kept);
        assert!((topology.volume(0..24) - 6.0 * 0.875).abs() < 1e-12);
    }
}
