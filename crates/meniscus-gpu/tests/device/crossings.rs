//! Every crossing of a ray: the device's lists against the float64 oracle, and a frame's against the CPU's.

use crate::common::{Gpu, SHUTTER, blobs, device, moving};
use glam::{DAffine3, DMat3, DVec3};
use meniscus::accel::Engine;
use meniscus::field::BlobField;
use meniscus::frame::{Frame, FrameSettings, MeshSurface};
use meniscus::intersect::{Crossing, Scratch};
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::mesh::TriangleMesh;
use meniscus::particles::Particles;
use meniscus::scene::{
    BlobSettings, Builder, Clip, Ground, Instance, Matrix, Mesh, Scene, Sphere, Surface,
};
use meniscus_gpu::{FrameTracer, Takeover, TraceWork, TracerOptions};
use meniscus_testing::corpus::{self, Scene as Set};
use meniscus_testing::examine::{Question, Tracer};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use meniscus_testing::suite::{Stage, complaints};

const EYE: DVec3 = DVec3::new(-1.0, 0.1, -0.2);

#[expect(clippy::print_stderr, reason = "how many rays went where")]
fn check(set: &Set, time: f64, builder: Builder, options: TracerOptions) -> TraceWork {
    let name = &set.name;
    let Some(device) = device(name) else {
        return TraceWork::default();
    };
    let oracle = Oracle::at(&set.field, time);
    let stage = Stage::new(set, &oracle, 60);
    let mut all = rays::primary(&oracle, 20, EYE);
    all.extend(rays::hemisphere(&stage.points, 91));
    all.extend(rays::grazing(&oracle, &stage.points, 92));
    all.extend(rays::inside(&oracle, &stage.points, 93));
    all.extend(rays::evil(&oracle, &stage.points, 94));
    let all: Vec<Ray> = all.into_iter().map(|ray| Ray { time, ..ray }).collect();
    let blobs = blobs(set.field.clone(), builder);
    let gpu = Gpu::new(device, &blobs, options);
    let complaint = complaints(&gpu, &stage, &all, Question::AllTogether);
    assert_eq!(complaint, None, "{name} at {time}");
    let work = gpu.work();
    eprintln!(
        "{name}: {} rays, {} crowded, {} on the CPU",
        work.rays, work.crowded, work.on_cpu
    );
    work
}

#[test]
fn all_crossings() {
    let mut sum = TraceWork::default();
    for (i, kind) in corpus::KINDS.iter().enumerate() {
        let set = corpus::scene(kind, Kernel::ALL[i % Kernel::ALL.len()], 400);
        sum += check(&set, 0.0, Builder::Sah, TracerOptions::default());
    }
    // Most are the device's own.
    assert!(sum.on_cpu * 4 <= sum.rays, "{sum:?}");
}

#[test]
fn all_crossings_of_evil_sets() {
    for set in corpus::evil() {
        check(&set, 0.0, Builder::Device, TracerOptions::default());
    }
}

#[test]
fn all_crossings_among_moving_blobs() {
    for kind in ["pool", "ellipsoids", "mixed"] {
        let set = moving(corpus::scene(kind, Kernel::Sextic, 400));
        for time in [SHUTTER[0], 0.13] {
            check(&set, time, Builder::Sah, TracerOptions::default());
        }
    }
}

#[test]
fn all_crossings_with_little_room() {
    let options = TracerOptions {
        largest_chunk_bytes: Some(1 << 14),
        capacity: Some(8),
    };
    for kind in ["pool", "ellipsoids"] {
        check(
            &corpus::scene(kind, Kernel::Sextic, 400),
            0.0,
            Builder::Sah,
            options,
        );
    }
}

/// More crossings than a ray has records for: it is sent again from the last one, and the device finds all.
#[test]
fn rays_with_many_crossings_go_on() {
    let Some(device) = device("rays_with_many_crossings_go_on") else {
        return;
    };
    let count = 45;
    let row = (0..count).map(|i| DVec3::X * (3.0 * f64::from(i)));
    let row = Particles::from_positions(row.collect());
    let settings = BlobSettings {
        radius: Some(1.0),
        ..BlobSettings::molecule()
    };
    let field = BlobField::from_particles(&row, &settings).expect("they are sound");
    let blobs = blobs(field.field, Builder::Sah);
    let gpu = Gpu::new(device, &blobs, TracerOptions::default());
    let rays: Vec<Ray> = (0..40)
        .map(|i| Ray::new(DVec3::new(-2.0, 0.02 * f64::from(i), 0.1), DVec3::X * 2.0))
        .collect();
    let lists = gpu.crossings_many(&rays, &mut Scratch::default());
    for (ray, list) in rays.iter().zip(lists) {
        let beside = ray.origin.y.hypot(ray.origin.z);
        let half = (1.0 - beside * beside).sqrt();
        assert_eq!(list.len(), 2 * count as usize, "{ray:?}");
        for (i, crossing) in list.iter().enumerate() {
            let ball = 3.0 * (i / 2) as f64;
            let x = if i % 2 == 0 { ball - half } else { ball + half };
            assert_eq!(crossing.entering, i % 2 == 0);
            assert!((2.0 * crossing.t - 2.0 - x).abs() < 1e-4, "{crossing:?}");
        }
    }
    assert_eq!(gpu.work().on_cpu, 0);
}

fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        normals: Vec::new(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    }
}

/// Blobs twice, once turned and moved away, beside a mesh, a sphere and a plane, cut open.
#[test]
fn a_frame_s_crossings_are_those_of_the_cpu() {
    let Some(device) = device("a_frame_s_crossings_are_those_of_the_cpu") else {
        return;
    };
    let turned = DAffine3::from_mat3_translation(
        DMat3::from_rotation_z(0.7) * 1.3,
        DVec3::new(2.0, 0.2, 0.1),
    );
    let scene = |clips| Scene {
        surfaces: vec![Surface {
            name: Some("set".to_owned()),
            ..Surface::from_file("set")
        }],
        instances: [DAffine3::IDENTITY, turned]
            .map(|matrix| Instance {
                surface: "set".to_owned(),
                matrix: Matrix(matrix),
                material: None,
                keys: Vec::new(),
            })
            .to_vec(),
        meshes: vec![Mesh {
            matrix: Matrix(DAffine3::from_translation(DVec3::new(-0.6, 0.2, 0.0))),
            ..Mesh::default()
        }],
        spheres: vec![Sphere {
            center: DVec3::new(1.2, 0.5, 0.5),
            radius: 0.4,
            ..Sphere::default()
        }],
        ground: Some(Ground::default()),
        clips,
        ..Scene::default()
    };
    let mut most = 0;
    let cut: Clip = "x<0.6".parse().expect("a clip");
    for clips in [Vec::new(), vec![cut]] {
        let field = corpus::scene("pool", Kernel::Sextic, 400).field;
        let settings = FrameSettings {
            engine: Engine::Particles,
            ..FrameSettings::default()
        };
        let (mesh, _) = MeshSurface::build(&tetrahedron());
        let frame = Frame::build_with_meshes(&scene(clips), vec![field], vec![mesh], &settings)
            .expect("it is sound");
        let tracer = FrameTracer::upload(device, &frame, Takeover::Never).expect("it fits");
        let rays: Vec<Ray> = (0..900)
            .map(|i| {
                let (x, y) = (f64::from(i % 30) / 30.0, f64::from(i / 30) / 30.0);
                let origin = DVec3::new(-3.0, 0.2 + 0.7 * y, 2.0 - 3.0 * x);
                Ray::new(origin, DVec3::new(1.0, 0.1 - 0.1 * y, 0.9 * x - 0.5))
            })
            .collect();
        let mut scratch = Scratch::default();
        let mut ours = vec![
            vec![Crossing {
                t: 0.0,
                entering: true
            }];
            rays.len()
        ];
        (frame.crossings_by(&tracer, &rays, &mut ours, &mut scratch)).expect("the device works");
        let mut off = 0;
        for (ray, ours) in rays.iter().zip(&ours) {
            let mut theirs = Vec::new();
            frame.crossings(ray, &mut scratch, &mut theirs);
            most = most.max(theirs.len());
            let is_same = ours.len() == theirs.len()
                && (ours.iter().zip(&theirs))
                    .all(|(a, b)| a.entering == b.entering && (a.t - b.t).abs() < 1e-5);
            off += usize::from(!is_same);
        }
        // Rays that touch a surface may cross it for one and not for the other.
        assert!(off <= 2, "{off} lists differ");
    }
    assert!(most >= 6, "{most} crossings at most");
}
