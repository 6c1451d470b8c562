//! Kanamori et al. 2008, "GPU-based Fast Ray Casting for a Large Number of Metaballs": the CPU column of
//! table 1, what the two rules of Bézier clipping cost (§5.4), and on a card the GPU column, by engine
//! `peel`.
//!
//! Their CPU version is a ray caster with a BVH over the effective spheres, the clipping of Nishita &
//! Nakamae (1994), four threads and no packets: engine `sweep` with `engine.clipping=nishita`. Their
//! scene is metaballs of random places and radii; how much they overlap is not stated.

use super::{Measured, SIZE, Stage};
use crate::exit::Outcome;
use meniscus::accel::Engine;
use meniscus::scene::generate::Generator;
use meniscus::scene::{Clipping, EngineSettings, PeelVariant};

/// Pictures of table 1.
const SIZES: [[u32; 2]; 2] = [SIZE, [1024, 768]];

/// Metaballs of table 1.
const COUNTS: [usize; 4] = [10_000, 50_000, 100_000, 200_000];

/// Milliseconds of the CPU version in table 1, by picture and count.
const CPU_MILLIS: [[f64; 4]; 2] = [
    [589.5, 1014.8, 1469.5, 2265.4],
    [1455.8, 2495.2, 3593.9, 5491.3],
];

/// Milliseconds of the GPU version in table 1, by picture and count.
const GPU_MILLIS: [[f64; 4]; 2] = [[117.1, 191.6, 299.4, 523.6], [230.4, 366.3, 571.4, 980.4]];

fn clipped_by(clipping: Clipping) -> EngineSettings {
    EngineSettings {
        clipping,
        ..EngineSettings::default()
    }
}

fn millis(measured: &Measured) -> f64 {
    measured.counters.rays as f64 / measured.mrays_per_sec * 1e-3
}

/// Time of a picture without shading, and how it grows with the number of metaballs.
pub(super) fn table_1(stage: &Stage<'_>) -> Outcome<String> {
    let mut text = format!(
        "Kanamori et al. 2008, table 1, CPU column: time of a picture, growth against 10,000\n\
         {:<12}{:>10}{:>10}{:>10}{:>10}{:>10}\n",
        "picture", "metaballs", "ms", "growth", "paper's", "cells ms"
    );
    for (size, paper) in SIZES.into_iter().zip(CPU_MILLIS) {
        let mut first = None;
        for (count, paper_millis) in COUNTS.into_iter().zip(paper) {
            let set = stage.set(Generator::Scattered, count)?;
            let switches = clipped_by(Clipping::Nishita);
            let theirs = stage.measure_at(size, &set, Engine::Sweep, switches)?;
            let ours = stage.measure_at(size, &set, Engine::Cells, switches)?;
            let time = millis(&theirs);
            let start = *first.get_or_insert(time);
            text += &format!(
                "{:<12}{count:>10}{time:>10.1}{:>10.2}{:>10.2}{:>10.1}\n",
                format!("{}x{}", size[0], size[1]),
                time / start,
                paper_millis / paper[0],
                millis(&ours),
            );
        }
    }
    Ok(text)
}

/// Time of a picture without shading on a card, by its own clock where it has one, and of its stages.
pub(super) fn table_1_on_card(stage: &Stage<'_>) -> Outcome<String> {
    let card = stage.card()?;
    let mut text = format!(
        "Kanamori et al. 2008, table 1, GPU column: milliseconds of a picture on {}{}\n\
         {:<12}{:>10}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
        card.describe(),
        match card.is_software() {
            true => ", which is no card: these are no figures",
            false => "",
        },
        "picture",
        "metaballs",
        "tiles",
        "lists",
        "solve",
        "sprites",
        "lists",
        "draw",
        "solve",
        "paper's",
        "ratio",
    );
    for (size, paper) in SIZES.into_iter().zip(GPU_MILLIS) {
        for (count, paper_millis) in COUNTS.into_iter().zip(paper) {
            let set = stage.set(Generator::Scattered, count)?;
            let [tiles, sprites] = [PeelVariant::Tiles, PeelVariant::Sprites];
            let tiles = stage.measure_on_card(size, &set, tiles)?;
            let sprites = stage.measure_on_card(size, &set, sprites)?;
            text += &format!(
                "{:<12}{count:>10}{:>9.2}{:>9.2}{:>9.2}{:>9.2}{:>9.2}{:>9.2}{:>9.2}\
                 {paper_millis:>9.1}{:>9.1}\n",
                format!("{}x{}", size[0], size[1]),
                tiles.secs * 1e3,
                tiles.stages.lists * 1e3,
                tiles.stages.solve * 1e3,
                sprites.secs * 1e3,
                sprites.stages.lists * 1e3,
                sprites.stages.sprites * 1e3,
                sprites.stages.solve * 1e3,
                paper_millis * 1e-3 / tiles.secs,
            );
        }
    }
    text += "ratio: the paper's time over that of tiles, both cards as they are; its GeForce 8800 Ultra\n\
             does 387 Gflop/s (128 multiply-adds at 1.512 GHz)\n";
    Ok(text)
}

/// Iterations of the clipping rules and searches that they give up.
pub(super) fn clipping(stage: &Stage<'_>) -> Outcome<String> {
    let mut text = format!(
        "Kanamori et al. 2008, §5.4: clipping rules (the paper: more iterations than Nishita's, no figure)\n\
         {:<10}{:>10}{:>10}{:>14}{:>14}{:>10}{:>10}\n",
        "scene", "metaballs", "rule", "polynomials", "iterations", "failures", "speed"
    );
    for (generator, count) in [(Generator::Scattered, 100_000), (Generator::Pool, 10_000)] {
        let set = stage.set(generator, count)?;
        let rules = [
            ("nishita", Clipping::Nishita),
            ("kanamori", Clipping::Kanamori),
            ("own", Clipping::Own),
        ];
        let mut first = None;
        for (name, rule) in rules {
            let measured = stage.measure(&set, Engine::Sweep, clipped_by(rule))?;
            let counters = &measured.counters;
            let start = *first.get_or_insert(measured.mrays_per_sec);
            text += &format!(
                "{:<10}{count:>10}{name:>10}{:>14.2}{:>14.2}{:>10}{:>10.2}\n",
                generator.name(),
                measured.per_ray(counters.polynomials),
                counters.clip_iterations as f64 / counters.polynomials.max(1) as f64,
                counters.clip_failures,
                measured.mrays_per_sec / start,
            );
        }
    }
    text += "polynomials per ray, iterations per polynomial, speed against nishita\n";
    Ok(text)
}
