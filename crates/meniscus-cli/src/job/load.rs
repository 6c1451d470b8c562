//! From files to a frame that can be traced.

use super::columns;
use super::engine::EngineChoice;
use super::input::FrameInput;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::progress::Reporter;
use crate::report::{Excerpt, Message};
use meniscus::field::{BlobField, FieldError, FieldReport};
use meniscus::frame::{Frame, FrameSettings, MeshSurface};
use meniscus::mesh;
use meniscus::particles::io::{self, ParticleFile};
use meniscus::scene::{BlobSettings, Scene};
use std::path::Path;
use std::time::Instant;

/// A frame, where it came from, and what it took.
#[derive(Debug)]
pub(crate) struct LoadedFrame {
    /// The frame.
    pub frame: Frame,
    /// The settings of each surface, defaults filled in.
    pub settings: Vec<BlobSettings>,
    /// What happened to each surface's particles.
    pub reports: Vec<FieldReport>,
    /// Fields, weights and acceleration structures.
    pub build_secs: f64,
}

impl LoadedFrame {
    /// Particles in the frame.
    pub(crate) fn particles(&self) -> usize {
        self.frame.blobs().map(|blobs| blobs.field.len()).sum()
    }
}

/// The particle files of a frame, decoded.
#[derive(Debug)]
pub(crate) struct ReadFrame {
    /// One per surface.
    pub files: Vec<ParticleFile>,
    /// The moment of a trajectory's frame in picoseconds.
    pub time_ps: Option<f64>,
    /// Reading and decoding.
    pub read_secs: f64,
}

/// Reads the particle files of a frame.
pub(crate) fn read(input: &FrameInput, reporter: &Reporter) -> Outcome<ReadFrame> {
    reporter.stage("read");
    let start = Instant::now();
    let mut files = Vec::with_capacity(input.files.len());
    let mut time_ps = None;
    for (surface, path) in input.files.iter().enumerate() {
        interrupt::check()?;
        // Only the first file of a scene can hold the time steps that are being rendered.
        let step = if surface == 0 { input.step } else { 0 };
        let file = match &input.trajectory {
            Some(trajectory) if surface == 0 => {
                let (file, time) = trajectory.read(step)?;
                time_ps = time;
                file
            }
            _ => io::read(path, step).map_err(|error| Failure::work(error.to_string()))?,
        };
        for warning in &file.warnings {
            reporter.warn(&format!("{}: {warning}", path.display()));
        }
        files.push(file);
    }
    Ok(ReadFrame {
        files,
        time_ps,
        read_secs: start.elapsed().as_secs_f64(),
    })
}

/// What becomes of a file of which no particle is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WithoutParticles {
    /// There is nothing to do, which is a mistake.
    Fails,
    /// Its frame shows nothing of it: in a sequence particles may come later or go early.
    IsEmpty,
}

/// Reads and builds a frame. `scene` is the input's scene with everything applied; `aov` names the
/// channels that will be asked for.
pub(crate) fn load(
    input: &FrameInput,
    scene: &Scene,
    aov: &[String],
    engine: &EngineChoice,
    without: WithoutParticles,
    reporter: &Reporter,
) -> Outcome<LoadedFrame> {
    let ReadFrame { files, .. } = read(input, reporter)?;
    reporter.stage("build");
    build(input, scene, &files, aov, engine, without, reporter)
}

/// Builds a frame from decoded files.
pub(crate) fn build(
    input: &FrameInput,
    scene: &Scene,
    files: &[ParticleFile],
    aov: &[String],
    engine: &EngineChoice,
    without: WithoutParticles,
    reporter: &Reporter,
) -> Outcome<LoadedFrame> {
    let start = Instant::now();
    let mut scene = scene.clone();
    for (surface, file) in scene.surfaces.iter_mut().zip(files) {
        surface.color_by = surface.color_by_of(file.format).map(str::to_owned);
    }
    let scene = &scene;
    let mut fields = Vec::with_capacity(files.len());
    let mut all_settings = Vec::with_capacity(files.len());
    let mut reports = Vec::with_capacity(files.len());
    for ((surface, file), path) in scene.surfaces.iter().zip(files).zip(&input.files) {
        interrupt::check()?;
        let mut settings = surface.settings(&BlobSettings::of_format(file.format));
        columns::carry(&mut settings, surface, aov, &file.particles);
        let motion = &scene.motion;
        let shutter_secs = motion.shutter_secs();
        let scale = motion.velocity_scale;
        let particles = &file.particles;
        let built =
            match BlobField::from_moving_particles(particles, &settings, shutter_secs, scale) {
                Err(error @ FieldError::Empty { .. }) if without == WithoutParticles::IsEmpty => {
                    reporter.warn(&format!(
                        "{}: {error}, so this frame shows nothing of it",
                        path.display()
                    ));
                    BlobField::without_blobs(particles, &settings)
                }
                built => built,
            }
            .map_err(|error| field_failure(error, path))?;
        let is_expected = shutter_secs[0] < shutter_secs[1] && !moves_as_a_whole(scene);
        if is_expected && !built.field.is_empty() && built.field.motion.is_none() {
            reporter.warn(&format!(
                "{}: no column of velocities that are not 0, so nothing moves",
                path.display()
            ));
        }
        for warning in &built.report.warnings {
            reporter.warn(&format!("{}: {warning}", path.display()));
        }
        fields.push(built.field);
        reports.push(built.report);
        all_settings.push(settings);
    }
    let settings = FrameSettings {
        switches: engine.switches(scene.engine),
        ..engine.frame
    };
    let meshes = meshes(scene, reporter)?;
    let frame = Frame::build_with_meshes(scene, fields, meshes, &settings)
        .map_err(|error| Failure::wrong(error.to_string()))?;
    Ok(LoadedFrame {
        frame,
        settings: all_settings,
        reports,
        build_secs: start.elapsed().as_secs_f64(),
    })
}

/// Whether the camera or instances move, so that a shutter is of use to particles at rest.
fn moves_as_a_whole(scene: &Scene) -> bool {
    let mut instances = scene.instances.iter();
    !scene.camera.keys.is_empty() || instances.any(|instance| !instance.keys.is_empty())
}

/// Reads and builds the meshes of a scene. A mesh that cannot be used makes the scene wrong.
fn meshes(scene: &Scene, reporter: &Reporter) -> Outcome<Vec<MeshSurface>> {
    let mut surfaces = Vec::with_capacity(scene.meshes.len());
    for mesh in &scene.meshes {
        interrupt::check()?;
        let file = mesh::io::read(&mesh.file).map_err(|error| Failure::wrong(error.to_string()))?;
        let (surface, notes) = MeshSurface::build(&file.mesh);
        for note in file.warnings.iter().chain(&notes) {
            reporter.warn(&format!("{}: {note}", mesh.file.display()));
        }
        surfaces.push(surface);
    }
    Ok(surfaces)
}

/// Settings that do not fit are a wrong command line; a file without usable particles is not.
fn field_failure(error: FieldError, path: &Path) -> Failure {
    let path = path.display();
    match error {
        FieldError::Filter(filter) => Failure::Wrong(Box::new(Message {
            text: format!("--filter: {}", filter.problem),
            help: filter.help.clone(),
            excerpt: Some(Excerpt::new(
                "filter",
                &filter.expression,
                filter.span.clone(),
            )),
        })),
        FieldError::Missing { what, missing } => {
            Failure::wrong(format!("{path}: {what}: {}", missing.problem()))
                .with_help(missing.help())
        }
        FieldError::NoRadius => Failure::work(format!("{path}: {error}")),
        FieldError::Empty { .. } => Failure::work(format!("{path}: {error}")),
        _ => Failure::wrong(format!("{path}: {error}")),
    }
}
