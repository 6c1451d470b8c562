//! Pictures shaded by the device's stages of cameras, instances and blobs that turn and move, beside those
//! of the CPU.

use crate::common::device;
use crate::stages::{BALLS, LAMPS, SURFACE, check, check_frame, frame_of, frame_with, with};
use glam::{DAffine3, DMat3, DVec3};
use meniscus::frame::{Frame, Geometry, Instance};
use meniscus::kernel::Kernel;
use meniscus::scene::{Matrix, PlacementKey, Scene};
use meniscus_testing::corpus;
use meniscus_testing::turning::turning;

/// Several of a set: upright, turned and stretched, and one that tumbles.
pub(crate) const CROWD: &str = "
[motion]
shutter = 0.5
fps = 1
[[surface]]
name = \"set\"
file = \"set.npy\"
[[instance]]
surface = \"set\"
matrix = [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0]]
[[instance]]
surface = \"set\"
matrix = [[0.4, -0.3, 0.1, 1.4], [0.3, 0.5, 0, 0.2], [0.1, 0, 0.35, 0.3]]
[[instance]]
surface = \"set\"
[[instance.key]]
time = -1.0
matrix = [[0.5, 0, 0, -0.6], [0, 0.5, 0, 0.9], [0, 0, 0.5, 0.3]]
[[instance.key]]
time = 0.1
matrix = [[0, 0, 0.5, -0.5], [0, 0.6, 0, 1.0], [-0.5, 0, 0, 0.5]]
[[instance.key]]
time = 1.0
matrix = [[-0.4, 0, 0, 0.2], [0, 0, 0.4, 0.8], [0, 0.5, 0, 0.3]]
";
/// A camera that flies by, turns and zooms.
pub(crate) const FLIGHT: &str = "
[motion]
shutter = 0.5
fps = 1
[[camera.key]]
time = -1
eye = [2.5, 1.5, 3.0]
target = [0.5, 0.4, 0.5]
fov = 35
[[camera.key]]
time = 0.05
eye = [2.2, 1.8, 3.2]
target = [0.45, 0.5, 0.5]
fov = 40
[[camera.key]]
time = 2
eye = [-1.5, 2.0, 3.5]
target = [0.5, 0.5, 0.5]
up = [0.1, 1, 0]
fov = 30
";

#[test]
fn instances_stand_and_move_as_on_the_cpu() {
    let Some(device) = device("instances_stand_and_move_as_on_the_cpu") else {
        return;
    };
    let ground = "[ground]\n";
    let plain = with("type = \"shaded\"", 8, &[CROWD, ground]);
    check(device, "a crowd", &plain, "pool", &[]);
    let flight = FLIGHT.split_once("fps = 1\n").expect("it has keys").1;
    let ellipsoids = with("type = \"shaded\"", 4, &[CROWD, flight, LAMPS, BALLS]);
    check(
        device,
        "a crowd of ellipsoids",
        &ellipsoids,
        "ellipsoids",
        &[],
    );
    // Deeper paths between curved surfaces make much of the last bits.
    let lit = with(
        "type = \"path\"\ndepth = 3",
        4,
        &[CROWD, flight, LAMPS, BALLS],
    );
    check(device, "a crowd on paths", &lit, "mixed", &[]);
}

/// Scene files place only particles.
#[test]
fn spheres_and_planes_stand_and_move_as_on_the_cpu() {
    let Some(device) = device("spheres_and_planes_stand_and_move_as_on_the_cpu") else {
        return;
    };
    for (what, integrator) in [
        ("solids that move", "type = \"path\""),
        (
            "their highlights",
            "type = \"whitted\"\nspecular_antialiasing = true",
        ),
    ] {
        let motion = "[motion]\nshutter = 0.5\nfps = 1\n";
        let plane = "[[plane]]\npoint = [0, -0.3, 0]\n";
        let text = with(integrator, 4, &[motion, SURFACE, LAMPS, BALLS, plane]);
        let (scene, mut frame) = frame_of(&text, "mixed");
        move_solids(&scene, &mut frame);
        check_frame(device, what, &scene, &frame);
    }
}

/// Gives spheres and planes places and ways.
fn move_solids(scene: &Scene, frame: &mut Frame) {
    let shutter = scene.motion.shutter_secs();
    let key = |time: f64, angle: f64, stretch: DVec3, translation: DVec3| PlacementKey {
        time,
        matrix: Matrix(DAffine3 {
            matrix3: DMat3::from_rotation_z(angle) * DMat3::from_diagonal(stretch),
            translation,
        }),
    };
    let mut moved = 0;
    for instance in &mut frame.instances {
        let (geometry, material) = (instance.geometry, instance.material);
        let place =
            |keys: &[PlacementKey]| Instance::moving(geometry, keys, 0.0, shutter, material);
        match (&frame.geometries[geometry as usize], moved) {
            (Geometry::Sphere(_), 0) => {
                let still = key(0.0, 0.3, DVec3::new(1.2, 0.8, 1.0), DVec3::ZERO);
                *instance = place(&[still]);
            }
            (Geometry::Sphere(_), _) => {
                let from = key(-0.4, 0.0, DVec3::ONE, DVec3::Y * 0.1);
                let to = key(0.3, 0.8, DVec3::new(1.0, 1.3, 0.9), DVec3::X * 0.2);
                *instance = place(&[from, to]);
            }
            (Geometry::Plane(_), _) => {
                let from = key(-0.5, 0.1, DVec3::ONE, DVec3::ZERO);
                let to = key(0.5, -0.1, DVec3::ONE, DVec3::Y * 0.2);
                *instance = place(&[from, to]);
            }
            _ => continue,
        }
        moved += 1;
    }
    assert!(moved > 6, "{moved}");
}

#[test]
fn particles_turn_as_on_the_cpu() {
    let Some(device) = device("particles_turn_as_on_the_cpu") else {
        return;
    };
    let motion = "[motion]\nshutter = 1\nfps = 1\n";
    let field = || turning(&corpus::scene("ellipsoids", Kernel::Sextic, 400), 0.8).field;
    let text = with("type = \"shaded\"", 8, &[motion, SURFACE, "[ground]\n"]);
    let (scene, frame) = frame_with(&text, field());
    check_frame(device, "particles that turn", &scene, &frame);
    let text = with("type = \"ao\"", 4, &[CROWD, BALLS]);
    let (scene, frame) = frame_with(&text, field());
    check_frame(device, "a crowd of them", &scene, &frame);
}

#[test]
fn cameras_move_as_on_the_cpu() {
    let Some(device) = device("cameras_move_as_on_the_cpu") else {
        return;
    };
    let ground = "[ground]\n";
    let plain = with("type = \"shaded\"", 8, &[SURFACE, FLIGHT, ground]);
    check(device, "a flight", &plain, "pool", &[]);
    let balls = with("type = \"path\"", 4, &[SURFACE, FLIGHT, LAMPS, BALLS]);
    check(device, "a flight among balls", &balls, "mixed", &[]);
}
