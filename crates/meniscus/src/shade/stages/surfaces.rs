//! Where surfaces are, in flat words: planes, spheres, meshes, and the ways of what turns or moves.

use super::words::{Words, halves};
use crate::frame::{Frame, Geometry, Instance, MeshSurface};
use crate::math::cubics::Piece;
use crate::mesh::area_direction;
use glam::{DVec3, Vec3};

/// Words per surface: (kind, material, way, pieces), then of a plane (normal, height of the origin over it),
/// (–, –, –, low part of the height), of a sphere (centre, radius), (low part of the centre, –), of a mesh
/// (first word of its nodes, of its triangles, words of each, whether it is closed), –. What turns,
/// stretches or moves has a way ([`Instance::way`]), meshes always: of the field's origin, the sphere's
/// centre, in radii, the mesh's centre, in its sizes, or the plane's point, and the plane's normal is the
/// object's.
pub const SURFACE_WORDS: u32 = 3;

/// How much wider boxes of a mesh's nodes are, for rounding, in the mesh's own coordinates.
const BOX_MARGIN: f32 = 1e-6;

const PLANE: f32 = 1.0;
const SPHERE: f32 = 2.0;
const MESH: f32 = 3.0;

/// All surfaces, behind their meshes and ways; returns the word of the first surface.
pub(super) fn all_surface_words(
    frame: &Frame,
    shutter: [f64; 2],
    origin: DVec3,
    words: &mut Words,
) -> u32 {
    let meshes: Vec<Vec3> = (frame.geometries.iter())
        .map(|geometry| match geometry {
            Geometry::Mesh(mesh) => mesh_words(mesh, words),
            Geometry::Blobs(_) | Geometry::Sphere(_) | Geometry::Plane(_) => Vec3::ZERO,
        })
        .collect();
    let ways: Vec<[f32; 2]> = (frame.instances.iter())
        .map(|instance| way_words(frame, instance, shutter, origin, words))
        .collect();
    let here = words.here();
    for (instance, way) in frame.instances.iter().zip(ways) {
        let mesh = meshes[instance.geometry as usize];
        surface_words(frame, (instance, mesh, way), origin, words);
    }
    here
}

/// (normal, height of the origin over the plane), (–, –, –, low part of the height).
pub(super) fn plane_words(normal: DVec3, height: f64, words: &mut Words) {
    let [high, low] = halves(DVec3::X * height);
    words.push(normal.as_vec3(), high.x);
    words.push(Vec3::ZERO, low.x);
}

/// Nodes: (lower corner, first child or triangle), (upper corner, triangles or 0); then triangles in the
/// order of the leaves: corners, beside each a component of the face's normal, then where the mesh is smooth
/// the normals of the corners. Returns the first words of both, and the words of a triangle.
fn mesh_words(mesh: &MeshSurface, words: &mut Words) -> Vec3 {
    let nodes = words.here();
    for node in &mesh.tree.nodes {
        let [low, high] = [node.min, node.max].map(Vec3::from_array);
        words.push(low - BOX_MARGIN, node.first as f32);
        words.push(high + BOX_MARGIN, node.count as f32);
    }
    let triangles = words.here();
    for &triangle in &mesh.tree.order {
        let triangle = triangle as usize;
        let corners = mesh.corners(triangle);
        let face = area_direction(corners).as_vec3();
        for (corner, component) in corners.into_iter().zip(face.to_array()) {
            words.push(corner.as_vec3(), component);
        }
        for normal in mesh.corner_normals.get(triangle).into_iter().flatten() {
            // A zero stands for the face's own.
            words.push(if *normal == Vec3::ZERO { face } else { *normal }, 0.0);
        }
    }
    let per_triangle = if mesh.corner_normals.is_empty() {
        3.0
    } else {
        6.0
    };
    Vec3::new(nodes as f32, triangles as f32, per_triangle)
}

/// The way of an instance that turns, stretches or moves: its first word and its pieces, or zeros.
fn way_words(
    frame: &Frame,
    instance: &Instance,
    shutter: [f64; 2],
    origin: DVec3,
    words: &mut Words,
) -> [f32; 2] {
    let (pivot, unit) = match &frame.geometries[instance.geometry as usize] {
        Geometry::Mesh(mesh) => (mesh.center, mesh.size),
        _ if instance.is_upright() => return [0.0; 2],
        Geometry::Blobs(blobs) => (blobs.field.origin, 1.0),
        Geometry::Sphere(sphere) => (sphere.center, sphere.radius),
        // One that stands still may turn.
        Geometry::Plane(_) if instance.path.is_none() => return [0.0; 2],
        Geometry::Plane(plane) => (plane.point, 1.0),
    };
    let here = words.here();
    let reach = frame.reach_of(instance);
    let way = instance.way(shutter, (pivot, unit), origin, reach);
    words.0.extend(way.iter().flat_map(Piece::words));
    [here as f32, way.len() as f32]
}

fn surface_words(
    frame: &Frame,
    (instance, mesh_at, [way, pieces]): (&Instance, Vec3, [f32; 2]),
    origin: DVec3,
    words: &mut Words,
) {
    let head = |words: &mut Words, kind: f32| {
        words.0.push([kind, instance.material as f32, way, pieces]);
    };
    match &frame.geometries[instance.geometry as usize] {
        Geometry::Plane(plane) if pieces > 0.0 => {
            head(words, PLANE);
            words.push(plane.normal.as_vec3(), 0.0);
            words.push(Vec3::ZERO, 0.0);
        }
        Geometry::Plane(plane) => {
            let normal = instance.object_from_world.matrix3.transpose() * plane.normal;
            let normal = normal.normalize_or_zero();
            let point = instance.world_from_object.transform_point3(plane.point);
            head(words, PLANE);
            plane_words(normal, (origin - point).dot(normal), words);
        }
        Geometry::Sphere(sphere) => {
            let center = instance.world_from_object.transform_point3(sphere.center);
            let [center, rest] = halves(center - origin);
            head(words, SPHERE);
            words.push(center, sphere.radius as f32);
            words.push(rest, 0.0);
        }
        Geometry::Mesh(mesh) if !mesh.tree.nodes.is_empty() => {
            head(words, MESH);
            words.push(mesh_at, f32::from(u8::from(mesh.is_closed)));
            words.push(Vec3::ZERO, 0.0);
        }
        Geometry::Blobs(_) | Geometry::Mesh(_) => {
            head(words, 0.0);
            words.push(Vec3::ZERO, 0.0);
            words.push(Vec3::ZERO, 0.0);
        }
    }
}
