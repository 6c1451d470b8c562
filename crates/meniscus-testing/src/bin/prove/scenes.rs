//! The scenes of the proof: generated, built by the corpus, and real frames.

use meniscus::field::BlobField;
use meniscus::kernel::Kernel;
use meniscus::particles::{Particles, io};
use meniscus::scene::generate::Generator;
use meniscus::scene::surface::{BlobSettings, Weights};
use meniscus_testing::corpus::{self, Scene};
use meniscus_testing::data;

/// Every scene.
pub(crate) const NAMES: [&str; 14] = [
    "scattered",
    "pool",
    "tornado",
    "molecule",
    "splash",
    "mixed",
    "ellipsoids",
    "tangent",
    "negative",
    "weighed",
    "crown",
    "bunny",
    "dam break",
    "knot",
];

/// The scene of that name with that kernel.
pub(crate) fn build(name: &str, kernel: Kernel) -> Result<Scene, String> {
    let generated = |generator: Generator, count: usize, weights: Weights, threshold: f64| {
        let particles = generator
            .generate(count, 1, None)
            .map_err(|e| e.to_string())?
            .particles;
        surface(name, &particles, kernel, weights, threshold)
    };
    let real = |path: &str, weights: Weights, threshold: f64| {
        let path = data::folder().ok_or("no data folder")?.join(path);
        let particles = io::read(&path, 0).map_err(|e| e.to_string())?.particles;
        surface(name, &particles, kernel, weights, threshold)
    };
    match name {
        "scattered" => generated(Generator::Scattered, 30_000, Weights::Unit, 0.2),
        "pool" => generated(Generator::Pool, 100_000, Weights::Volume, 0.6),
        "tornado" => generated(Generator::Tornado, 30_000, Weights::Unit, 0.2),
        "molecule" => generated(Generator::Molecule, 10_000, Weights::Unit, 0.2),
        "splash" => generated(Generator::Splash, 50_000, Weights::Volume, 0.6),
        "crown" => {
            let frame = "fluid/splishsplash_crown/ParticleData_Fluid_40.vtk";
            real(frame, Weights::Volume, 0.6)
        }
        "bunny" => {
            let frame = "fluid/splashsurf/bunny_frame_14_7705_particles.vtk";
            real(frame, Weights::Volume, 0.5)
        }
        "dam break" => {
            let frame = "fluid/splashsurf/dam_break_frame_9_6859_particles.bgeo";
            real(frame, Weights::Volume, 0.6)
        }
        "knot" => {
            let frame = "fluid/splashsurf/sailors_knot_19539_particles.vtk";
            real(frame, Weights::Unit, 0.6)
        }
        _ => Ok(corpus::scene(name, kernel, 3000)),
    }
}

fn surface(
    name: &str,
    particles: &Particles,
    kernel: Kernel,
    weights: Weights,
    threshold: f64,
) -> Result<Scene, String> {
    let settings = BlobSettings {
        kernel,
        weights,
        threshold,
        ..BlobSettings::default()
    };
    let built = BlobField::from_particles(particles, &settings).map_err(|e| e.to_string())?;
    Ok(Scene {
        name: format!("{name}/{}", kernel.name()),
        field: built.field,
    })
}
