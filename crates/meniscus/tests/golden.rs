//! Small pictures that must not change unnoticed. `MENISCUS_UPDATE_GOLDEN=1 cargo test -p meniscus
//! --test golden` accepts new ones.

use meniscus::field::BlobField;
use meniscus::film::{BitDepth, Film, Pixels, Tone};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::DVec3;
use meniscus::particles::{Column, Particles};
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::{
    Background, BlobSettings, Color, Ground, IntegratorKind, Material, MaterialKind, Scene,
    Surface, Weights,
};
use meniscus_testing::image::{Budget, Picture, assert_golden};
use std::path::Path;

const SIZE: [u32; 2] = [96, 72];

/// A twisted string of balls beside a lone one, with a `speed` that rises along the string.
fn particles() -> Particles {
    let mut positions: Vec<DVec3> = (0..24)
        .map(|i| {
            let angle = f64::from(i) * 0.4;
            DVec3::new(angle.cos(), 0.08 * f64::from(i), angle.sin())
        })
        .collect();
    positions.push(DVec3::new(0.0, 0.3, 0.0));
    let speed: Vec<f32> = (0..positions.len()).map(|i| i as f32).collect();
    let mut particles = Particles::from_positions(positions);
    particles.columns.push(Column::new("speed", 1, speed));
    particles
}

/// A surface around [`particles`].
fn scene() -> Scene {
    let mut surface = Surface::from_file("");
    surface.radius = Some(0.25);
    surface.threshold = Some(0.2);
    surface.weights = Some(Weights::Unit);
    surface.attributes = vec!["speed".into()];
    Scene {
        surfaces: vec![surface],
        ..Scene::default()
    }
}

fn frame_of(scene: &Scene) -> Frame {
    let settings = scene.surfaces[0].settings(&BlobSettings::default());
    let field = BlobField::from_particles(&particles(), &settings).unwrap();
    Frame::build(scene, vec![field.field], &FrameSettings::default()).unwrap()
}

fn render(scene: &Scene, settings: &RenderSettings) -> Film {
    let frame = frame_of(scene);
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), SIZE).unwrap();
    let progress = Progress::none();
    let (film, _) = CpuBackend
        .render(&frame, &camera, settings, &RenderState::new(), &progress)
        .unwrap();
    film
}

fn picture(film: &Film) -> Picture {
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

fn check(name: &str, scene: &Scene, settings: &RenderSettings) {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.png"));
    assert_golden(
        &picture(&render(scene, settings)),
        &golden,
        Budget::default(),
    );
}

#[test]
fn clay_on_the_ground_before_the_sky() {
    let mut scene = scene();
    scene.ground = Some(Ground::default());
    check("ground", &scene, &RenderSettings::default());
}

#[test]
fn colour_by_attribute_before_a_colour() {
    let mut scene = scene();
    scene.surfaces[0].color_by = Some("speed".into());
    scene.ground = Some(Ground::default());
    let settings = RenderSettings {
        background: Background::Color("#205060".parse().unwrap()),
        ..RenderSettings::default()
    };
    check("attribute", &scene, &settings);
}

#[test]
fn one_sample_from_inside_the_fluid() {
    let mut scene = scene();
    scene.surfaces[0].radius = Some(0.8);
    scene.camera.eye = Some(DVec3::new(0.0, 0.3, 0.0));
    scene.camera.target = Some(DVec3::new(1.0, 0.8, 0.5));
    scene.camera.fov = 90.0;
    let settings = RenderSettings {
        spp: 1,
        ..RenderSettings::default()
    };
    check("inside", &scene, &settings);
}

#[test]
fn a_mirror_on_the_ground_by_a_tree_of_rays() {
    let mut scene = scene();
    scene.ground = Some(Ground::default());
    scene.surfaces[0].material = Some("mirror".into());
    let mirror = Material::of(MaterialKind::Mirror, Some(Color([0.9, 0.8, 0.7])));
    scene.materials.insert("mirror".into(), mirror);
    let mut settings = RenderSettings::default();
    settings.integrator.kind = IntegratorKind::Whitted;
    settings.integrator.depth = 4;
    check("mirror", &scene, &settings);
}

#[test]
fn ambient_occlusion_of_a_string_of_balls() {
    let mut settings = RenderSettings::default();
    settings.integrator.kind = IntegratorKind::Ao;
    check("occlusion", &scene(), &settings);
}
