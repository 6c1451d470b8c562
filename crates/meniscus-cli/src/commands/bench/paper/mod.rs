//! `meniscus bench paper`: the tables of the papers again, their ratios beside ours. Absolute times are
//! two decades and a graphics card apart, so ratios are what can be compared.

mod gourmel;
mod kanamori;

use super::passes::{Bench, median};
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::{OpenDevice, Tracing};
use crate::job::engine::EngineChoice;
use crate::progress::Reporter;
use meniscus::accel::Engine;
use meniscus::field::BlobField;
use meniscus::frame::{Frame, FrameSettings};
use meniscus::intersect::Counters;
use meniscus::math::DVec3;
use meniscus::scene::camera::Camera;
use meniscus::scene::generate::Generator;
use meniscus::scene::{BlobSettings, EngineSettings, PeelVariant, Scene};
use meniscus_gpu::StageSecs;
use std::io::Write;
use std::time::Instant;

/// Pixels of the paper's pictures.
const SIZE: [u32; 2] = [640, 480];

/// Measures a table and writes it.
type Print = fn(&Stage<'_>) -> Outcome<String>;

/// The tables by name.
const TABLES: [(&str, Machine, Print); 7] = [
    ("gourmel-1", Machine::Processor, gourmel::table_1),
    ("gourmel-3", Machine::Processor, gourmel::table_3),
    ("gourmel-4", Machine::Processor, gourmel::table_4),
    ("gourmel-5", Machine::Processor, gourmel::table_5),
    ("kanamori-1", Machine::Processor, kanamori::table_1),
    ("kanamori-gpu", Machine::Card, kanamori::table_1_on_card),
    ("kanamori-clipping", Machine::Processor, kanamori::clipping),
];

/// What a table is measured on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Machine {
    /// The processor.
    Processor,
    /// A graphics card.
    Card,
}

/// The device that a table is measured on.
pub(super) fn on_device(
    table: Option<&str>,
    engine: EngineChoice,
    reporter: &Reporter,
) -> Outcome<EngineChoice> {
    let is_wanted = |(name, ..): &&(&str, Machine, Print)| Some(*name) == table;
    let machine = TABLES
        .iter()
        .find(is_wanted)
        .map(|&(_, machine, _)| machine);
    match machine {
        Some(Machine::Card) => engine.on_device(None, reporter),
        Some(Machine::Processor) | None => engine.on_device(Some("bench paper"), reporter),
    }
}

/// Prints one table, or all.
pub(super) fn run(
    table: Option<&str>,
    engine: &EngineChoice,
    repeats: u32,
    reporter: &Reporter,
) -> Outcome {
    let known = TABLES.map(|(name, ..)| name).join(", ");
    if let Some(table) = table
        && TABLES.iter().all(|(name, ..)| *name != table)
    {
        return Err(Failure::wrong(format!("there is no paper table `{table}`"))
            .with_help(format!("there are: {known}")));
    }
    let stage = Stage {
        engine,
        repeats,
        reporter,
    };
    reporter.start(1);
    for (name, machine, print) in TABLES {
        if table.is_none() && machine == Machine::Card {
            reporter.note(&format!("{name} is measured by its own name, on a card"));
        } else if table.is_none_or(|table| table == name) {
            let text = print(&stage)?;
            writeln!(std::io::stdout(), "{text}")
                .map_err(|error| Failure::work(format!("cannot print: {error}")))?;
        }
    }
    reporter.finish();
    Ok(())
}

/// How to measure.
struct Stage<'a> {
    engine: &'a EngineChoice,
    repeats: u32,
    reporter: &'a Reporter,
}

/// A generated set, ready to be built for any engine.
struct Set {
    scene: Scene,
    field: BlobField,
}

/// What was measured of one engine on one set.
struct Measured {
    build_secs: f64,
    mrays_per_sec: f64,
    counters: Counters,
}

impl Measured {
    fn per_ray(&self, count: u64) -> f64 {
        count as f64 / self.counters.rays.max(1) as f64
    }
}

/// What was measured on a card.
struct OnCard {
    /// Time of a picture by the card's own clock, or from outside where it has none.
    secs: f64,
    /// Its stages.
    stages: StageSecs,
}

impl Stage<'_> {
    /// The card.
    fn card(&self) -> Outcome<&OpenDevice> {
        let device = self.engine.device.as_ref();
        device.ok_or_else(|| {
            Failure::work("there is no graphics card to measure")
                .with_help("the other tables are measured on the processor")
        })
    }

    /// Traces the primary rays through the pixel centres by engine `peel`.
    fn measure_on_card(&self, size: [u32; 2], set: &Set, peel: PeelVariant) -> Outcome<OnCard> {
        let card = self.card()?;
        let settings = FrameSettings {
            engine: Engine::Particles,
            switches: EngineSettings {
                peel,
                ..EngineSettings::default()
            },
            level: self.engine.frame.level,
        };
        let failed = |message: String| Failure::work(message);
        let frame = Frame::build(&set.scene, vec![set.field.clone()], &settings)
            .map_err(|error| failed(error.to_string()))?;
        let camera = Camera::from_settings(&set.scene.camera, frame.framing_bounds(), size)
            .map_err(|error| failed(error.to_string()))?;
        let tracing = card.upload(&frame, Some(&camera), self.reporter)?;
        let bench = Bench {
            frame: &frame,
            tracing: &tracing,
            camera: &camera,
            shutter_secs: [0.0; 2],
            spp: 1,
            towards_light: DVec3::Y,
            repeats: self.repeats,
            reporter: self.reporter,
        };
        let (figures, _) = bench.primary()?;
        let stages = tracing.peel_work().unwrap_or_default().secs / f64::from(self.repeats);
        let own = Some(stages.total()).filter(|&secs| secs > 0.0);
        Ok(OnCard {
            secs: own.unwrap_or(figures.secs),
            stages,
        })
    }

    /// The set that a generator makes.
    fn set(&self, generator: Generator, count: usize) -> Outcome<Set> {
        let wrong = |error: &dyn std::fmt::Display| Failure::work(error.to_string());
        let generated = generator
            .generate(count, 1, None)
            .map_err(|error| wrong(&error))?;
        let mut scene = generated.scene;
        scene.ground = None;
        let Some(surface) = scene.surfaces.first() else {
            return Err(Failure::work("the generator made no surface"));
        };
        let settings = surface.settings(&BlobSettings::default());
        let built = BlobField::from_particles(&generated.particles, &settings)
            .map_err(|error| wrong(&error))?;
        Ok(Set {
            scene,
            field: built.field,
        })
    }

    /// Builds and traces primary rays through the pixel centres.
    fn measure(&self, set: &Set, engine: Engine, switches: EngineSettings) -> Outcome<Measured> {
        self.measure_at(SIZE, set, engine, switches)
    }

    /// The same for a picture of another size.
    fn measure_at(
        &self,
        size: [u32; 2],
        set: &Set,
        engine: Engine,
        switches: EngineSettings,
    ) -> Outcome<Measured> {
        let settings = FrameSettings {
            engine,
            switches,
            level: self.engine.frame.level,
        };
        let mut times = Vec::new();
        let mut frame = Frame::default();
        for _ in 0..self.repeats {
            interrupt::check()?;
            let fields = vec![set.field.clone()];
            let start = Instant::now();
            frame = Frame::build(&set.scene, fields, &settings)
                .map_err(|error| Failure::work(error.to_string()))?;
            times.push(start.elapsed().as_secs_f64());
        }
        let camera = Camera::from_settings(&set.scene.camera, frame.framing_bounds(), size)
            .map_err(|error| Failure::work(error.to_string()))?;
        let bench = Bench {
            frame: &frame,
            tracing: &Tracing::Cpu,
            camera: &camera,
            shutter_secs: [0.0; 2],
            spp: 1,
            towards_light: DVec3::Y,
            repeats: self.repeats,
            reporter: self.reporter,
        };
        let (figures, counters) = bench.primary()?;
        Ok(Measured {
            build_secs: median(&mut times),
            mrays_per_sec: figures.mrays_per_sec,
            counters,
        })
    }
}
