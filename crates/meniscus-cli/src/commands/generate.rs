//! `meniscus generate`: particles by formula and their ready scene.

use crate::args::generate::GenerateArgs;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::files;
use crate::progress::Reporter;
use meniscus::particles::io::{WriteError, can_write, write};
use meniscus::particles::sequence;
use meniscus::scene::generate::{Generated, Generator};
use std::path::{Path, PathBuf};

/// Runs the command.
pub(crate) fn run(args: &GenerateArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    let names = || Generator::ALL.map(Generator::name).join(", ");
    let generator = Generator::from_name(&args.name).ok_or_else(|| {
        Failure::wrong(format!("there is no generator `{}`", args.name))
            .with_help(format!("there are: {}", names()))
    })?;
    let outputs = outputs(args, generator)?;
    let scene_path = scene_path(&args.output);
    for path in [&outputs[0].1, &scene_path] {
        files::check_writable(path)?;
    }
    let count = args.count.unwrap_or_else(|| generator.default_count());
    reporter.start(outputs.len());
    for (index, (frame, path)) in outputs.iter().enumerate() {
        interrupt::check()?;
        reporter.frame(index, frame.map_or(0, u64::from), path);
        let generated = generator
            .generate(count, args.seed, *frame)
            .map_err(|error| Failure::wrong(error.to_string()))?;
        reporter.stage("write");
        let lost = write(&generated.particles, path).map_err(|error| match error {
            WriteError::Ending { .. } => Failure::wrong(error.to_string()),
            _ => Failure::work(error.to_string()),
        })?;
        if !lost.is_empty() && index == 0 {
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            let lost = lost.join(", ");
            reporter.warn(&format!("a .{ending} file cannot hold {lost}; left out"));
        }
        if index == 0 {
            write_scene(&generated, &args.output, &scene_path)?;
        }
        reporter.frame_done(index, path);
    }
    reporter.finish();
    Ok(())
}

/// The frames to make and their files.
fn outputs(args: &GenerateArgs, generator: Generator) -> Outcome<Vec<(Option<u32>, PathBuf)>> {
    let is_pattern = sequence::is_pattern(&args.output);
    if !can_write(&args.output) {
        let error = WriteError::Ending {
            path: args.output.clone(),
        };
        return Err(Failure::wrong(error.to_string()));
    }
    match args.frames {
        None if is_pattern => Err(Failure::wrong(
            "the output has a {} for the frame number, but --frames is not given",
        )),
        None => Ok(vec![(None, args.output.clone())]),
        Some(0) => Err(Failure::wrong("--frames 0 makes nothing")
            .with_help("give the number of frames, at least 1")),
        Some(_) if !is_pattern => Err(Failure::wrong(
            "--frames makes several files, but the output names one",
        )
        .with_help("put {} where the frame number goes: 'splash_{}.vtk'")),
        Some(_) if !generator.is_animated() => Err(Failure::wrong(format!(
            "{} does not move: all frames would be the same",
            generator.name()
        ))
        .with_help("leave --frames out, or generate fountain or splash")),
        Some(frames) => {
            let width = frames.to_string().len();
            Ok((1..=frames)
                .map(|number| {
                    let text = format!("{number:0width$}");
                    let path = sequence::output_path(&args.output, &text);
                    // The first frame shows the moment after the start.
                    (Some(number), path)
                })
                .collect())
        }
    }
}

/// `pool.toml` beside `pool.vtk`, `splash.toml` beside `splash_{}.vtk`.
fn scene_path(output: &Path) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let stem = stem.replace(sequence::PLACEHOLDER, "");
    let stem = stem.trim_end_matches(['_', '-', '.', ' ']);
    let stem = if stem.is_empty() { "scene" } else { stem };
    output.with_file_name(format!("{stem}.toml"))
}

fn write_scene(generated: &Generated, output: &Path, scene_path: &Path) -> Outcome {
    let file = output.file_name().unwrap_or_default();
    let text = generated
        .scene_of(PathBuf::from(file))
        .to_toml()
        .map_err(|error| Failure::work(error.to_string()))?;
    files::write_whole(scene_path, text.as_bytes())
}
