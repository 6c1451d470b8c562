//! Pictures with triangle meshes shaded by the device's stages beside those of the CPU.

use crate::common::device;
use crate::stages::{LAMPS, SURFACE, check_frame, with};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use meniscus::accel::Engine;
use meniscus::frame::{Frame, FrameSettings, Geometry, Instance, MeshSurface};
use meniscus::kernel::Kernel;
use meniscus::mesh::TriangleMesh;
use meniscus::scene::{Matrix, PlacementKey, Scene};
use meniscus_testing::corpus;

/// A box with corners at 0 and 1.
fn cube() -> TriangleMesh {
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let corner = |k: usize| DVec3::from_array([0, 1, 2].map(|bit| (k >> bit & 1) as f64));
    TriangleMesh {
        positions: (0..8).map(corner).collect(),
        normals: Vec::new(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// A ring in the plane z = 0, with normals.
fn torus() -> TriangleMesh {
    const AROUND: u32 = 24;
    const ACROSS: u32 = 12;
    let angle = |i: u32, of: u32| std::f64::consts::TAU * f64::from(i) / f64::from(of);
    let points = (0..AROUND).flat_map(|i| (0..ACROSS).map(move |k| (i, k)));
    let (positions, normals) = points
        .map(|(i, k)| {
            let (sin, cos) = angle(i, AROUND).sin_cos();
            let (up, out) = angle(k, ACROSS).sin_cos();
            let normal = DVec3::new(cos * out, sin * out, up);
            (DVec3::new(cos, sin, 0.0) + normal * 0.4, normal.as_vec3())
        })
        .unzip();
    let number = |i: u32, k: u32| (i % AROUND) * ACROSS + k % ACROSS;
    let quads = (0..AROUND).flat_map(|i| (0..ACROSS).map(move |k| (i, k)));
    let triangles = quads.flat_map(|(i, k)| {
        let [a, b, c, d] =
            [(i, k), (i + 1, k), (i + 1, k + 1), (i, k + 1)].map(|(i, k)| number(i, k));
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh {
        positions,
        normals,
        triangles: triangles.collect(),
    }
}

/// A wavy sheet over the unit square, which encloses nothing.
fn sheet() -> TriangleMesh {
    const SIDE: u32 = 20;
    let points = (0..=SIDE).flat_map(|i| (0..=SIDE).map(move |k| (i, k)));
    let positions = points.map(|(i, k)| {
        let [x, z] = [i, k].map(|n| f64::from(n) / f64::from(SIDE));
        DVec3::new(x, 0.05 * (9.0 * x).sin() * (7.0 * z).cos(), z)
    });
    let number = |i: u32, k: u32| i * (SIDE + 1) + k;
    let quads = (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k)));
    let triangles = quads.flat_map(|(i, k)| {
        let [a, b, c, d] =
            [(i, k), (i, k + 1), (i + 1, k + 1), (i + 1, k)].map(|(i, k)| number(i, k));
        [[a, b, c], [a, c, d]]
    });
    TriangleMesh {
        positions: positions.collect(),
        normals: Vec::<Vec3>::new(),
        triangles: triangles.collect(),
    }
}

/// Beside and below the particles.
const MESHES: &str = "
[material.glass]
type = \"glass\"
absorption = [0.4, 0.8, 0.9]
absorption_depth = 0.5
[material.coat]
type = \"plastic\"
color = [0.7, 0.2, 0.1]
roughness = 0.25
[material.metal]
type = \"metal\"
roughness = 0.3
[[mesh]]
file = \"cube\"
material = \"BOX\"
matrix = [[0.4, -0.2, 0, 1.3], [0.2, 0.4, 0, -0.1], [0, 0, 0.5, 0.4]]
[[mesh]]
file = \"torus\"
material = \"coat\"
matrix = [[0.3, 0, 0, -0.4], [0, 0.3, 0, 0.5], [0, 0, 0.3, 0.9]]
[[mesh]]
file = \"sheet\"
material = \"metal\"
matrix = [[3, 0, 0, -1], [0, 3, 0, -0.4], [0, 0, 3, -1]]
";

fn frame_of(text: &str, set: &str) -> (Scene, Frame) {
    let scene = meniscus::scene::file::parse(text, "test").expect("the scene is sound");
    let field = corpus::scene(set, Kernel::Sextic, 400).field;
    let meshes = [cube(), torus(), sheet()].map(|mesh| MeshSurface::build(&mesh).0);
    let settings = FrameSettings {
        engine: Engine::Cells,
        ..FrameSettings::default()
    };
    let frame = Frame::build_with_meshes(&scene, vec![field], meshes.into(), &settings);
    (scene, frame.expect("the scene is sound"))
}

#[test]
fn meshes_are_those_of_the_cpu() {
    let Some(device) = device("meshes_are_those_of_the_cpu") else {
        return;
    };
    let plain = MESHES.replace("BOX", "coat");
    let check = |what: &str, text: &str, set: &str| {
        let (scene, frame) = frame_of(text, set);
        check_frame(device, what, &scene, &frame);
    };
    let shaded = with("type = \"shaded\"", 4, &[SURFACE, LAMPS, &plain]);
    check("meshes", &shaded, "pool");
    let open = with("type = \"ao\"", 4, &[SURFACE, &plain]);
    check("meshes in the open", &open, "mixed");
    let lit = with("type = \"path\"\ndepth = 3", 4, &[SURFACE, LAMPS, &plain]);
    check("paths among meshes", &lit, "mixed");
    let glass = MESHES.replace("BOX", "glass");
    let tree = with(
        "type = \"whitted\"\ndepth = 5",
        1,
        &[SURFACE, LAMPS, &glass],
    );
    check("a box of glass", &tree, "mixed");
    let cut = "[[clip]]\npoint = [0.1, 0, 1.2]\nnormal = [0.4, 0, 1]\n";
    let cut = with("type = \"shaded\"", 4, &[SURFACE, LAMPS, &plain, cut]);
    check("meshes cut open", &cut, "pool");
}

#[test]
fn meshes_move_as_on_the_cpu() {
    let Some(device) = device("meshes_move_as_on_the_cpu") else {
        return;
    };
    let motion = "[motion]\nshutter = 0.5\nfps = 1\n";
    let text = with(
        "type = \"shaded\"",
        8,
        &[motion, SURFACE, LAMPS, &MESHES.replace("BOX", "coat")],
    );
    let (scene, mut frame) = frame_of(&text, "pool");
    let shutter = scene.motion.shutter_secs();
    let key = |time: f64, angle: f64, from: &Instance| {
        let turn = DAffine3::from_mat3(DMat3::from_rotation_z(angle));
        PlacementKey {
            time,
            matrix: Matrix(from.world_from_object * turn),
        }
    };
    for instance in &mut frame.instances {
        let geometry = instance.geometry;
        if matches!(frame.geometries[geometry as usize], Geometry::Mesh(_)) {
            let keys = [key(-0.3, -0.2, instance), key(0.4, 0.3, instance)];
            *instance = Instance::moving(geometry, &keys, 0.0, shutter, instance.material);
        }
    }
    check_frame(device, "meshes that move", &scene, &frame);
}
