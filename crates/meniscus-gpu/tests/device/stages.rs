//! Pictures shaded by the device's stages beside those of the CPU.

use crate::common::device;
use crate::pictures::{check_budget, picture};
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::field::BlobField;
use meniscus::film::{ChannelSet, Film, PlaneData};
use meniscus::frame::{Environment, Frame, FrameSettings, Light};
use meniscus::kernel::Kernel;
use meniscus::render::{
    Backend, CpuBackend, DeviceBackend, Progress, RenderSettings, RenderState, RenderStats, Staging,
};
use meniscus::scene::camera::Camera;
use meniscus::scene::{Background, IntegratorKind, Plane, Scene};
use meniscus::shade::{MOST_SURFACES, Unstaged, frame_attributes};
use meniscus_gpu::{Device, FrameTracer, Takeover};
use meniscus_testing::corpus;
use meniscus_testing::image::Picture;
use std::sync::Arc;

const SIZE: [u32; 2] = [64, 48];

/// A bright window in a dim room.
fn image() -> Light {
    let (width, height) = (32, 16);
    let texels = (0..width * height).map(|i| match (i % width, i / width) {
        (6..9, 3..6) => [9.0, 8.0, 6.0],
        (_, y) => [0.3, 0.35, 0.4].map(|c: f32| c * (1.0 - y as f32 / height as f32)),
    });
    let axes = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
    Light::Environment {
        environment: Arc::new(Environment::new(width, texels.collect(), axes, 0.3)),
        scale: [1.0; 3],
    }
}

/// A scene's text, with particles of a set of the corpus as its surface.
pub(crate) fn frame_of(text: &str, set: &str) -> (Scene, Frame) {
    frame_with(text, corpus::scene(set, Kernel::Sextic, 400).field)
}

/// A scene's text with a field as its surface.
pub(crate) fn frame_with(text: &str, field: BlobField) -> (Scene, Frame) {
    let scene = meniscus::scene::file::parse(text, "test").expect("the scene is sound");
    let settings = FrameSettings {
        engine: Engine::Cells,
        ..FrameSettings::default()
    };
    let frame = Frame::build(&scene, vec![field], &settings).expect("the scene is sound");
    (scene, frame)
}

fn settings(scene: &Scene, frame: &Frame) -> RenderSettings {
    RenderSettings {
        spp: scene.film.spp,
        integrator: scene.integrator.clone(),
        background: scene.film.background.unwrap_or_default(),
        shutter_secs: scene.motion.shutter_secs(),
        channels: Arc::new(
            ChannelSet::new(&["all".to_owned()], &frame_attributes(frame))
                .expect("all channels are there"),
        ),
        ..RenderSettings::default()
    }
}

fn rendered(backend: &dyn Backend, scene: &Scene, frame: &Frame) -> (Film, RenderStats) {
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), SIZE)
        .expect("the camera sees something");
    let state = RenderState::new();
    (backend.render(
        frame,
        &camera,
        &settings(scene, frame),
        &state,
        &Progress::none(),
    ))
    .expect("the device works")
}

/// Samples of the whole picture, and how many of them the processor did.
fn on_device(device: &Device, scene: &Scene, frame: &Frame) -> (Film, RenderStats, [u64; 2]) {
    let tracer = FrameTracer::upload(device, frame, Takeover::Never).expect("the frame fits");
    let backend = DeviceBackend {
        name: "gpu",
        tracer: &tracer,
        stages: Some(&tracer),
    };
    let (film, stats) = rendered(&backend, scene, frame);
    match stats.staging {
        Some(Staging::Device { samples, on_cpu }) => (film, stats, [samples, on_cpu]),
        staging => panic!("shaded elsewhere: {staging:?}"),
    }
}

pub(crate) fn check(device: &Device, what: &str, text: &str, set: &str, lights: &[Light]) {
    let field = corpus::scene(set, Kernel::Sextic, 400).field;
    check_field(device, what, text, field, lights);
}

/// The pictures of `field` as the surface of a scene's text, by the device's stages and by the CPU.
pub(crate) fn check_field(
    device: &Device,
    what: &str,
    text: &str,
    field: BlobField,
    lights: &[Light],
) -> Picture {
    let (scene, mut frame) = frame_with(text, field);
    frame.lights.extend_from_slice(lights);
    check_frame(device, what, &scene, &frame)
}

#[expect(clippy::print_stderr, reason = "how many samples went where")]
pub(crate) fn check_frame(device: &Device, what: &str, scene: &Scene, frame: &Frame) -> Picture {
    let (ours, stats, [samples, on_cpu]) = on_device(device, scene, frame);
    eprintln!("{what}: {samples} samples, {on_cpu} by the processor");
    let pixels = u64::from(SIZE[0] * SIZE[1]);
    assert_eq!(samples, pixels * u64::from(scene.film.spp), "{what}");
    assert!(on_cpu * 5 < samples, "{what}: {on_cpu} of {samples}");
    let (theirs, expected) = rendered(&CpuBackend, scene, frame);
    check_budget(what, &picture(&ours), &picture(&theirs));
    // Both went the same ways.
    let counts = [stats.rays, expected.rays].map(|rays| {
        [
            rays.primary,
            rays.shadow,
            rays.reflection,
            rays.refraction,
            rays.ambient_occlusion,
            rays.diffuse,
        ]
    });
    for (ours, theirs) in counts[0].into_iter().zip(counts[1]) {
        let off = ours.abs_diff(theirs);
        // Rays of samples that the processor did again count twice.
        assert!(off <= theirs / 500 + 8 * on_cpu, "{what}: {counts:?}");
    }
    for name in ["id", "surface"] {
        let planes = [&ours, &theirs].map(|film| match film.plane_named(name) {
            Some(PlaneData::U32(plane)) => plane,
            other => panic!("{name}: {other:?}"),
        });
        let differ = planes[0].iter().zip(&planes[1]).filter(|(a, b)| a != b);
        assert!(differ.count() * 250 < pixels as usize, "{what}: {name}");
    }
    let attributes = (frame.blobs()).flat_map(|blobs| &blobs.field.attributes);
    let attributes = attributes.map(|attribute| match attribute.components {
        1 => attribute.name.clone(),
        _ => format!("{}.X", attribute.name),
    });
    let names = ["Z", "P.X", "N.X", "N.Y"].map(str::to_owned);
    for name in names.into_iter().chain(attributes) {
        let planes = [&ours, &theirs].map(|film| match film.plane_named(&name) {
            Some(PlaneData::F32(plane)) => plane,
            other => panic!("{name}: {other:?}"),
        });
        let differ = planes[0].iter().zip(&planes[1]).filter(|(a, b)| {
            let off = (*a - *b).abs();
            off > 1e-3 * b.abs().max(1.0)
        });
        assert!(differ.count() * 250 < pixels as usize, "{what}: {name}");
    }
    picture(&ours)
}

pub(crate) const SURFACE: &str = "[[surface]]\nfile = \"set.npy\"\n";
pub(crate) const SUN_AND_SKY: &str =
    "[[light]]\ntype = \"sun\"\ndirection = [1, 2, 1.5]\n[[light]]\ntype = \"sky\"\n";
pub(crate) const LAMPS: &str = "
[[light]]
type = \"point\"
position = [1.5, 2, 1]
intensity = 2
[[light]]
type = \"sphere\"
position = [-1, 2, 0.5]
radius = 0.3
intensity = 8
[[light]]
type = \"rectangle\"
position = [0.5, 2.5, -1]
edges = [[0.8, 0, 0], [0, 0, 0.8]]
intensity = 6
[[light]]
type = \"constant\"
intensity = 0.1
";
/// A ball of every kind of look beside the particles.
pub(crate) const BALLS: &str = "
[material.metal]
type = \"metal\"
roughness = 0.3
[material.mirror]
type = \"mirror\"
[material.coat]
type = \"plastic\"
color = [0.7, 0.2, 0.1]
roughness = 0.25
[material.froth]
type = \"foam\"
[material.glass]
type = \"glass\"
absorption = [0.4, 0.8, 0.9]
absorption_depth = 0.5
[material.frosted]
type = \"glass\"
roughness = 0.4
[[sphere]]
center = [1.35, 0.3, 0.9]
radius = 0.3
material = \"metal\"
[[sphere]]
center = [-0.35, 0.3, 0.9]
radius = 0.3
material = \"mirror\"
[[sphere]]
center = [1.35, 0.9, 0.3]
radius = 0.3
material = \"coat\"
[[sphere]]
center = [-0.35, 0.9, 0.3]
radius = 0.3
material = \"froth\"
[[sphere]]
center = [0.2, 0.3, 1.4]
radius = 0.25
material = \"glass\"
[[sphere]]
center = [0.85, 0.3, 1.4]
radius = 0.25
material = \"frosted\"
[ground]
";

pub(crate) fn with(integrator: &str, spp: u32, parts: &[&str]) -> String {
    format!(
        "[integrator]\n{integrator}\n[film]\nspp = {spp}\n{}",
        parts.concat()
    )
}

#[test]
fn shaded_scenes_are_those_of_the_cpu() {
    let Some(device) = device("shaded_scenes_are_those_of_the_cpu") else {
        return;
    };
    let shaded = |parts: &[&str]| with("type = \"shaded\"", 4, parts);
    let ground = "[ground]\n";
    check(device, "sun", &shaded(&[SURFACE, ground]), "pool", &[]);
    let balls = shaded(&[SURFACE, LAMPS, BALLS]);
    check(device, "lamps and balls", &balls, "mixed", &[]);
    check(
        device,
        "image",
        &shaded(&[SURFACE, SUN_AND_SKY]),
        "ellipsoids",
        &[image()],
    );
    let inside = "[camera]\neye = [0.5, 0.5, 0.5]\ntarget = [0.6, 0.9, 0.2]\n";
    check(
        device,
        "from inside",
        &shaded(&[SURFACE, ground, inside]),
        "pool",
        &[],
    );
    let clear = "background = \"transparent\"\n";
    let transparent = shaded(&[clear, SURFACE, ground]);
    check(device, "transparent", &transparent, "pool", &[]);
}

#[test]
fn ambient_occlusion_is_that_of_the_cpu() {
    let Some(device) = device("ambient_occlusion_is_that_of_the_cpu") else {
        return;
    };
    let open = with("type = \"ao\"\nsamples = 5", 4, &[SURFACE, BALLS]);
    check(device, "ao", &open, "pool", &[]);
    let near = with("type = \"ao\"\ndistance = 0.2", 16, &[SURFACE]);
    check(device, "ao up to a distance", &near, "mixed", &[]);
}

#[test]
fn paths_are_those_of_the_cpu() {
    let Some(device) = device("paths_are_those_of_the_cpu") else {
        return;
    };
    let path = |more: &str, parts: &[&str]| with(&format!("type = \"path\"\n{more}"), 4, parts);
    let plain = path("", &[SURFACE, SUN_AND_SKY, "[ground]\n"]);
    check(device, "path", &plain, "pool", &[]);
    let balls = path("clamp = 20", &[SURFACE, LAMPS, BALLS]);
    check(device, "path among balls", &balls, "mixed", &[]);
    let image_alone = path("depth = 3", &[SURFACE, SUN_AND_SKY]);
    check(
        device,
        "path under an image",
        &image_alone,
        "ellipsoids",
        &[image()],
    );
    let water = "material = \"pool\"\n[material.pool]\ntype = \"water\"\n";
    let sea = path("", &[SURFACE, water, SUN_AND_SKY, "[ground]\n"]);
    check(device, "path in water", &sea, "pool", &[]);
    let straight = path("caustics = false", &[SURFACE, water, LAMPS, BALLS]);
    check(device, "path without caustics", &straight, "mixed", &[]);
    let bubble = "material = \"film\"\n[material.film]\ntype = \"glass\"\nthin = true\n";
    let sheets = path("", &[SURFACE, bubble, SUN_AND_SKY, "[ground]\n"]);
    check(device, "path through sheets", &sheets, "mixed", &[]);
}

#[test]
fn trees_are_those_of_the_cpu() {
    let Some(device) = device("trees_are_those_of_the_cpu") else {
        return;
    };
    let whitted = |parts: &[&str]| with("type = \"whitted\"\ndepth = 5", 1, parts);
    let balls = whitted(&[SURFACE, LAMPS, BALLS]);
    check(device, "whitted among balls", &balls, "mixed", &[]);
    let water = "material = \"pool\"\n[material.pool]\ntype = \"water\"\n";
    let sea = whitted(&[SURFACE, water, SUN_AND_SKY, "[ground]\n"]);
    check(device, "whitted in water", &sea, "pool", &[]);
    let bubble = "material = \"film\"\n[material.film]\ntype = \"glass\"\nthin = true\n";
    let sheets = whitted(&[SURFACE, bubble, SUN_AND_SKY, "[ground]\n"]);
    check(device, "whitted through sheets", &sheets, "mixed", &[]);
}

/// Open surfaces and their caps.
#[test]
fn cuts_are_those_of_the_cpu() {
    let Some(device) = device("cuts_are_those_of_the_cpu") else {
        return;
    };
    let cut = "[[clip]]\npoint = [0.8, 0, 0]\nnormal = [1, 0, 0.3]\n";
    let corner = "[[clip]]\npoint = [0, 0.7, 0]\nnormal = [0.1, 1, 0]\n";
    let water = "material = \"pool\"\n[material.pool]\ntype = \"water\"\n";
    let open = with("type = \"shaded\"", 4, &[SURFACE, LAMPS, BALLS, cut]);
    check(device, "a cut", &open, "pool", &[]);
    let inside = "[camera]\neye = [0.5, 0.5, 0.5]\ntarget = [0.9, 0.6, 0.5]\n";
    let inside = with("type = \"ao\"", 4, &[SURFACE, cut, inside]);
    check(device, "a cut from inside", &inside, "pool", &[]);
    let twice = with(
        "type = \"path\"\ndepth = 3",
        4,
        &[SURFACE, LAMPS, BALLS, cut, corner],
    );
    check(device, "a corner cut away", &twice, "mixed", &[]);
    let sea = with(
        "type = \"whitted\"",
        1,
        &[SURFACE, water, SUN_AND_SKY, "[ground]\n", cut],
    );
    check(device, "water cut open", &sea, "pool", &[]);
}

/// The same picture again, and the same from parts of it.
#[test]
fn pictures_are_the_same_every_time_and_in_parts() {
    let Some(device) = device("pictures_are_the_same_every_time_and_in_parts") else {
        return;
    };
    let text = with("type = \"path\"", 4, &[SURFACE, SUN_AND_SKY, "[ground]\n"]);
    let (scene, frame) = frame_of(&text, "pool");
    let (first, ..) = on_device(device, &scene, &frame);
    let (second, ..) = on_device(device, &scene, &frame);
    assert!(first == second);
    let tracer = FrameTracer::upload(device, &frame, Takeover::Never).expect("the frame fits");
    let backend = DeviceBackend {
        name: "gpu",
        tracer: &tracer,
        stages: Some(&tracer),
    };
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), SIZE)
        .expect("the camera sees something");
    let mut merged = Film::new(
        SIZE,
        meniscus::film::Region::full(SIZE[0], SIZE[1]),
        settings(&scene, &frame).channels,
        Background::default(),
    )
    .expect("it fits");
    for (x, width) in [(0, 23), (23, 41)] {
        for samples in [0..1, 1..4] {
            let part = RenderSettings {
                region: Some(meniscus::film::Region {
                    x,
                    y: 0,
                    width,
                    height: SIZE[1],
                }),
                samples: Some(samples),
                ..settings(&scene, &frame)
            };
            let (film, _) = backend
                .render(
                    &frame,
                    &camera,
                    &part,
                    &RenderState::new(),
                    &Progress::none(),
                )
                .expect("the device works");
            merged.merge(&film).expect("it is a part");
        }
    }
    assert!(merged == first);
}

/// What stages do not know is shaded by the processor, and it is said why.
#[test]
fn the_processor_shades_what_stages_do_not_know() {
    let Some(device) = device("the_processor_shades_what_stages_do_not_know") else {
        return;
    };
    let mut scene = frame_of(&with("", 1, &[SURFACE]), "pool").0;
    scene.integrator.kind = IntegratorKind::Shaded;
    scene.planes = vec![Plane::default(); MOST_SURFACES];
    let field = corpus::scene("pool", Kernel::Sextic, 200).field;
    let frame = Frame::build(&scene, vec![field], &FrameSettings::default()).expect("sound");
    let tracer = FrameTracer::upload(device, &frame, Takeover::Never).expect("the frame fits");
    let backend = DeviceBackend {
        name: "gpu",
        tracer: &tracer,
        stages: Some(&tracer),
    };
    let (_, stats) = rendered(&backend, &scene, &frame);
    match stats.staging {
        Some(Staging::Processor(why)) => {
            assert_eq!(why, Unstaged::ManySurfaces);
        }
        staging => panic!("{staging:?}"),
    }
}
