//! From a particle file to a picture with nothing but defaults.
//!
//! ```text
//! cargo run --release -p meniscus --example picture -- OUT.png [FILE [COLOR_BY]]
//! ```
//!
//! Without FILE it makes a small splash. COLOR_BY names a column of the file; its legend is written
//! beside the picture.

use meniscus::field::BlobField;
use meniscus::film::{BitDepth, Legend, Tone};
use meniscus::frame::{BaseColor, Frame, FrameSettings};
use meniscus::particles::io;
use meniscus::render::{Backend, CpuBackend, Progress, RenderSettings, RenderState};
use meniscus::scene::camera::Camera;
use meniscus::scene::generate::Generator;
use meniscus::scene::{BlobSettings, Ground, Scene, Surface};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let out = PathBuf::from(arguments.next().unwrap_or_else(|| "picture.png".to_owned()));
    let file = arguments.next();
    let color_by = arguments.next();

    let (particles, mut scene) = match file {
        Some(file) => {
            let particles = io::read(file.as_ref(), 0)?.particles;
            let scene = Scene {
                surfaces: vec![Surface::from_file(file)],
                ..Scene::default()
            };
            (particles, scene)
        }
        None => {
            let splash = Generator::Splash.generate(3_000, 1, None)?;
            (splash.particles, splash.scene)
        }
    };
    [scene.film.width, scene.film.height] = [960, 540];
    scene.ground.get_or_insert_with(Ground::default);
    let surface = &mut scene.surfaces[0];
    surface.attributes.extend(color_by.clone());
    surface.color_by = color_by;

    let settings = surface.settings(&BlobSettings::default());
    let map = surface.color_map.unwrap_or_default();
    let field = BlobField::from_particles(&particles, &settings)?.field;
    let frame = Frame::build(&scene, vec![field], &FrameSettings::default())?;
    let size = [scene.film.width, scene.film.height];
    let camera = Camera::from_settings(&scene.camera, frame.framing_bounds(), size)?;

    let (film, _) = CpuBackend.render(
        &frame,
        &camera,
        &RenderSettings::default(),
        &RenderState::new(),
        &Progress::none(),
    )?;
    film.develop(Tone::default(), BitDepth::Eight)
        .write_png(&out)?;
    if let BaseColor::Attribute(coloring) = &frame.materials[0].base {
        let legend = Legend {
            name: coloring.label.clone(),
            unit: None,
            map,
            range: coloring.range.map(f64::from),
        };
        legend.write_beside(&out)?;
    }
    Ok(())
}
