//! Gourmel et al. 2010, "Fitted BVH for Fast Raytracing of Metaballs": tables 1, 3, 4 and 5. Table 2
//! compares effects of one renderer, which says nothing about structures.
//!
//! Theirs: trees built on one core, rays on a graphics card, frames a second over a camera path. Ours:
//! both on the processor, primary rays from one camera. The sets have the paper's names and sizes; how
//! dense theirs were is not stated.

use super::{Measured, Set, Stage};
use crate::exit::Outcome;
use meniscus::accel::Engine;
use meniscus::scene::EngineSettings;
use meniscus::scene::generate::Generator;

/// Fitting without the optimisations of §5.3.
const PLAIN: EngineSettings = EngineSettings {
    cost: meniscus::scene::LeafCost::N2,
    fit: true,
    rmax_boxes: false,
    discard: false,
    clipping: meniscus::scene::Clipping::Own,
    builder: meniscus::scene::Builder::Sah,
    motion_bounds: meniscus::scene::MotionBounds::Auto,
    time_slabs: 0,
    leaves: meniscus::scene::Leaves::Copies,
    peel: meniscus::scene::PeelVariant::Tiles,
};

/// A row of table 1: milliseconds of construction and frames a second, BVH then FBVH.
struct Row {
    generator: Generator,
    count: usize,
    build_millis: [f64; 2],
    fps: [f64; 2],
}

const TABLE_1: [Row; 6] = [
    Row {
        generator: Generator::Scattered,
        count: 30_000,
        build_millis: [101.0, 79.0],
        fps: [7.4, 9.4],
    },
    Row {
        generator: Generator::Scattered,
        count: 100_000,
        build_millis: [160.0, 150.0],
        fps: [3.3, 4.3],
    },
    Row {
        generator: Generator::Tornado,
        count: 4_000,
        build_millis: [8.0, 5.5],
        fps: [4.6, 11.0],
    },
    Row {
        generator: Generator::Tornado,
        count: 128_000,
        build_millis: [500.0, 290.0],
        fps: [1.0, 2.4],
    },
    Row {
        generator: Generator::Molecule,
        count: 5_440,
        build_millis: [8.9, 9.9],
        fps: [5.8, 17.7],
    },
    Row {
        generator: Generator::Pool,
        count: 10_000,
        build_millis: [41.0, 40.0],
        fps: [1.9, 7.1],
    },
];

/// Molecule and pool, the sets of tables 4 and 5.
const SMALL_SETS: [(Generator, usize); 2] =
    [(Generator::Molecule, 5_440), (Generator::Pool, 10_000)];

fn both(stage: &Stage<'_>, set: &Set) -> Outcome<[Measured; 2]> {
    let switches = EngineSettings::default();
    Ok([
        stage.measure(set, Engine::MetaballBvh, switches)?,
        stage.measure(set, Engine::FittedBvh, switches)?,
    ])
}

/// Construction times, and the speed of the FBVH against the BVH.
pub(super) fn table_1(stage: &Stage<'_>) -> Outcome<String> {
    let mut text = format!(
        "Gourmel et al. 2010, table 1: construction, and speed of FBVH over BVH\n\
         {:<10}{:>10}{:>10}{:>10}{:>12}{:>9}{:>13}{:>9}\n",
        "scene",
        "metaballs",
        "BVH ms",
        "FBVH ms",
        "build ratio",
        "paper's",
        "speed ratio",
        "paper's"
    );
    for row in &TABLE_1 {
        let set = stage.set(row.generator, row.count)?;
        let [bvh, fbvh] = both(stage, &set)?;
        text += &format!(
            "{:<10}{:>10}{:>10.1}{:>10.1}{:>12.2}{:>9.2}{:>13.2}{:>9.2}\n",
            row.generator.name(),
            row.count,
            bvh.build_secs * 1e3,
            fbvh.build_secs * 1e3,
            fbvh.build_secs / bvh.build_secs,
            row.build_millis[1] / row.build_millis[0],
            fbvh.mrays_per_sec / bvh.mrays_per_sec,
            row.fps[1] / row.fps[0],
        );
    }
    Ok(text)
}

/// What of the work is counted.
type Count = fn(&Measured) -> u64;

/// Traversals, intersection tests and metaballs considered per ray.
pub(super) fn table_3(stage: &Stage<'_>) -> Outcome<String> {
    let set = stage.set(Generator::Tornado, 4_000)?;
    let measured = both(stage, &set)?;
    let mut text = format!(
        "Gourmel et al. 2010, table 3: work per ray, tornado of 4,000 (the paper's size is not stated)\n\
         {:<24}{:>8}{:>8}{:>8}{:>10}\n",
        "", "BVH", "FBVH", "ratio", "paper's"
    );
    let rows: [(&str, Count, [f64; 2]); 3] = [
        ("node traversals", |m| m.counters.nodes, [9.3, 6.2]),
        ("intersection tests", |m| m.counters.leaves, [1.2, 0.5]),
        (
            "metaballs considered",
            |m| m.counters.blob_evaluations,
            [83.5, 35.1],
        ),
    ];
    for (name, count, paper) in rows {
        let [bvh, fbvh] = [0, 1].map(|i: usize| measured[i].per_ray(count(&measured[i])));
        text += &format!(
            "{name:<24}{bvh:>8.2}{fbvh:>8.2}{:>8.2}{:>10.2}\n",
            fbvh / bvh,
            paper[1] / paper[0]
        );
    }
    Ok(text)
}

/// What fitting brings, without the optimisations of §5.3.
pub(super) fn table_4(stage: &Stage<'_>) -> Outcome<String> {
    let mut text = format!(
        "Gourmel et al. 2010, table 4: fitting, with over without\n\
         {:<10}{:>12}{:>9}{:>13}{:>9}\n",
        "scene", "build ratio", "paper's", "speed ratio", "paper's"
    );
    let paper = [(9.2 / 8.7, 14.6 / 12.7), (37.0 / 35.0, 6.5 / 3.2)];
    for ((generator, count), (build, speed)) in SMALL_SETS.into_iter().zip(paper) {
        let set = stage.set(generator, count)?;
        let without = EngineSettings {
            fit: false,
            ..PLAIN
        };
        let without = stage.measure(&set, Engine::FittedBvh, without)?;
        let with = stage.measure(&set, Engine::FittedBvh, PLAIN)?;
        text += &format!(
            "{:<10}{:>12.2}{build:>9.2}{:>13.2}{speed:>9.2}\n",
            generator.name(),
            with.build_secs / without.build_secs,
            with.mrays_per_sec / without.mrays_per_sec,
        );
    }
    Ok(text)
}

/// What the optimisations of §5.3 bring.
pub(super) fn table_5(stage: &Stage<'_>) -> Outcome<String> {
    let mut text = format!(
        "Gourmel et al. 2010, table 5: speed with optimisations over without\n\
         {:<10}{:>12}{:>9}{:>12}{:>9}{:>8}{:>9}\n",
        "scene", "tight boxes", "paper's", "discarding", "paper's", "both", "paper's"
    );
    let paper = [[14.6, 15.3, 16.7, 17.7], [6.5, 6.7, 6.8, 7.1]];
    for ((generator, count), paper) in SMALL_SETS.into_iter().zip(paper) {
        let set = stage.set(generator, count)?;
        let speed = |rmax_boxes: bool, discard: bool| {
            let switches = EngineSettings {
                rmax_boxes,
                discard,
                ..PLAIN
            };
            stage
                .measure(&set, Engine::FittedBvh, switches)
                .map(|measured| measured.mrays_per_sec)
        };
        let none = speed(false, false)?;
        let [tight, discarding, all] = [
            speed(true, false)? / none,
            speed(false, true)? / none,
            speed(true, true)? / none,
        ];
        text += &format!(
            "{:<10}{tight:>12.2}{:>9.2}{discarding:>12.2}{:>9.2}{all:>8.2}{:>9.2}\n",
            generator.name(),
            paper[1] / paper[0],
            paper[2] / paper[0],
            paper[3] / paper[0],
        );
    }
    Ok(text)
}
