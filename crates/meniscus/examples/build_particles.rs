//! How long engine `particles` takes to build, rebuild and refit, and how much memory it holds.
//!
//! ```text
//! cargo run --release -p meniscus --example build_particles -- [COUNT [THREADS]]
//! ```

#![allow(clippy::print_stdout, reason = "a command whose output is its purpose")]

use meniscus::accel::particles::ParticleTree;
use meniscus::field::BlobField;
use meniscus::scene::BlobSettings;
use meniscus::scene::Builder;
use meniscus::scene::generate::Generator;
use std::error::Error;
use std::time::Instant;

/// Repeats; the best and the middle time are printed.
const REPEATS: usize = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let number = |place: usize, default: usize| {
        std::env::args()
            .nth(place)
            .map_or(Ok(default), |text| text.parse())
    };
    let (count, threads) = (number(1, 1_000_000)?, number(2, 2)?);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()?;
    let particles = Generator::Pool.generate(count, 1, None)?.particles;
    let field = BlobField::from_particles(&particles, &BlobSettings::default())?.field;
    println!("{} balls, {threads} threads", field.len());
    for builder in [Builder::Sah, Builder::Morton] {
        let mut tree = ParticleTree::default();
        let build = times(|| tree = ParticleTree::build(&field, builder));
        let refit = times(|| tree.refit(&field));
        println!(
            "{builder:?}: build {:.1} ms (best {:.1}), refit {:.1} ms (best {:.1}), {:.1} bytes a ball",
            build[REPEATS / 2],
            build[0],
            refit[REPEATS / 2],
            refit[0],
            tree.structure_bytes() as f64 / field.len().max(1) as f64,
        );
    }
    Ok(())
}

/// Sorted times in milliseconds.
fn times(mut work: impl FnMut()) -> Vec<f64> {
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times
}
