//! How rays are traced, and on what.

use crate::args::engine::EngineArgs;
use crate::exit::{Failure, Outcome};
use meniscus::accel::Engine;
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::simd::{SimdLevel, level_name};

/// Engines that are announced and not there yet.
const ENGINES_TO_COME: [&str; 1] = ["peel"];
/// Most threads that make sense to ask for.
const MAX_THREADS: usize = 4096;

/// A validated choice.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EngineChoice {
    /// Engine and SIMD level; the engine's switches come from the scene.
    pub frame: FrameSettings,
    /// Name of the level.
    pub simd: &'static str,
    /// Threads.
    pub threads: usize,
    /// Device.
    pub device: &'static str,
}

impl EngineChoice {
    /// The engine that traces a frame: moving particles are handed on by those that know still ones only.
    pub(crate) fn name_for(&self, frame: &Frame) -> &'static str {
        let used = frame.blobs().next().map(|blobs| blobs.accel.engine());
        used.unwrap_or(self.frame.engine).name()
    }

    /// Validates the options and starts the threads.
    pub(crate) fn new(args: &EngineArgs) -> Outcome<Self> {
        let engine = match args.engine.as_deref() {
            None => Engine::default(),
            Some(name) => engine(name)?,
        };
        match args.device.as_deref() {
            None | Some("cpu" | "auto") => {}
            Some("gpu") => return Err(Failure::not_yet("--device gpu", "cpu, auto")),
            Some(other) => {
                return Err(Failure::wrong(format!("there is no device `{other}`"))
                    .with_help("there are: cpu, auto"));
            }
        }
        let level = level(args.simd.as_deref().unwrap_or("auto"))?;
        if let Some(threads) = args.threads {
            if threads == 0 || threads > MAX_THREADS {
                return Err(Failure::wrong(format!(
                    "--threads {threads}: between 1 and {MAX_THREADS} are possible"
                )));
            }
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global()
                .map_err(|error| {
                    Failure::work(format!("cannot start {threads} threads: {error}"))
                })?;
        }
        Ok(Self {
            frame: FrameSettings {
                engine,
                level,
                ..FrameSettings::default()
            },
            simd: level_name(level),
            threads: rayon::current_num_threads(),
            device: "cpu",
        })
    }
}

fn engine(name: &str) -> Outcome<Engine> {
    let available = Engine::ALL.map(Engine::name).join(", ");
    match Engine::from_name(name) {
        Some(engine) => Ok(engine),
        None if ENGINES_TO_COME.contains(&name) => {
            Err(Failure::not_yet(&format!("--engine {name}"), &available))
        }
        None => Err(Failure::wrong(format!("there is no engine `{name}`"))
            .with_help(format!("there are: {available}"))),
    }
}

fn level(name: &str) -> Outcome<meniscus::math::simd::Level> {
    let known = SimdLevel::ALL.iter().find(|(known, _)| *known == name);
    let on_this_machine = || {
        let usable = SimdLevel::ALL
            .iter()
            .filter(|(_, level)| level.resolve().is_some());
        usable.map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
    };
    match known {
        None => Err(Failure::wrong(format!("there is no SIMD level `{name}`"))
            .with_help(format!("this machine has: {}", on_this_machine()))),
        Some((_, level)) => level.resolve().ok_or_else(|| {
            Failure::wrong(format!("this machine has no {name}"))
                .with_help(format!("it has: {}", on_this_machine()))
        }),
    }
}
