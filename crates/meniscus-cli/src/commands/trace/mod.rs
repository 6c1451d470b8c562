//! `meniscus trace`: rays from a file, hits to a file.

mod hits;
mod rays;

use crate::args::trace::TraceArgs;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::Tracing;
use crate::job::engine::EngineChoice;
use crate::job::load::{self, WithoutParticles};
use crate::job::scene::{apply_camera, apply_settings, apply_surface, scene_failure};
use crate::job::{files, input};
use crate::progress::Reporter;
use hits::{Answers, Question};
use meniscus::scene::Scene;

/// Runs the command.
pub(crate) fn run(args: &TraceArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    let engine = EngineChoice::new(&args.engine)?;
    if args.output.extension().is_none_or(|ending| ending != "npz") {
        return Err(Failure::wrong(format!(
            "{}: hits are written as .npz",
            args.output.display()
        )));
    }
    files::check_writable(&args.output)?;
    let edit = |scene: &mut Scene| {
        apply_settings(&args.settings, scene)?;
        apply_surface(&args.surface, scene)?;
        apply_camera(&args.camera, scene)?;
        scene.validate().map_err(scene_failure)
    };
    let inputs = input::resolve(std::slice::from_ref(&args.input), None, &edit)?;
    let input = match &inputs.frames[..] {
        [only] => only,
        several => {
            return Err(Failure::wrong(format!(
                "trace takes one frame, the input has {}",
                several.len()
            )));
        }
    };
    let rays = rays::read(&args.rays)?;
    let undoable = engine
        .is_peel
        .then_some("rays from a file, which are no camera's");
    let engine = engine.on_device(undoable, &reporter)?;
    reporter.start(1);
    // The shutter is open as long as rays ask for.
    let mut scene = (*input.scene).clone();
    let latest = rays
        .iter()
        .map(|ray| ray.time.abs())
        .filter(|time| time.is_finite());
    let latest = latest.fold(0.0, f64::max);
    scene.motion.shutter = scene.motion.shutter.max(2.0 * latest * scene.motion.fps);
    let loaded = load::load(
        input,
        &scene,
        &[],
        &engine,
        WithoutParticles::Fails,
        &reporter,
    )?;
    reporter.stage("trace");
    let question = if args.any {
        Question::Any
    } else if args.all {
        Question::All
    } else {
        Question::Closest
    };
    let tracing = Tracing::of(engine.device.as_ref(), &loaded.frame, &reporter)?;
    let answers = Answers::of(question, &loaded.frame, &tracing, &rays, &reporter)?;
    tracing.tell(&reporter);
    interrupt::check()?;
    reporter.stage("write");
    answers.write(&args.output)?;
    reporter.note(&format!(
        "{} rays, build {:.3} s",
        rays.len(),
        loaded.build_secs
    ));
    reporter.finish();
    Ok(())
}
