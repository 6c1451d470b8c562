//! `meniscus bench`: how fast rays are traced.

mod paper;
mod passes;

use crate::args::bench::BenchArgs;
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::job::device::Tracing;
use crate::job::engine::EngineChoice;
use crate::job::input;
use crate::job::load::{self, LoadedFrame, ReadFrame, WithoutParticles};
use crate::job::scene::{apply_camera, apply_settings, apply_surface, scene_failure};
use crate::progress::Reporter;
use meniscus::accel::Engine;
use meniscus::frame::{Frame, Light};
use meniscus::intersect::Counters;
use meniscus::math::DVec3;
use meniscus::scene::Scene;
use meniscus::scene::camera::Camera;
use meniscus_gpu::PeelWork;
use passes::{Bench, PassFigures};
use serde::Serialize;
use std::io::Write;
use std::time::Instant;

/// What `bench --json` prints. The keys are fixed: measurements read them.
#[derive(Debug, Serialize)]
struct BenchReport {
    engine: &'static str,
    simd: &'static str,
    device: &'static str,
    threads: usize,
    repeats: u32,
    particles: usize,
    build_secs: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    on_card: Option<CardFigures>,
    structure_bytes: usize,
    bytes_per_particle: f64,
    primary: PassFigures,
    shadow: PassFigures,
    hemisphere: PassFigures,
    shuffled: PassFigures,
    nodes_per_ray: f64,
    leaves_per_ray: f64,
    blob_evaluations_per_ray: f64,
    #[serde(flatten)]
    clipping: Option<ClippingFigures>,
    #[serde(skip_serializing_if = "Option::is_none")]
    peel: Option<PeelFigures>,
}

/// What engine `peel` adds: of one primary pass, or per ray of it.
#[derive(Debug, Serialize)]
struct PeelFigures {
    /// Time of the device by its own clock; 0 where it keeps none.
    lists_secs: f64,
    sprites_secs: f64,
    solve_secs: f64,
    /// Layers of sprites, summed over the rounds that rays are sent in.
    layers: f64,
    /// Balls in the lists of tiles.
    listed: f64,
    /// Rays that the tree answered.
    left_fraction: f64,
}

impl PeelFigures {
    fn of(work: &PeelWork, repeats: u32) -> Self {
        let repeats = f64::from(repeats);
        Self {
            lists_secs: work.secs.lists / repeats,
            sprites_secs: work.secs.sprites / repeats,
            solve_secs: work.secs.solve / repeats,
            layers: work.layers as f64 / repeats,
            listed: work.listed as f64 / repeats,
            left_fraction: work.left as f64 / work.rays.max(1) as f64,
        }
    }
}

/// A card's structure: bytes there, and medians in seconds. Own times are those of the card's clock, for what it builds;
/// the others include the way there.
#[derive(Debug, Serialize)]
struct CardFigures {
    bytes: u64,
    send_secs: f64,
    own_build_secs: f64,
    update_secs: f64,
    own_update_secs: f64,
}

impl CardFigures {
    /// Sends `frame` again and again, and lets it follow itself.
    fn measure(
        tracing: &mut Tracing<'_>,
        (send_secs, again): (f64, impl Fn() -> Outcome<(f64, Option<f64>)>),
        frame: &Frame,
        repeats: u32,
    ) -> Outcome<Option<Self>> {
        let Some(own) = tracing.build_secs() else {
            return Ok(None);
        };
        let (mut sends, mut builds) = (vec![send_secs], vec![own]);
        let (mut updates, mut refits) = (Vec::new(), Vec::new());
        for repeat in 0..repeats {
            interrupt::check()?;
            if repeat > 0 {
                let (secs, own) = again()?;
                sends.push(secs);
                builds.extend(own);
            }
            if let Some([secs, own]) = tracing.update(frame)? {
                updates.push(secs);
                refits.push(own);
            }
        }
        Ok(Some(Self {
            bytes: tracing.bytes(),
            send_secs: passes::median(&mut sends),
            own_build_secs: passes::median(&mut builds),
            update_secs: passes::median(&mut updates),
            own_update_secs: passes::median(&mut refits),
        }))
    }
}

/// What engine `sweep` adds, per primary ray or polynomial.
#[derive(Debug, Serialize)]
struct ClippingFigures {
    polynomials_per_ray: f64,
    clip_iterations_per_polynomial: f64,
    clip_failures: u64,
}

impl ClippingFigures {
    fn of(counters: &Counters) -> Self {
        Self {
            polynomials_per_ray: counters.polynomials as f64 / counters.rays.max(1) as f64,
            clip_iterations_per_polynomial: counters.clip_iterations as f64
                / counters.polynomials.max(1) as f64,
            clip_failures: counters.clip_failures,
        }
    }
}

/// Most repeats that make sense to ask for.
const MAX_REPEATS: u32 = 10_000;

/// Runs the command.
pub(crate) fn run(args: &BenchArgs) -> Outcome {
    let reporter = Reporter::new(&args.messages);
    if args.repeats == 0 || args.repeats > MAX_REPEATS {
        return Err(Failure::wrong(format!(
            "--repeats {}: between 1 and {MAX_REPEATS} are possible",
            args.repeats
        )));
    }
    let inputs = match &args.inputs[..] {
        [paper, table @ ..] if paper.as_os_str() == "paper" && table.len() <= 1 => {
            let table = table.first().map(|table| table.to_string_lossy());
            let engine = EngineChoice::new(&args.engine)?;
            let engine = paper::on_device(table.as_deref(), engine, &reporter)?;
            return paper::run(table.as_deref(), &engine, args.repeats, &reporter);
        }
        [only] => std::slice::from_ref(only),
        _ => return Err(Failure::wrong("bench takes one input")),
    };
    let engine = EngineChoice::new(&args.engine)?;
    let edit = |scene: &mut Scene| {
        apply_settings(&args.settings, scene)?;
        apply_surface(&args.surface, scene)?;
        apply_camera(&args.camera, scene)?;
        scene.motion.shutter = args.shutter.unwrap_or(scene.motion.shutter);
        // Only surfaces are measured.
        scene.ground = None;
        [scene.film.width, scene.film.height] = args.size.0;
        scene.validate().map_err(scene_failure)
    };
    let resolved = input::resolve(inputs, None, &edit)?;
    let [input] = &resolved.frames[..] else {
        return Err(Failure::wrong(format!(
            "bench takes one frame, the input has {}",
            resolved.frames.len()
        )));
    };
    let engine = engine.on_device(None, &reporter)?;
    reporter.start(1);
    let ReadFrame { files, .. } = load::read(input, &reporter)?;
    reporter.stage("build");
    let silent = Reporter::silent();
    let mut build_secs = Vec::new();
    let mut loaded: Option<LoadedFrame> = None;
    for repeat in 0..args.repeats {
        // One structure at a time: memory is part of what is measured.
        drop(loaded.take());
        interrupt::check()?;
        let to = if repeat == 0 { &reporter } else { &silent };
        let built = load::build(
            input,
            &input.scene,
            &files,
            &[],
            &engine,
            WithoutParticles::Fails,
            to,
        )?;
        build_secs.push(built.build_secs);
        loaded = Some(built);
    }
    drop(files);
    let Some(loaded) = loaded else {
        return Err(Failure::wrong("nothing to measure"));
    };
    let frame = &loaded.frame;
    let camera = Camera::from_settings_at(
        &input.scene.camera,
        frame.framing_bounds(),
        args.size.0,
        input.scene.motion.time,
    )
    .map_err(|error| Failure::wrong(error.to_string()))?;
    let towards_light = frame.lights.iter().find_map(|light| match light {
        Light::Sun { towards, .. } => Some(*towards),
        _ => None,
    });
    let start = Instant::now();
    let mut tracing = Tracing::seen_by(&camera, &engine, frame, &reporter)?;
    let upload_secs = start.elapsed().as_secs_f64();
    let send = || {
        let start = Instant::now();
        let sent = Tracing::of(engine.device.as_ref(), frame, &silent)?;
        Ok((start.elapsed().as_secs_f64(), sent.build_secs()))
    };
    let on_card = CardFigures::measure(&mut tracing, (upload_secs, send), frame, args.repeats)?;
    reporter.stage("trace");
    let bench = Bench {
        frame,
        tracing: &tracing,
        camera: &camera,
        shutter_secs: input.scene.motion.shutter_secs(),
        spp: input.scene.film.spp,
        towards_light: towards_light.unwrap_or(DVec3::Y),
        repeats: args.repeats,
        reporter: &reporter,
    };
    let measured = bench.run()?;
    tracing.tell(&reporter);
    let particles = loaded.particles();
    let structure_bytes = measured.structure_bytes;
    let refinement_secs = measured.refinement_secs / engine.threads as f64;
    let rays = measured.counters.rays.max(1) as f64;
    let report = BenchReport {
        engine: engine.name_for(frame),
        simd: engine.simd,
        device: engine.device_name(),
        threads: engine.threads,
        repeats: args.repeats,
        particles,
        build_secs: passes::median(&mut build_secs) + refinement_secs + upload_secs,
        on_card,
        structure_bytes,
        bytes_per_particle: structure_bytes as f64 / particles.max(1) as f64,
        primary: measured.primary,
        shadow: measured.shadow,
        hemisphere: measured.hemisphere,
        shuffled: measured.shuffled,
        nodes_per_ray: measured.counters.nodes as f64 / rays,
        leaves_per_ray: measured.counters.leaves as f64 / rays,
        blob_evaluations_per_ray: measured.counters.blob_evaluations as f64 / rays,
        clipping: (engine.frame.engine == Engine::Sweep)
            .then(|| ClippingFigures::of(&measured.counters)),
        peel: tracing
            .peel_work()
            .map(|work| PeelFigures::of(&work, args.repeats)),
    };
    reporter.finish();
    let text = if args.json {
        serde_json::to_string_pretty(&report).map_err(|error| Failure::work(error.to_string()))?
    } else {
        table(&report)
    };
    writeln!(std::io::stdout(), "{text}")
        .map_err(|error| Failure::work(format!("cannot print: {error}")))
}

fn table(report: &BenchReport) -> String {
    let mut text = format!(
        "{} particles, engine {}, {}, {} threads, median of {} repeats\n\
         build {:.2} ms, {:.1} bytes a particle\n\
         {:<11}{:>10}{:>10}{:>10}{:>8}\n",
        report.particles,
        report.engine,
        report.simd,
        report.threads,
        report.repeats,
        report.build_secs * 1e3,
        report.bytes_per_particle,
        "pass",
        "rays",
        "Mray/s",
        "best",
        "hits",
    );
    if let Some(card) = &report.on_card {
        text += &format!(
            "sent to the card in {:.2} ms (built there in {:.2} ms), followed in {:.2} ms ({:.2} ms)\n",
            card.send_secs * 1e3,
            card.own_build_secs * 1e3,
            card.update_secs * 1e3,
            card.own_update_secs * 1e3,
        );
    }
    for (name, pass) in [
        ("primary", &report.primary),
        ("shadow", &report.shadow),
        ("hemisphere", &report.hemisphere),
        ("shuffled", &report.shuffled),
    ] {
        text += &format!(
            "{name:<11}{:>10}{:>10.3}{:>10.3}{:>7.1}%\n",
            pass.rays,
            pass.mrays_per_sec,
            pass.best_mrays_per_sec,
            pass.hit_fraction * 100.0
        );
    }
    text += &format!(
        "per primary ray: {:.2} nodes, {:.2} leaves, {:.1} blobs",
        report.nodes_per_ray, report.leaves_per_ray, report.blob_evaluations_per_ray
    );
    if let Some(clipping) = &report.clipping {
        text += &format!(
            ", {:.2} polynomials\n{:.2} iterations per polynomial, {} failures",
            clipping.polynomials_per_ray,
            clipping.clip_iterations_per_polynomial,
            clipping.clip_failures
        );
    }
    if let Some(peel) = &report.peel {
        text += &format!(
            "\npeel: lists {:.3} ms, sprites {:.3} ms, solve {:.3} ms by the card's own clock\n\
             {:.0} layers, {:.0} balls listed, {:.2e} of the rays left to the tree",
            peel.lists_secs * 1e3,
            peel.sprites_secs * 1e3,
            peel.solve_secs * 1e3,
            peel.layers,
            peel.listed,
            peel.left_fraction
        );
    }
    text
}
