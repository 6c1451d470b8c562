//! Pictures with the blobs traced on the device beside those of the CPU, and what becomes of them when the
//! device is removed.

use crate::common::device;
use meniscus::accel::Engine;
use meniscus::film::{BitDepth, Film, Pixels, Tone};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::kernel::Kernel;
use meniscus::math::DVec3;
use meniscus::render::{
    Backend, CpuBackend, DeviceBackend, Progress, RenderError, RenderSettings, RenderState,
};
use meniscus::scene::camera::Camera;
use meniscus::scene::{
    Clip, Ground, IntegratorKind, Material, MaterialKind, Scene, Sphere, Surface,
};
use meniscus_gpu::{AdapterChoice, Device, FrameTracer, OpenOptions, Takeover};
use meniscus_testing::corpus;
use meniscus_testing::image::{Budget, Picture};

const SIZE: [u32; 2] = [96, 72];

pub(crate) fn picture(film: &Film) -> Picture {
    let image = film.develop(Tone::default(), BitDepth::Eight);
    let Pixels::Eight(values) = &image.pixels else {
        panic!("8 bits were asked for");
    };
    let rgb = values.chunks_exact(image.components);
    Picture {
        width: image.width as usize,
        height: image.height as usize,
        pixels: rgb.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(),
    }
}

pub(crate) fn settings(scene: &Scene) -> RenderSettings {
    RenderSettings {
        spp: 4,
        integrator: scene.integrator.clone(),
        ..RenderSettings::default()
    }
}

/// A frame of a set of the corpus, on the ground, for engine `cells`.
fn frame_of(kind: &str, scene: &Scene) -> Frame {
    let scene = Scene {
        surfaces: match &scene.surfaces[..] {
            [] => vec![Surface::from_file("")],
            given => given.to_vec(),
        },
        ground: Some(Ground::default()),
        ..scene.clone()
    };
    let field = corpus::scene(kind, Kernel::Sextic, 400).field;
    let settings = FrameSettings {
        engine: Engine::Cells,
        ..FrameSettings::default()
    };
    Frame::build(&scene, vec![field], &settings).expect("the scene is sound")
}

fn rendered(backend: &dyn Backend, frame: &Frame, scene: &Scene) -> Result<Film, RenderError> {
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), SIZE)
        .expect("the camera sees something");
    let state = RenderState::new();
    let (film, _) = backend.render(frame, &camera, &settings(scene), &state, &Progress::none())?;
    Ok(film)
}

/// The picture of the device is that of the CPU within the golden pictures' budget.
fn check_same(device: &Device, kind: &str, scene: &Scene) {
    let frame = frame_of(kind, scene);
    let tracer = FrameTracer::upload(device, &frame, Takeover::Never).expect("the frame fits");
    let backend = DeviceBackend {
        name: "gpu",
        tracer: &tracer,
        stages: Some(&tracer),
    };
    let ours = picture(&rendered(&backend, &frame, scene).expect("the device works"));
    let theirs = picture(&rendered(&CpuBackend, &frame, scene).expect("the CPU works"));
    assert!(tracer.work().rays > 10_000, "{kind}: {:?}", tracer.work());
    check_budget(kind, &ours, &theirs);
}

pub(crate) fn check_budget(what: &str, ours: &Picture, theirs: &Picture) {
    let budget = Budget::default();
    let difference = ours.difference(theirs, budget.channel);
    assert!(
        difference.pixels <= budget.pixels && difference.mean <= budget.mean,
        "{what}: {difference:?}"
    );
    let dark = theirs.pixels.iter().filter(|p| p[0] < 250).count();
    assert!(dark > 500, "{what}: hardly anything is seen");
}

#[test]
fn pictures_are_those_of_the_cpu() {
    let Some(device) = device("pictures_are_those_of_the_cpu") else {
        return;
    };
    for kind in corpus::KINDS {
        check_same(device, kind, &Scene::default());
    }
}

/// Everything that is not a blob is the CPU's: a ball stands beside the particles, a plane cuts both.
#[test]
fn company_and_cuts_are_kept() {
    let Some(device) = device("company_and_cuts_are_kept") else {
        return;
    };
    let scene = Scene {
        spheres: vec![Sphere {
            center: DVec3::new(0.9, 0.9, 0.9),
            radius: 0.5,
            ..Sphere::default()
        }],
        clips: vec!["x<0.6".parse::<Clip>().expect("a clip")],
        ..Scene::default()
    };
    check_same(device, "pool", &scene);
}

/// Integrators ask the device bounce by bounce, and draw the same random numbers.
#[test]
fn integrators_see_the_same() {
    let Some(device) = device("integrators_see_the_same") else {
        return;
    };
    let mut glass = Scene::default();
    let material = Material {
        kind: MaterialKind::Glass,
        ..Material::default()
    };
    glass.materials.insert("glass".to_owned(), material);
    glass.surfaces = vec![Surface {
        material: Some("glass".to_owned()),
        ..Surface::from_file("")
    }];
    let others = [
        IntegratorKind::Whitted,
        IntegratorKind::Ao,
        IntegratorKind::Path,
    ];
    for kind in others {
        for (name, scene) in [("pool", &Scene::default()), ("mixed", &glass)] {
            let mut scene = scene.clone();
            scene.integrator.kind = kind;
            check_same(device, name, &scene);
        }
    }
}

/// A device that goes away after `batches`.
fn doomed(batches: u64) -> Option<Device> {
    device("a device is removed")?;
    let options = OpenOptions {
        choice: AdapterChoice::CardOrSoftware,
        lose_after: Some(batches),
    };
    Some(Device::open(options).expect("it opened before"))
}

#[test]
fn the_cpu_takes_over_from_a_lost_device() {
    let scene = Scene::default();
    let frame = frame_of("pool", &scene);
    let expected = picture(&rendered(&CpuBackend, &frame, &scene).expect("the CPU works"));
    // 27,648 samples are two waves at least, of two rounds each at least.
    for batches in [0, 1, 3] {
        let Some(device) = doomed(batches) else {
            return;
        };
        let tracer = match FrameTracer::upload(&device, &frame, Takeover::ByCpu) {
            Ok(tracer) => tracer,
            Err(error) => panic!("{error}"),
        };
        let backend = DeviceBackend {
            name: "gpu",
            tracer: &tracer,
            stages: Some(&tracer),
        };
        let film = rendered(&backend, &frame, &scene).expect("the CPU takes over");
        check_budget("after a loss", &picture(&film), &expected);
        let error = tracer.lost().expect("the device was lost").to_string();
        assert!(error.contains("was lost"), "{error}");
        assert!(device.is_lost());
    }
}

#[test]
fn without_takeover_a_lost_device_is_an_error() {
    let Some(device) = doomed(1) else {
        return;
    };
    let scene = Scene::default();
    let frame = frame_of("pool", &scene);
    let tracer = FrameTracer::upload(&device, &frame, Takeover::Never).expect("the frame fits");
    let backend = DeviceBackend {
        name: "gpu",
        tracer: &tracer,
        stages: Some(&tracer),
    };
    match rendered(&backend, &frame, &scene) {
        Err(RenderError::Device(error)) => {
            assert!(error.to_string().contains("was lost"), "{error}");
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("there is a film without a device"),
    }
    // And the next frame is refused at once.
    assert!(FrameTracer::upload(&device, &frame, Takeover::Never).is_err());
}
