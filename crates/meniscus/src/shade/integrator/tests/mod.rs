//! Integrators against closed forms and furnaces: what both kinds of test stand on.

mod antialias;
mod closed_forms;
mod contacts;
mod energy;
mod eye;

use super::*;
use crate::field::{BlobField, FieldAttribute, Search};
use crate::frame::{FrameSettings, Light};
use crate::intersect::Scratch;
use crate::kernel::Kernel;
use crate::math::ray::Ray;
use crate::primitive::Shapes;
use crate::scene::{Color, Ground, Instance, Material, MaterialKind, Plane, Scene, Surface};
use std::f64::consts::{FRAC_PI_2, PI};

/// A ball of radius `radius` around the origin; its attribute `dye` is 0.25.
fn ball(radius: f64) -> BlobField {
    // Quartic, T = 0.25: q = 1/2 on the surface.
    let support = radius * 2.0_f64.sqrt();
    BlobField {
        kernel: Kernel::Quartic,
        threshold: 0.25,
        origin: DVec3::ZERO,
        centers: vec![[0.0; 3]],
        shapes: Shapes::Balls(vec![support as f32]),
        weights: vec![1.0],
        rows: vec![0],
        motion: None,
        attributes: vec![FieldAttribute {
            name: "dye".to_owned(),
            components: 1,
            data: vec![0.25],
        }],
        spacing: radius as f32,
        search: Search::default(),
    }
}

fn named(surface: &str, material: Material, scene: &mut Scene) {
    scene.materials.insert(surface.to_owned(), material);
    scene.surfaces.push(Surface {
        name: Some(surface.to_owned()),
        material: Some(surface.to_owned()),
        ..Surface::default()
    });
}

/// A ball of a material in a constant light of 1.
fn furnace(material: Material, radius: f64) -> Frame {
    let mut scene = Scene::default();
    named("ball", material, &mut scene);
    lit(&scene, vec![ball(radius)])
}

fn lit(scene: &Scene, fields: Vec<BlobField>) -> Frame {
    let mut frame = Frame::build(scene, fields, &FrameSettings::default()).unwrap();
    frame.lights = vec![Light::Constant { radiance: [1.0; 3] }];
    frame
}

fn path_settings(depth: u32) -> ShadeSettings {
    ShadeSettings {
        integrator: IntegratorSettings {
            kind: IntegratorKind::Path,
            depth,
            ..IntegratorSettings::default()
        },
        ..ShadeSettings::default()
    }
}

/// What one ray alone sees.
fn see(
    shader: &Shader<'_>,
    ray: &Ray,
    sampler: &mut PixelSampler,
    scratch: &mut ShadeScratch,
) -> Seen {
    let mut eye = EyeRays {
        rays: vec![*ray],
        ..EyeRays::default()
    };
    let Ok(()) = shader.find_first(&crate::intersect::OnCpu, &mut eye, scratch);
    shader.sample(&eye, 0, sampler, scratch)
}

/// Mean, and standard error of the mean, of `count` samples along one ray, green.
fn mean(frame: &Frame, settings: &ShadeSettings, ray: &Ray, count: u32) -> (f64, f64) {
    let settings = ShadeSettings {
        eye: ray.origin,
        ..settings.clone()
    };
    let shader = Shader::new(frame, &settings);
    let mut scratch = ShadeScratch::default();
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..count {
        let mut sampler = PixelSampler::new([3, 5], i, 0);
        sampler.next_2d();
        let light = f64::from(see(&shader, ray, &mut sampler, &mut scratch).radiance[1]);
        sum += light;
        squares += light * light;
    }
    let count = f64::from(count);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(0.0);
    (mean, (variance / count).sqrt())
}

fn material(kind: MaterialKind) -> Material {
    Material::of(kind, Some(Color::WHITE))
}
