//! Engine `peel`: both variants against the float64 oracle, and pictures beside those of the CPU.

use crate::common::device;
use crate::pictures::{check_budget, picture, settings as picture_settings};
use glam::{DAffine3, DVec3};
use meniscus::accel::Engine;
use meniscus::field::{BlobField, Motion};
use meniscus::frame::{Blobs, Frame, FrameSettings, Geometry, Instance, MeshSurface};
use meniscus::intersect::{BlobHit, Crossing, Scratch};
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::math::simd::Level;
use meniscus::mesh::TriangleMesh;
use meniscus::primitive::Shapes;
use meniscus::render::{Backend, CpuBackend, DeviceBackend, Progress, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::{Clipping, EngineSettings, Ground, PeelVariant, Scene, Surface};
use meniscus_gpu::{
    Device, GpuError, PeelField, PeelOptions, PeelTracer, PeelWork, Takeover, View,
};
use meniscus_testing::corpus;
use meniscus_testing::examine::{Question, Tracer, examine};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays;
use std::sync::Mutex;

const VARIANTS: [PeelVariant; 2] = [PeelVariant::Tiles, PeelVariant::Sprites];

/// Pixels of the cameras here.
const SIZE: [u32; 2] = [40, 32];

fn switches(peel: PeelVariant, clipping: Clipping) -> EngineSettings {
    EngineSettings {
        peel,
        clipping,
        ..EngineSettings::default()
    }
}

/// A field as one camera sees it; what the engine leaves open is answered by the CPU.
struct Peeled<'a> {
    blobs: &'a Blobs,
    field: PeelField<'a>,
    view: View,
    work: Mutex<PeelWork>,
}

impl<'a> Peeled<'a> {
    fn new(device: &'a Device, blobs: &'a Blobs, camera: &Camera, options: PeelOptions) -> Self {
        Self {
            blobs,
            field: PeelField::upload(device, blobs, options).expect("the field fits"),
            view: View::new(camera, &DAffine3::IDENTITY),
            work: Mutex::default(),
        }
    }

    fn work(&self) -> PeelWork {
        *self.work.lock().expect("no test panicked with it")
    }
}

impl Tracer for Peeled<'_> {
    fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        self.closest_many(std::slice::from_ref(ray), scratch)[0]
    }

    fn occluded(&self, _: &Ray, _: &mut Scratch) -> bool {
        panic!("the engine finds first crossings only")
    }

    fn crossings(&self, _: &Ray, _: &mut Scratch) -> Vec<Crossing> {
        panic!("the engine finds first crossings only")
    }

    fn closest_many(&self, rays: &[Ray], scratch: &mut Scratch) -> Vec<Option<BlobHit>> {
        let mut hits = vec![None; rays.len()];
        let mut left = Vec::new();
        let work = self
            .field
            .closest_many(&self.view, self.blobs, rays, &mut hits, &mut left)
            .expect("the device works");
        for index in left {
            hits[index] = self.blobs.closest(&rays[index], scratch);
        }
        *self.work.lock().expect("no test panicked with it") += work;
        hits
    }
}

/// The whole field from outside, from near, and from within.
fn cameras(field: &BlobField) -> Vec<Camera> {
    let oracle = Oracle::new(field);
    let (center, diagonal) = rays::extent(&oracle);
    let camera = |eye: DVec3, target: DVec3, fov: f64| {
        Camera::new(eye, target, DVec3::Y, fov.to_radians(), SIZE).expect("a camera")
    };
    let away = DVec3::new(0.3, 0.5, 1.0).normalize();
    let mut all = vec![
        camera(center + away * 1.2 * diagonal, center, 45.0),
        camera(
            center + away * 0.3 * diagonal,
            center - DVec3::X * 0.1 * diagonal,
            110.0,
        ),
    ];
    if let Some(&middle) = field.centers.first() {
        // Within a ball.
        let eye = field.origin + DVec3::from(middle.map(f64::from));
        all.push(camera(eye, eye + DVec3::new(0.2, 0.1, -1.0), 90.0));
    }
    all
}

/// One ray per pixel, its place on the film moved by `jitter` pixels at most.
fn camera_rays(camera: &Camera, jitter: f64) -> Vec<Ray> {
    let [width, height] = camera.size;
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    pixels
        .map(|[x, y]| {
            let turn = f64::from(x * 31 + y * 17);
            let film = [
                f64::from(x) + 0.5 + jitter * turn.sin(),
                f64::from(y) + 0.5 + jitter * (1.7 * turn).cos(),
            ];
            camera.ray(film)
        })
        .collect()
}

#[expect(clippy::print_stderr, reason = "how many rays went where")]
fn check(
    test: &str,
    scenes: &[corpus::Scene],
    variant: PeelVariant,
    options: PeelOptions,
    jitter: f64,
) {
    let Some(device) = device(test) else {
        return;
    };
    let (mut asked, mut left) = (0, 0);
    let mut problems = Vec::new();
    for scene in scenes {
        if !matches!(scene.field.shapes, Shapes::Balls(_)) {
            continue;
        }
        let oracle = Oracle::new(&scene.field);
        let settings = switches(variant, Clipping::Own);
        let blobs = Blobs::build_with(
            scene.field.clone(),
            Engine::Particles,
            settings,
            Level::new(),
        );
        for (number, camera) in cameras(&scene.field).iter().enumerate() {
            let peeled = Peeled::new(device, &blobs, camera, options);
            let rays = camera_rays(camera, jitter);
            let tally = examine(&peeled, &oracle, &rays, Question::ClosestTogether);
            if tally.real_errors() > 0 {
                problems.push(format!("{} camera {number}: {tally}", scene.name));
            }
            let work = peeled.work();
            asked += work.rays;
            left += work.left;
        }
    }
    eprintln!("{test}: {asked} rays, {left} of them left to the CPU");
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(asked > 5000, "only {asked} rays");
}

/// Every kind of set with one kernel each.
fn some_scenes() -> Vec<corpus::Scene> {
    let kinds = corpus::KINDS.iter().enumerate();
    kinds
        .map(|(i, kind)| corpus::scene(kind, Kernel::ALL[i % Kernel::ALL.len()], 400))
        .collect()
}

#[test]
fn tiles_agree_with_the_oracle() {
    check(
        "tiles_agree_with_the_oracle",
        &some_scenes(),
        PeelVariant::Tiles,
        PeelOptions::default(),
        0.0,
    );
}

#[test]
fn sprites_agree_with_the_oracle() {
    check(
        "sprites_agree_with_the_oracle",
        &some_scenes(),
        PeelVariant::Sprites,
        PeelOptions::default(),
        0.0,
    );
}

/// Several rays of one pixel, and none of the next; balls at one place, on a lattice, far away, of sizes a
/// million-fold apart.
#[test]
fn evil_sets_and_scattered_rays() {
    let scenes = corpus::evil();
    for variant in VARIANTS {
        let test = "evil_sets_and_scattered_rays";
        check(test, &scenes, variant, PeelOptions::default(), 1.4);
    }
}

/// Lists that do not fit: tiles are asked again in smaller rounds, and rays that still find no room are
/// left to others.
#[test]
fn little_room_loses_nothing() {
    let scenes = ["pool", "mixed"].map(|kind| corpus::scene(kind, Kernel::Sextic, 400));
    for variant in VARIANTS {
        let options = PeelOptions {
            pairs: Some(300),
            capacity: Some(8),
        };
        check("little_room_loses_nothing", &scenes, variant, options, 0.0);
    }
}

/// What is claimed takes a million rays: `cargo test -p meniscus-gpu --test device -- --ignored`.
#[test]
#[ignore = "takes minutes: run by benches/gpu.sh"]
fn a_million_rays_of_cameras() {
    let scenes = corpus::suite();
    for variant in VARIANTS {
        for jitter in [0.0, 0.1, 0.2, 0.3, 0.4] {
            let test = "a_million_rays_of_cameras";
            check(test, &scenes, variant, PeelOptions::default(), jitter);
        }
    }
}

/// The paper's rules lose surfaces; how many is counted, and that it is few.
#[test]
fn errors_of_the_paper_s_rules() {
    let Some(device) = device("errors_of_the_paper_s_rules") else {
        return;
    };
    let (mut asked, mut wrong) = (0, 0);
    for kind in ["pool", "scattered", "mixed"] {
        let scene = corpus::scene(kind, Kernel::Wyvill, 400);
        let oracle = Oracle::new(&scene.field);
        let settings = switches(PeelVariant::Sprites, Clipping::Kanamori);
        let blobs = Blobs::build_with(
            scene.field.clone(),
            Engine::Particles,
            settings,
            Level::new(),
        );
        let camera = &cameras(&scene.field)[0];
        let peeled = Peeled::new(device, &blobs, camera, PeelOptions::default());
        let rays = camera_rays(camera, 0.0);
        let tally = examine(&peeled, &oracle, &rays, Question::ClosestTogether);
        eprintln!("{kind}: {tally}");
        asked += rays.len();
        wrong += tally.real_errors();
    }
    // Accuracy of t alone makes most of them: they stop at a thousandth of an interval.
    eprintln!("{wrong} of {asked} rays are wrong by the paper's rules");
    assert!(wrong > 0 && wrong * 2 < asked, "{wrong} of {asked}");
}

#[test]
fn the_same_rays_get_the_same_answers() {
    let Some(device) = device("the_same_rays_get_the_same_answers") else {
        return;
    };
    let scene = corpus::scene("pool", Kernel::Sextic, 400);
    let camera = &cameras(&scene.field)[0];
    for variant in VARIANTS {
        let settings = switches(variant, Clipping::Own);
        let blobs = Blobs::build_with(
            scene.field.clone(),
            Engine::Particles,
            settings,
            Level::new(),
        );
        let hits = || {
            let peeled = Peeled::new(device, &blobs, camera, PeelOptions::default());
            peeled.closest_many(&camera_rays(camera, 0.3), &mut Scratch::default())
        };
        assert_eq!(hits(), hits(), "{variant:?}");
    }
}

#[test]
fn what_cannot_be_peeled_is_said() {
    let Some(device) = device("what_cannot_be_peeled_is_said") else {
        return;
    };
    let scene = corpus::scene("ellipsoids", Kernel::Sextic, 30);
    let blobs = Blobs::build(scene.field, Engine::Particles, Level::new());
    let refused = PeelField::upload(device, &blobs, PeelOptions::default()).err();
    assert_eq!(refused, Some(GpuError::Unfit { what: "ellipsoids" }));
    let mut scene = corpus::scene("pool", Kernel::Sextic, 30);
    let zeros = vec![[0.0; 3]; scene.field.len()];
    scene.field.motion = Some(Motion {
        velocities: zeros.clone(),
        half_accelerations: zeros,
        velocity_gradients: Vec::new(),
        shutter: [-0.1, 0.1],
    });
    let blobs = Blobs::build(scene.field, Engine::Particles, Level::new());
    let refused = PeelField::upload(device, &blobs, PeelOptions::default()).err();
    assert!(refused.is_some_and(|error| error.to_string().contains("move")));
}

/// A tetrahedron that reaches through the particles.
fn mesh() -> MeshSurface {
    let corners = [
        [0.5, 0.2, 1.2],
        [1.1, 0.3, 0.4],
        [-0.1, 0.3, 0.4],
        [0.5, 1.2, 0.5],
    ];
    let corners = corners.map(DVec3::from_array).to_vec();
    let faces: [&[u64]; 4] = [&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]];
    let (mesh, _) =
        TriangleMesh::from_polygons(corners, Vec::new(), faces.into_iter()).expect("it is sound");
    MeshSurface::build(&mesh).0
}

/// Pictures with everything beside: the ground, a mesh that hides and is hidden, whether it is asked about
/// before the particles or after them, and the same particles a second time, turned and stretched.
#[test]
fn pictures_are_those_of_the_cpu() {
    let Some(device) = device("pictures_are_those_of_the_cpu") else {
        return;
    };
    let scene = Scene {
        surfaces: vec![Surface::from_file("")],
        ground: Some(Ground::default()),
        ..Scene::default()
    };
    for variant in VARIANTS {
        for mesh_first in [false, true] {
            let field = corpus::scene("pool", Kernel::Sextic, 400).field;
            let settings = FrameSettings {
                engine: Engine::Particles,
                switches: switches(variant, Clipping::Own),
                ..FrameSettings::default()
            };
            let mut frame = Frame::build(&scene, vec![field], &settings).expect("it is sound");
            let of_mesh = frame.geometries.len() as u32;
            frame.geometries.push(Geometry::Mesh(Box::new(mesh())));
            let blobs = frame.instances[0].clone();
            let turned = DAffine3::from_translation(DVec3::new(1.2, 0.4, -0.5))
                * DAffine3::from_rotation_y(0.7)
                * DAffine3::from_scale(DVec3::new(0.6, 1.3, 0.8));
            let beside = [
                Instance::new(of_mesh, DAffine3::IDENTITY, blobs.material),
                Instance::new(blobs.geometry, turned, blobs.material),
            ];
            let place = if mesh_first { 0 } else { frame.instances.len() };
            frame.instances.splice(place..place, beside);
            let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), [96, 72])
                .expect("the camera sees something");
            let tracer = PeelTracer::upload(device, &frame, &camera, Takeover::Never)
                .expect("the frame fits");
            let ours = DeviceBackend {
                name: "gpu",
                tracer: &tracer,
                stages: None,
            };
            let rendered = |backend: &dyn Backend| {
                let state = RenderState::new();
                let progress = Progress::none();
                let done = backend.render(
                    &frame,
                    &camera,
                    &picture_settings(&scene),
                    &state,
                    &progress,
                );
                picture(&done.expect("nothing fails").0)
            };
            check_budget(
                &format!("{variant:?}, mesh first: {mesh_first}"),
                &rendered(&ours),
                &rendered(&CpuBackend),
            );
            let work = tracer.work();
            assert!(work.rays > 50_000, "{work:?}");
            assert!(work.left * 1000 < work.rays, "{work:?}");
        }
    }
}
