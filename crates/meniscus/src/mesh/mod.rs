//! Triangle meshes: what stands beside particle surfaces in a scene.

pub mod io;
pub mod topology;

pub use io::{MeshError, MeshFile, MeshFormat};
pub use topology::{Orientation, Topology};

use glam::{DVec3, Vec3};

/// Triangles as a file gives them, checked: every index exists and every corner is finite.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleMesh {
    /// Vertices, in the file's unit and coordinates.
    pub positions: Vec<DVec3>,
    /// Unit normals of the vertices for smooth shading: one per position, or none at all. A zero
    /// stands for "as the face".
    pub normals: Vec<Vec3>,
    /// Corners, as indices into the positions; none of zero area.
    pub triangles: Vec<[u32; 3]>,
}

/// A mesh that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshProblem {
    /// There is nothing to see.
    #[error("it has no faces{}", if *.vertices > 0 { format!(", {vertices} vertices only") } else { String::new() })]
    Empty {
        /// Vertices without a face.
        vertices: usize,
    },
    /// More vertices or faces than indices can count.
    #[error("it has {count} {what}, more than 2³¹")]
    TooLarge {
        /// Vertices or triangles.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// A face refers to a vertex that is not there.
    #[error("face {face} (from 0) refers to vertex {index}, there are {vertices}")]
    Index {
        /// The face.
        face: usize,
        /// The vertex.
        index: u64,
        /// How many there are.
        vertices: usize,
    },
    /// A corner that is nowhere.
    #[error("vertex {vertex} (from 0), a corner of face {face}, is at {position}")]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// A face that uses it.
        face: usize,
        /// Where.
        position: DVec3,
    },
    /// Every triangle has been left out.
    #[error(
        "all of its {count} triangles are degenerate: two corners in one point, or all on a line"
    )]
    Degenerate {
        /// How many there were.
        count: usize,
    },
}

impl TriangleMesh {
    /// A mesh of polygons, each split into a fan from its first corner (right where it is convex),
    /// and the number of degenerate triangles that were left out. Normals are dropped where they do
    /// not match the positions.
    ///
    /// # Errors
    /// Indices that do not exist, corners that are not finite, and meshes without a triangle.
    pub fn from_polygons<'a>(
        positions: Vec<DVec3>,
        normals: Vec<Vec3>,
        polygons: impl Iterator<Item = &'a [u64]>,
    ) -> Result<(Self, usize), MeshProblem> {
        let vertices = positions.len();
        if vertices >= 1 << 31 {
            let (what, count) = ("vertices", vertices);
            return Err(MeshProblem::TooLarge { what, count });
        }
        let mut mesh = Self {
            normals: normals.into_iter().map(Vec3::normalize_or_zero).collect(),
            positions,
            triangles: Vec::new(),
        };
        if mesh.normals.len() != vertices {
            mesh.normals.clear();
        }
        let mut degenerate = 0;
        let mut faces = 0;
        for (face, polygon) in polygons.enumerate() {
            faces += 1;
            let outside = polygon.iter().find(|&&index| index >= vertices as u64);
            if let Some(&index) = outside {
                return Err(MeshProblem::Index {
                    face,
                    index,
                    vertices,
                });
            }
            for k in 1..polygon.len().saturating_sub(1) {
                let corners = [polygon[0], polygon[k], polygon[k + 1]].map(|index| index as u32);
                let places = corners.map(|corner| mesh.positions[corner as usize]);
                if let Some(at) = places.iter().position(|place| !place.is_finite()) {
                    return Err(MeshProblem::NotFinite {
                        vertex: corners[at],
                        face,
                        position: places[at],
                    });
                }
                if area_direction(places) == DVec3::ZERO {
                    degenerate += 1;
                } else {
                    mesh.triangles.push(corners);
                }
            }
        }
        match mesh.triangles.len() {
            0 if degenerate > 0 => Err(MeshProblem::Degenerate { count: degenerate }),
            0 if faces == 0 || vertices > 0 => Err(MeshProblem::Empty { vertices }),
            0 => Err(MeshProblem::Empty { vertices: 0 }),
            count if count >= 1 << 31 => {
                let what = "triangles";
                Err(MeshProblem::TooLarge { what, count })
            }
            _ => Ok((mesh, degenerate)),
        }
    }
}

/// The unit normal of a triangle by the right-hand rule; zero where it has no area. The edges are
/// scaled first, so that neither tiny nor huge triangles under- or overflow.
pub fn area_direction([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (u, v) = (b - a, c - a);
    let size = u.abs().max_element().max(v.abs().max_element());
    if size == 0.0 || !size.is_finite() {
        return DVec3::ZERO;
    }
    let cross = (u / size).cross(v / size);
    // Below this the rounding of the corners decides about the direction.
    if cross.length_squared() <= 1e-60 {
        return DVec3::ZERO;
    }
    cross.normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec3> {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[x, y]| DVec3::new(x, y, 0.0))
            .to_vec()
    }

    fn mesh(positions: Vec<DVec3>, faces: &[&[u64]]) -> Result<(TriangleMesh, usize), MeshProblem> {
        TriangleMesh::from_polygons(positions, Vec::new(), faces.iter().copied())
    }

    #[test]
    fn polygons_become_fans_and_degenerate_ones_go() {
        let (found, degenerate) = mesh(square(), &[&[0, 1, 2, 3], &[0, 1, 1], &[2, 3]]).unwrap();
        assert_eq!(found.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(degenerate, 1);
        // On a line, at any scale.
        for scale in [1e-200, 1.0, 1e200] {
            let line = [0.0, 1.0, 2.0].map(|x| DVec3::splat(x * scale)).to_vec();
            assert_eq!(
                mesh(line, &[&[0, 1, 2]]),
                Err(MeshProblem::Degenerate { count: 1 })
            );
            let real = square().iter().map(|p| *p * scale).collect();
            assert_eq!(mesh(real, &[&[0, 1, 2]]).unwrap().1, 0);
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let message = |positions, faces| mesh(positions, faces).unwrap_err().to_string();
        let text = message(square(), &[&[0, 1, 2], &[0, 1, 4]]);
        assert!(
            text.contains("face 1") && text.contains("vertex 4"),
            "{text}"
        );
        let mut broken = square();
        broken[2].y = f64::NAN;
        let text = message(broken.clone(), &[&[0, 1, 3], &[0, 1, 2]]);
        assert!(text.contains("vertex 2") && text.contains("NaN"), "{text}");
        // A vertex that no face uses does no harm.
        assert!(mesh(broken, &[&[0, 1, 3]]).is_ok());
        assert!(message(square(), &[]).contains("no faces, 4 vertices only"));
    }
}
