//! How rays are traced, and on what.

use super::device::{DeviceWish, OpenDevice};
use crate::args::engine::EngineArgs;
use crate::exit::{Failure, Outcome};
use crate::progress::Reporter;
use meniscus::accel::Engine;
use meniscus::frame::{Frame, FrameSettings};
use meniscus::math::simd::{SimdLevel, level_name};
use meniscus::scene::{Builder, EngineSettings};

/// The engine that only cards have: the camera's rays by sprites or lists, all others by the tree.
const PEEL: &str = "peel";
/// Most threads that make sense to ask for.
const MAX_THREADS: usize = 4096;

/// A validated choice.
#[derive(Debug, Clone)]
pub(crate) struct EngineChoice {
    /// Engine and SIMD level; the engine's switches come from the scene.
    pub frame: FrameSettings,
    /// Name of the level.
    pub simd: &'static str,
    /// Threads.
    pub threads: usize,
    /// The graphics card that traces, if one does.
    pub device: Option<OpenDevice>,
    /// Whether the camera's rays are those of engine `peel`.
    pub is_peel: bool,
    wish: DeviceWish,
    engine_is_given: bool,
}

impl EngineChoice {
    /// The engine that traces a frame: moving particles are handed on by those that know still ones only.
    pub(crate) fn name_for(&self, frame: &Frame) -> &'static str {
        if self.is_peel {
            return PEEL;
        }
        let used = frame.blobs().next().map(|blobs| blobs.accel.engine());
        used.unwrap_or(self.frame.engine).name()
    }

    /// A scene's switches, as far as the device can have them.
    pub(crate) fn switches(&self, given: EngineSettings) -> EngineSettings {
        let builder = match (given.builder, &self.device) {
            // The processor has no faster one.
            (Builder::Device, None) => Builder::Morton,
            (builder, _) => builder,
        };
        EngineSettings { builder, ..given }
    }

    /// What `--stats` calls the device.
    pub(crate) fn device_name(&self) -> &'static str {
        match self.device {
            None => "cpu",
            Some(_) => "gpu",
        }
    }

    /// Opens the device that was asked for, where it can do the work: a card traces with one engine and
    /// cannot do what `undoable` names.
    pub(crate) fn on_device(self, undoable: Option<&str>, reporter: &Reporter) -> Outcome<Self> {
        if self.is_peel {
            return self.peeling(undoable, reporter);
        }
        let other_engine = self.engine_is_given && self.frame.engine != Engine::Particles;
        let device = match undoable {
            Some(undoable) => self.wish.refuse(undoable, reporter)?,
            None if other_engine => {
                let engine = format!("--engine {}", self.frame.engine.name());
                self.wish.refuse(&engine, reporter)?
            }
            None => self.wish.open(reporter)?,
        };
        let mut choice = self;
        if device.is_some() {
            choice.frame.engine = Engine::Particles;
        }
        choice.device = device;
        Ok(choice)
    }

    /// Opens the device for engine `peel`, which no processor has.
    fn peeling(self, undoable: Option<&str>, reporter: &Reporter) -> Outcome<Self> {
        let failure = match (undoable, self.wish) {
            (Some(undoable), _) => Failure::wrong(format!("--engine {PEEL} cannot do {undoable}"))
                .with_help("--engine particles can, or --engine cells on the processor"),
            (None, DeviceWish::Cpu) => {
                Failure::wrong(format!("--engine {PEEL} runs on a graphics card only"))
                    .with_help("--device gpu, or another engine such as particles")
            }
            (None, DeviceWish::Gpu | DeviceWish::Auto) => {
                let Some(device) = self.wish.open(reporter)? else {
                    return Err(Failure::work(format!(
                        "there is no graphics card for --engine {PEEL}"
                    ))
                    .with_help("another engine such as particles runs on the processor"));
                };
                return Ok(Self {
                    device: Some(device),
                    ..self
                });
            }
        };
        Err(failure)
    }

    /// Validates the options and starts the threads. Everything is on the processor until
    /// [`EngineChoice::on_device`].
    pub(crate) fn new(args: &EngineArgs) -> Outcome<Self> {
        let is_peel = args.engine.as_deref() == Some(PEEL);
        let engine = match args.engine.as_deref() {
            None => Engine::default(),
            // Beside it stands the tree that cards walk.
            Some(PEEL) => Engine::Particles,
            Some(name) => engine(name)?,
        };
        let wish = DeviceWish::new(args.device.as_deref())?;
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
            device: None,
            is_peel,
            wish,
            engine_is_given: args.engine.is_some(),
        })
    }
}

fn engine(name: &str) -> Outcome<Engine> {
    Engine::from_name(name).ok_or_else(|| {
        let available = Engine::ALL.map(Engine::name).join(", ");
        Failure::wrong(format!("there is no engine `{name}`"))
            .with_help(format!("there are: {available}; on a card also {PEEL}"))
    })
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
