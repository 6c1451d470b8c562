//! Surfaces that are no fields: meshes, spheres, planes.

use crate::accel::triangles::TriangleTree;
use crate::math::aabb::DAabb;
use crate::mesh::{Orientation, Topology, TriangleMesh};
use glam::{DVec3, Vec3};

/// An infinite plane; its inside is the half space below it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point on the plane, object space.
    pub point: DVec3,
    /// Unit normal, pointing outside.
    pub normal: DVec3,
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Centre, object space.
    pub center: DVec3,
    /// Radius, positive.
    pub radius: f64,
}

/// A triangle mesh with the structure that traces it. A closed mesh is a solid; one with holes is a
/// sheet that has two sides and no inside.
///
/// Its own coordinates are those of the object minus `center`, over `size`: within [−1, 1] whatever
/// the mesh measures.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshSurface {
    /// Middle of the mesh, object space.
    pub center: DVec3,
    /// Largest distance from the middle along an axis.
    pub size: f64,
    /// Vertices in the mesh's own coordinates; each position once.
    pub vertices: Vec<DVec3>,
    /// Corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Normals of the corners for smooth shading, towards the outside; empty where faces are flat. A
    /// zero stands for the face's own.
    pub corner_normals: Vec<[Vec3; 3]>,
    /// Whether it encloses something.
    pub is_closed: bool,
    /// The hierarchy over the triangles.
    pub tree: TriangleTree,
}

impl MeshSurface {
    /// Builds what tracing needs; with it what a user should know about the mesh, one sentence each.
    pub fn build(mesh: &TriangleMesh) -> (Self, Vec<String>) {
        let topology = Topology::new(mesh);
        let notes = notes(&topology);
        (Self::of_topology(mesh, topology), notes)
    }

    fn of_topology(mesh: &TriangleMesh, topology: Topology) -> Self {
        let bounds = topology
            .vertices
            .iter()
            .filter(|vertex| vertex.is_finite())
            .fold(DAabb::EMPTY, |bounds, &vertex| bounds.including(vertex));
        // Halves first: the sum of two huge coordinates may be infinite.
        let center = bounds.min * 0.5 + bounds.max * 0.5;
        let size = (bounds.max * 0.5 - bounds.min * 0.5).max_element();
        let size = if size > 0.0 { size } else { 1.0 };
        let own = |vertex: &DVec3| {
            if vertex.is_finite() {
                (*vertex - center) / size
            } else {
                DVec3::ZERO
            }
        };
        let vertices: Vec<DVec3> = topology.vertices.iter().map(own).collect();
        let tree = TriangleTree::build(&vertices, &topology.triangles);
        let corner_normals = match mesh.normals.is_empty() {
            true => Vec::new(),
            false => corner_normals(mesh, &topology),
        };
        Self {
            center,
            size,
            is_closed: topology.is_closed(),
            triangles: topology.triangles,
            vertices,
            corner_normals,
            tree,
        }
    }

    /// Corners of a triangle in the mesh's own coordinates.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Memory that it takes.
    pub fn bytes(&self) -> usize {
        self.tree.bytes()
            + size_of_val(&self.vertices[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.corner_normals[..])
    }

    /// Object-space box.
    pub fn bounds(&self) -> DAabb {
        self.vertices.iter().fold(DAabb::EMPTY, |bounds, &vertex| {
            bounds.including(self.center + vertex * self.size)
        })
    }
}

fn notes(topology: &Topology) -> Vec<String> {
    let mut notes = Vec::new();
    if !topology.is_closed() {
        notes.push(format!(
            "the mesh has holes ({} edges without a partner): it is a sheet with two sides and no \
             inside, which no cut caps",
            topology.open_edges
        ));
    }
    match topology.orientation {
        Orientation::Kept => {}
        Orientation::Reversed => notes.push("the mesh was inside out: its faces were turned".into()),
        Orientation::Repaired => notes.push(
            "the faces of the mesh disagree about what is outside: each connected part was turned so \
             that it encloses a volume"
                .into(),
        ),
    }
    notes
}

/// The normals of the file at the corners, turned to the side that the faces show as outside.
fn corner_normals(mesh: &TriangleMesh, topology: &Topology) -> Vec<[Vec3; 3]> {
    let of_file = mesh.triangles.iter();
    let with_topology = of_file.zip(&topology.triangles).zip(&topology.swapped);
    with_topology
        .map(|((&[a, b, c], corners), &is_swapped)| {
            let order = if is_swapped { [a, c, b] } else { [a, b, c] };
            let places = corners.map(|corner| topology.vertices[corner as usize]);
            let face = crate::mesh::area_direction(places).as_vec3();
            order.map(|corner| {
                let normal = mesh.normals[corner as usize];
                if normal.dot(face) < 0.0 {
                    -normal
                } else {
                    normal
                }
            })
        })
        .collect()
}
