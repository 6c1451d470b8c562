//! What must not move from frame to frame.

use super::picture;
use crate::exit::{Failure, Outcome};
use crate::job::engine::EngineChoice;
use crate::job::input::FrameInput;
use crate::job::load::{self, WithoutParticles};
use crate::progress::Reporter;
use meniscus::field::SupportSource;
use meniscus::math::DVec3;
use meniscus::scene::camera::Camera;
use meniscus::scene::{Scene, Surface};
use std::collections::VecDeque;

/// A default camera, the ground and radii that are estimated, which the first frame of a sequence that
/// holds particles decides.
#[derive(Default)]
pub(super) struct Fixed {
    first_number: Option<u64>,
    /// Frames that may decide, in order.
    candidates: VecDeque<FrameInput>,
    /// Whether these were all frames, so that none that appears later decides.
    are_all: bool,
    /// What is fixed, once a frame decided.
    found: Option<Found>,
}

struct Found {
    eye: DVec3,
    target: DVec3,
    ground_height: f64,
    /// For each surface its radius, where that had to be estimated.
    radii: Vec<Option<f64>>,
}

impl Fixed {
    /// Of a sequence of these frames.
    pub(super) fn by(frames: Vec<FrameInput>) -> Self {
        Self {
            first_number: frames.first().map(|first| first.number),
            candidates: frames.into(),
            are_all: true,
            found: None,
        }
    }

    /// A frame of a sequence that nobody knew as a whole.
    pub(super) fn appears(&mut self, frame: &FrameInput) {
        self.first_number.get_or_insert(frame.number);
        if !self.are_all && self.found.is_none() {
            self.candidates.push_back(frame.clone());
        }
    }

    /// Number of the first frame.
    pub(super) fn first_number(&self) -> Option<u64> {
        self.first_number
    }

    /// The scene of a frame with what the first one decides.
    pub(super) fn scene(
        &mut self,
        input: &FrameInput,
        engine: &EngineChoice,
        reporter: &Reporter,
    ) -> Outcome<Scene> {
        let mut scene = (*input.scene).clone();
        let camera = &scene.camera;
        let has_keys = !camera.keys.is_empty();
        let camera_is_open = !has_keys && (camera.eye.is_none() || camera.target.is_none());
        let ground_is_open = scene.ground.as_ref().is_some_and(|g| g.height.is_none());
        if !camera_is_open && !ground_is_open && scene.surfaces.iter().all(has_size) {
            return Ok(scene);
        }
        while self.found.is_none()
            && let Some(candidate) = self.candidates.pop_front()
        {
            self.found = ask(&candidate, engine, reporter)?;
        }
        let Some(found) = &self.found else {
            if self.are_all {
                let problem = Failure::work("no frame of the sequence holds a particle");
                return Err(match &scene.surfaces[..] {
                    [
                        Surface {
                            filter: Some(filter),
                            ..
                        },
                        ..,
                    ] => problem.with_help(format!("--filter '{filter}' leaves none")),
                    _ => problem,
                });
            }
            // There is nothing to see yet, from wherever.
            return Ok(scene);
        };
        self.candidates.clear();
        if !has_keys {
            scene.camera.eye.get_or_insert(found.eye);
            scene.camera.target.get_or_insert(found.target);
        }
        if let Some(ground) = &mut scene.ground {
            ground.height.get_or_insert(found.ground_height);
        }
        for (surface, radius) in scene.surfaces.iter_mut().zip(&found.radii) {
            if !has_size(surface) {
                surface.radius = *radius;
            }
        }
        Ok(scene)
    }
}

/// Whether a surface's settings decide on the sizes of its particles.
fn has_size(surface: &Surface) -> bool {
    let columns = [&surface.metric, &surface.radii, &surface.axes];
    surface.radius.is_some()
        || surface.support.is_some()
        || columns.iter().any(|column| column.is_some())
}

/// What the first frame with particles says; `None` of one without.
fn ask(first: &FrameInput, engine: &EngineChoice, reporter: &Reporter) -> Outcome<Option<Found>> {
    let scene = &first.scene;
    // Its warnings come when it is rendered.
    let silent = Reporter::silent();
    let without = WithoutParticles::IsEmpty;
    let loaded = load::load(first, scene, &[], engine, without, &silent)?;
    if loaded.particles() == 0 && !loaded.reports.is_empty() {
        return Ok(None);
    }
    let bounds = loaded.frame.framing_bounds();
    let camera = picture::camera(scene, &loaded.frame)?;
    let Camera { eye, forward, .. } = camera;
    let up = scene.camera.up.vector();
    let half = bounds.size() * 0.5;
    let lowest = bounds.center().dot(up) - half.dot(up.abs());
    let target = scene
        .camera
        .target
        .unwrap_or(eye + forward * (bounds.center() - eye).length());
    let radii = loaded.reports.iter().zip(&first.files);
    let radii = radii.map(|(report, path)| {
        let is_estimate = report.support_source == SupportSource::Estimate;
        let radius = is_estimate.then_some(report.spacing? * 0.5)?;
        reporter.warn(&format!(
            "{}: the particles have no radius: took half their median nearest-neighbour \
                 distance, {radius:.6}, for all frames; --radius sets another",
            path.display()
        ));
        Some(radius)
    });
    Ok(Some(Found {
        eye,
        target,
        ground_height: if lowest.is_finite() { lowest } else { 0.0 },
        radii: radii.collect(),
    }))
}
