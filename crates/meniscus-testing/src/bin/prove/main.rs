//! Counts an engine's real errors over millions of rays, for BENCHMARKS.md:
//!
//! `cargo run --release -p meniscus-testing --bin prove -- --engine cells --rays 5000000`

#![allow(clippy::print_stdout, reason = "a command whose output is its purpose")]

mod scenes;

use clap::Parser;
use glam::DVec3;
use meniscus::accel::Engine;
use meniscus::frame::Blobs;
use meniscus::intersect::Scratch;
use meniscus::kernel::Kernel;
use meniscus::math::ray::Ray;
use meniscus::math::simd::{SimdLevel, level_name};
use meniscus::scene::{EngineSettings, Scene};
use meniscus_testing::corpus;
use meniscus_testing::examine::{Question, Tally, examine};
use meniscus_testing::oracle::Oracle;
use meniscus_testing::rays::{self, SurfacePoint};
use rayon::prelude::*;
use std::process::ExitCode;
use std::time::Instant;

/// Judge millions of rays of an engine by the float64 oracle.
#[derive(Debug, Parser)]
struct Arguments {
    /// The engine.
    #[arg(long, default_value = "cells", value_parser = engine)]
    engine: Engine,
    /// Switches of the engine as in a scene file, such as engine.clipping=kanamori (repeatable).
    #[arg(long = "set", value_name = "engine.KEY=VALUE")]
    settings: Vec<String>,
    /// Ordinary rays (half primary, half hemisphere) over all scenes and kernels together; grazing
    /// rays come on top with a sixth of that, inside rays with two fifths.
    #[arg(long, default_value_t = 5_000_000)]
    rays: usize,
    /// Scenes by name, separated by commas; default: all that can be had.
    #[arg(long, value_delimiter = ',')]
    scenes: Vec<String>,
    /// Kernels by name, separated by commas; default: all.
    #[arg(long, value_delimiter = ',', value_parser = kernel)]
    kernels: Vec<Kernel>,
    /// SIMD level.
    #[arg(long, default_value = "auto", value_parser = simd)]
    simd: SimdLevel,
    /// Threads; 0 for all.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn engine(name: &str) -> Result<Engine, String> {
    Engine::from_name(name).ok_or_else(|| format!("one of {:?}", Engine::ALL.map(Engine::name)))
}

fn switches(settings: &[String]) -> Result<EngineSettings, String> {
    let mut scene = Scene::default();
    for setting in settings {
        let (key, value) = setting
            .split_once('=')
            .ok_or_else(|| format!("{setting}: expected engine.KEY=VALUE"))?;
        scene
            .set(key, value)
            .map_err(|error| format!("{setting}: {error}"))?;
    }
    Ok(scene.engine)
}

fn kernel(name: &str) -> Result<Kernel, String> {
    Kernel::from_name(name).ok_or_else(|| format!("one of {:?}", Kernel::ALL.map(Kernel::name)))
}

fn simd(name: &str) -> Result<SimdLevel, String> {
    let found = SimdLevel::ALL.iter().find(|(known, _)| *known == name);
    let names = SimdLevel::ALL.map(|(known, _)| known);
    found
        .map(|(_, level)| *level)
        .ok_or_else(|| format!("one of {names:?}"))
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let Some(level) = arguments.simd.resolve() else {
        println!("this machine does not have the SIMD level");
        return ExitCode::from(2);
    };
    let switches = match switches(&arguments.settings) {
        Ok(switches) => switches,
        Err(reason) => {
            println!("{reason}");
            return ExitCode::from(2);
        }
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build_global();
    if let Err(error) = pool {
        println!("{error}");
        return ExitCode::FAILURE;
    }
    let kernels = if arguments.kernels.is_empty() {
        Kernel::ALL.to_vec()
    } else {
        arguments.kernels.clone()
    };
    let names: Vec<&str> = scenes::NAMES
        .into_iter()
        .filter(|name| arguments.scenes.is_empty() || arguments.scenes.iter().any(|s| s == name))
        .collect();
    if let Some(unknown) = arguments
        .scenes
        .iter()
        .find(|s| !scenes::NAMES.contains(&s.as_str()))
    {
        println!("there is no scene {unknown}; there are {:?}", scenes::NAMES);
        return ExitCode::from(2);
    }
    let share = arguments.rays / (names.len() * kernels.len()).max(1);
    println!(
        "engine {}, {}, {} scenes × {} kernels, {share} ordinary rays each\n",
        arguments.engine.name(),
        level_name(level),
        names.len(),
        kernels.len()
    );
    println!(
        "| scene | blobs | rays | count | hits | excused | largest \\|F − T\\| | real errors |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let start = Instant::now();
    let mut totals: Vec<(&str, Tally)> = Vec::new();
    for name in names {
        for &kernel in &kernels {
            let scene = match scenes::build(name, kernel) {
                Ok(scene) => scene,
                Err(reason) => {
                    println!("| {name} | left out: {reason} |");
                    break;
                }
            };
            let field = scene.field.clone();
            let blobs = Blobs::build_with(field, arguments.engine, switches, level);
            for (kind, tally) in prove(&blobs, &scene, share, arguments.seed) {
                print_row(&scene, kind, &tally);
                match totals.iter_mut().find(|(known, _)| *known == kind) {
                    Some((_, total)) => *total = std::mem::take(total).merge(tally),
                    None => totals.push((kind, tally)),
                }
            }
        }
    }
    println!("\nin all, {:.0} s:\n", start.elapsed().as_secs_f64());
    for (kind, total) in &totals {
        println!("{kind}: {total}");
    }
    let errors: usize = totals.iter().map(|(_, total)| total.real_errors()).sum();
    if errors == 0 {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

fn print_row(scene: &corpus::Scene, kind: &str, tally: &Tally) {
    println!(
        "| {} | {} | {kind} | {} | {} | {} | {:.1e} | {} |",
        scene.name,
        scene.field.len(),
        tally.rays,
        tally.hits,
        tally.excused_differences(),
        tally.largest_excused,
        tally.real_errors()
    );
    for example in &tally.examples {
        println!("\nREAL ERROR in {}, {kind}: {example}\n", scene.name);
    }
}

/// All kinds of rays in one scene.
fn prove(
    blobs: &Blobs,
    scene: &corpus::Scene,
    share: usize,
    seed: u64,
) -> Vec<(&'static str, Tally)> {
    let oracle = Oracle::new(&scene.field);
    let towards_eye = [
        DVec3::new(0.55, 0.75, -1.0),
        DVec3::new(-1.0, 0.2, 0.3),
        DVec3::new(0.1, 1.0, 0.2),
    ];
    let side = ((share as f64 / 6.0).sqrt().ceil() as usize).max(1);
    let primary: Vec<Ray> = towards_eye
        .into_iter()
        .flat_map(|eye| rays::primary(&oracle, side, eye))
        .collect();
    let mut points = surface_points(blobs, &oracle, &primary);
    if points.is_empty() {
        points = rays::surface_points(&oracle, share / 10, seed);
    }
    let some = |count: usize, seed: u64| -> Vec<SurfacePoint> {
        let mut random = meniscus_testing::random::Stream::new(seed, 0);
        (0..if points.is_empty() { 0 } else { count })
            .map(|_| points[random.index(points.len())])
            .collect()
    };
    let ask = |rays: Vec<Ray>| examine(blobs, &oracle, &rays, Question::Closest);
    let hemisphere = rays::hemisphere(&some(share / 2, seed + 10), seed + 11);
    let grazing = rays::grazing(&oracle, &some(share / 6, seed + 20), seed + 21);
    let inside = rays::inside(&oracle, &some(share * 2 / 5, seed + 30), seed + 31);
    let shadow = rays::shadow(
        &some(share / 10, seed + 40),
        DVec3::new(0.4, 0.8, -0.3).normalize(),
    );
    let mut bases = rays::hemisphere(&some(share / 80, seed + 50), seed + 51);
    bases.extend(rays::grazing(
        &oracle,
        &some(share / 160, seed + 52),
        seed + 53,
    ));
    bases.extend(shadow.iter().take(share / 80));
    bases.extend(primary.iter().step_by(40));
    let bundles = rays::bundles(&bases, seed + 54);
    let together = |question| examine(blobs, &oracle, &bundles, question);
    let (bundles_closest, bundles_any) = (
        together(Question::ClosestTogether),
        together(Question::AnyTogether),
    );
    vec![
        ("primary", ask(primary)),
        ("hemisphere", ask(hemisphere)),
        ("grazing", ask(grazing)),
        ("inside", ask(inside)),
        ("any hit", examine(blobs, &oracle, &shadow, Question::Any)),
        ("bundles", bundles_closest),
        ("bundles, any hit", bundles_any),
    ]
}

fn surface_points(blobs: &Blobs, oracle: &Oracle, rays: &[Ray]) -> Vec<SurfacePoint> {
    rays.par_iter()
        .map_init(Scratch::default, |scratch, ray| {
            let hit = blobs.closest(ray, scratch)?;
            let crossing = oracle.first(ray, Some(hit.t))?;
            Some(rays::point_at(oracle, ray.at(crossing.t)))
        })
        .flatten()
        .collect()
}
