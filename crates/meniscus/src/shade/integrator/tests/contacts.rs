//! Solids whose faces coincide.

use super::*;
use crate::frame::MeshSurface;
use crate::mesh::TriangleMesh;
use crate::scene::{Matrix, Mesh};
use glam::{DAffine3, DQuat};

/// A box with corners at ±1.
fn cube() -> MeshSurface {
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let corner = |k: usize| {
        DVec3::from_array([0, 1, 2].map(|bit| if k >> bit & 1 == 0 { -1.0 } else { 1.0 }))
    };
    let mesh = TriangleMesh {
        positions: (0..8).map(corner).collect(),
        normals: Vec::new(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    };
    MeshSurface::build(&mesh).0
}

/// Boxes in a row along x, each touching the next; the row turned and far from the origin.
fn row(materials: &[Material]) -> (Frame, DAffine3) {
    let turned = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.7),
        DVec3::new(31.7, -12.3, 5.1),
    );
    let mut scene = Scene::default();
    for (index, material) in materials.iter().enumerate() {
        let name = format!("box {index}");
        scene.materials.insert(name.clone(), material.clone());
        scene.meshes.push(Mesh {
            matrix: Matrix(turned * DAffine3::from_translation(DVec3::X * (2.0 * index as f64))),
            material: Some(name),
            ..Mesh::default()
        });
    }
    let meshes = materials.iter().map(|_| cube()).collect();
    let mut frame =
        Frame::build_with_meshes(&scene, Vec::new(), meshes, &FrameSettings::default()).unwrap();
    frame.lights = vec![Light::Constant { radiance: [1.0; 3] }];
    (frame, turned)
}

/// Points in the unit square, evenly spread.
fn spread(count: u32) -> impl Iterator<Item = [f64; 2]> {
    (0..count).map(|i| [0.754_877_666, 0.569_840_291].map(|step| (f64::from(i) * step).fract()))
}

/// Glass that bends nothing and leaves a quarter of the light behind 1.
fn filter() -> Material {
    Material {
        ior: Some(1.0),
        absorption: Some(Color([0.25; 3])),
        absorption_depth: Some(1.0),
        ..Material::of(MaterialKind::Dielectric, None)
    }
}

#[test]
fn boxes_face_to_face_absorb_like_one() {
    let (frame, turned) = row(&[filter(), filter()]);
    // Three surfaces: no path is ended by chance.
    let settings = path_settings(12);
    for [y, z] in spread(2000) {
        // In at the first end, out at the last one, slanted.
        let from = DVec3::new(-4.0, 1.2 * y - 0.6, 1.2 * z - 0.6);
        let to = DVec3::new(6.0, 0.6 - 1.2 * z, 1.2 * y - 0.6);
        let direction = (to - from).normalize();
        let ray = Ray::new(
            turned.transform_point3(from),
            turned.transform_vector3(direction),
        );
        let chord = 4.0 / direction.x;
        let (seen, _) = mean(&frame, &settings, &ray, 1);
        let expected = 0.25_f64.powf(chord);
        assert!(
            (seen / expected - 1.0).abs() < 1e-4,
            "{from}: {seen} for {expected}"
        );
    }
}

#[test]
fn rays_from_an_opaque_face_go_through_what_stands_on_it() {
    // The floor is the end of the row; glass without absorption and without an index changes nothing.
    let clear = Material {
        absorption: Some(Color::WHITE),
        ..filter()
    };
    let (frame, turned) = row(&[clear.clone(), clear, material(MaterialKind::Diffuse)]);
    for [y, z] in spread(300) {
        let from = DVec3::new(-4.0, 1.2 * y - 0.6, 1.2 * z - 0.6);
        let direction = (DVec3::new(3.0, 0.6 - 1.2 * z, 1.2 * y - 0.6) - from).normalize();
        let ray = Ray::new(
            turned.transform_point3(from),
            turned.transform_vector3(direction),
        );
        // White in white light; no way out but through the glass.
        let (seen, error) = mean(&frame, &path_settings(64), &ray, 64);
        assert!(
            (seen - 1.0).abs() < 0.02 + 4.0 * error,
            "{from}: {seen} ± {error}"
        );
    }
}

#[test]
fn what_stands_on_an_opaque_face_shows_it() {
    let (frame, turned) = row(&[filter(), material(MaterialKind::Diffuse)]);
    let settings = path_settings(4);
    let shader = Shader::new(&frame, &settings);
    let mut scratch = ShadeScratch::default();
    for [y, z] in spread(2000) {
        let from = DVec3::new(-4.0, 1.8 * y - 0.9, 1.8 * z - 0.9);
        let to = DVec3::new(1.0, 1.8 * z - 0.9, 0.9 - 1.8 * y);
        let direction = (to - from).normalize();
        let ray = Ray::new(
            turned.transform_point3(from),
            turned.transform_vector3(direction),
        );
        let hit = frame.closest_hit(&ray, &mut scratch.trace).unwrap();
        if hit.surface != 0 {
            continue;
        }
        let world = &shader.world;
        let air = MediumStack::default();
        let inside = world
            .interaction(&ray, hit, &air, 0.0, &mut scratch)
            .unwrap();
        let ray = inside.leaving(ray.direction, false, 0.0);
        let hit = frame.closest_hit(&ray, &mut scratch.trace).unwrap();
        if (hit.position - turned.transform_point3(to)).length() > 1e-6 {
            continue;
        }
        let floor = world
            .interaction(&ray, hit, &inside.beyond, 0.0, &mut scratch)
            .unwrap();
        assert_eq!((floor.hit.surface, floor.hit.entering), (1, true), "{to}");
        assert_eq!(floor.beyond, inside.beyond);
    }
}
