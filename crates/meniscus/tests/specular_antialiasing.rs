//! Small highlights on a rough sea: with widened highlights one sample is closer to what many show, and
//! nothing is lost in the mean, nor made at silhouettes.

use meniscus::field::BlobField;
use meniscus::film::PlaneData;
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::DVec3;
use meniscus::particles::{Column, Particles};
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::{
    Background, BlobSettings, Color, IntegratorKind, IntegratorSettings, Light, Material,
    MaterialKind, Scene, Surface,
};

const SIZE: [u32; 2] = [40, 24];

/// From where the sea is seen, and towards the sun.
#[derive(Clone, Copy)]
struct View {
    eye: DVec3,
    sun: DVec3,
}

/// Highlights everywhere; a pixel is about a third of the particles' spacing.
const FROM_ABOVE: View = View {
    eye: DVec3::new(0.0, 40.0, 45.0),
    sun: DVec3::new(0.2, 1.0, -0.8),
};
/// Along the waves' crests, with the sun behind the eye: nothing shines but what faces it.
const AT_A_GLANCE: View = View {
    eye: DVec3::new(0.0, 8.0, 59.0),
    sun: DVec3::new(0.1, 0.3, 1.0),
};

/// A sea of particles with short waves that travel along x; `material` shines.
fn sea(material: Material, view: View, shutter_secs: [f64; 2]) -> Frame {
    const SIDE: i32 = 48;
    let mut positions = Vec::new();
    let mut velocities: Vec<f32> = Vec::new();
    for x in -SIDE..SIDE {
        for z in -SIDE..SIDE {
            for layer in 0..2 {
                let (x, z) = (f64::from(x), f64::from(z));
                let phase = 0.9 * x + 0.2 * (0.7 * z).sin();
                let height = 0.5 * phase.sin() + 0.3 * (0.8 * z).cos();
                positions.push(DVec3::new(x, height - f64::from(layer), z));
                velocities.extend([0.0, (-9.0 * phase.cos()) as f32, 0.0]);
            }
        }
    }
    let mut particles = Particles::from_positions(positions);
    particles
        .columns
        .push(Column::new("velocity", 3, velocities));
    let mut surface = Surface::from_file("");
    surface.radius = Some(0.5);
    surface.material = Some("sea".to_owned());
    let settings = surface.settings(&BlobSettings::default());
    let mut scene = Scene {
        surfaces: vec![surface],
        lights: vec![Light::sun(view.sun)],
        ..Scene::default()
    };
    scene.materials.insert("sea".to_owned(), material);
    let built = BlobField::from_moving_particles(&particles, &settings, shutter_secs, 1.0).unwrap();
    Frame::build(&scene, vec![built.field], &FrameSettings::default()).unwrap()
}

/// Green of all pixels.
fn picture(
    (frame, view): (&Frame, View),
    kind: IntegratorKind,
    spp: u32,
    specular_antialiasing: bool,
    shutter_secs: [f64; 2],
) -> Vec<f64> {
    let camera = Camera::new(view.eye, DVec3::ZERO, DVec3::Y, 0.12, SIZE).unwrap();
    let settings = RenderSettings {
        spp,
        shutter_secs,
        background: Background::Transparent,
        integrator: IntegratorSettings {
            kind,
            depth: 1,
            specular_antialiasing,
            ..IntegratorSettings::default()
        },
        ..RenderSettings::default()
    };
    let (progress, state) = (Progress::none(), RenderState::new());
    let (film, _) = CpuBackend
        .render(frame, &camera, &settings, &state, &progress)
        .unwrap();
    match film.plane_named("G") {
        Some(PlaneData::F32(values)) => values.into_iter().map(f64::from).collect(),
        other => panic!("{other:?}"),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean squared error of a picture.
fn error(picture: &[f64], reference: &[f64]) -> f64 {
    let squares = picture.iter().zip(reference).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>() / picture.len() as f64
}

fn shiny(kind: MaterialKind, roughness: f64) -> Material {
    Material {
        roughness: Some(roughness),
        ..Material::of(kind, Some(Color([0.6; 3])))
    }
}

#[test]
fn one_sample_is_closer_to_the_mean_of_many() {
    let still = [0.0; 2];
    for (kind, material, most) in [
        (IntegratorKind::Path, MaterialKind::Metal, 0.9),
        (IntegratorKind::Path, MaterialKind::Plastic, 0.9),
        (IntegratorKind::Shaded, MaterialKind::Glossy, 0.9),
    ] {
        let frame = sea(shiny(material, 0.25), FROM_ABOVE, still);
        let seen = (&frame, FROM_ABOVE);
        let reference = picture(seen, kind, 64, false, still);
        let plain = error(&picture(seen, kind, 1, false, still), &reference);
        let once = picture(seen, kind, 1, true, still);
        let filtered = error(&once, &reference);
        println!(
            "{kind:?} {material:?}: error {filtered:.3e} of {plain:.3e}, mean {:.4} of {:.4}",
            mean(&once),
            mean(&reference)
        );
        assert!(filtered < most * plain, "{kind:?}: {filtered} of {plain}");
        let bias = mean(&once) / mean(&reference) - 1.0;
        assert!(bias.abs() < 0.1, "{kind:?}: {bias}");
        // What the filter changes vanishes with the samples.
        let many = picture(seen, kind, 64, true, still);
        let left = (error(&many, &reference) / error(&once, &vec![0.0; once.len()])).sqrt();
        let bias = mean(&many) / mean(&reference) - 1.0;
        assert!(bias.abs() < 0.01 && left < 0.1, "{kind:?}: {bias}, {left}");
    }
}

#[test]
fn waves_that_turn_within_the_shutter_glitter_less() {
    let shutter = [-0.05, 0.05];
    let (kind, material) = (IntegratorKind::Path, shiny(MaterialKind::Metal, 0.2));
    let frame = sea(material, FROM_ABOVE, shutter);
    let seen = (&frame, FROM_ABOVE);
    let reference = picture(seen, kind, 64, false, shutter);
    let errors = [false, true].map(|filters| {
        let four = picture(seen, kind, 4, filters, shutter);
        error(&four, &reference)
    });
    println!("moving: error {:.3e} of {:.3e}", errors[1], errors[0]);
    assert!(errors[1] < 0.9 * errors[0], "{errors:?}");
}

#[test]
fn silhouettes_do_not_shine() {
    // As a screen shows it: what is too bright counts as white.
    let still = [0.0; 2];
    let kind = IntegratorKind::Whitted;
    let frame = sea(shiny(MaterialKind::Metal, 0.15), AT_A_GLANCE, still);
    let shown = |spp, filters| {
        let picture = picture((&frame, AT_A_GLANCE), kind, spp, filters, still);
        picture.into_iter().map(|g| g.min(1.0)).collect::<Vec<_>>()
    };
    let reference = shown(256, false);
    for spp in [1, 4] {
        let [plain, filtered] =
            [false, true].map(|filters| error(&shown(spp, filters), &reference));
        println!("at a glance, {spp}: error {filtered:.3e} of {plain:.3e}");
        assert!(filtered < 3.0 * plain, "{spp}: {filtered} of {plain}");
    }
}
