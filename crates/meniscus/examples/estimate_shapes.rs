//! How long `--anisotropy estimate` takes, beside the build of engine `particles` in Morton order.
//!
//! ```text
//! cargo run --release -p meniscus --example estimate_shapes -- [COUNT [THREADS]]
//! ```

#![allow(clippy::print_stdout, reason = "a command whose output is its purpose")]

use meniscus::accel::particles::ParticleTree;
use meniscus::field::BlobField;
use meniscus::scene::generate::Generator;
use meniscus::scene::{Anisotropy, BlobSettings, Builder, Weights};
use std::error::Error;
use std::time::Instant;

/// Repeats; medians are printed.
const REPEATS: usize = 7;

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
    let generated = Generator::Pool.generate(count, 1, None)?;
    let radius = generated.scene.surfaces.first().and_then(|s| s.radius);
    // Without volumes, whose time depends on the shapes too.
    let settings = |anisotropy| BlobSettings {
        support: radius.map(|radius| 4.0 * radius),
        weights: Weights::Unit,
        anisotropy,
        ..BlobSettings::default()
    };
    let field = |anisotropy| BlobField::from_particles(&generated.particles, &settings(anisotropy));
    let balls = field(Anisotropy::None)?.field;
    let mut times = [(); 3].map(|()| Vec::with_capacity(REPEATS));
    for _ in 0..REPEATS {
        // Side by side, so that a busy moment of the machine meets all.
        times[0].push(secs(|| drop(field(Anisotropy::None))));
        times[1].push(secs(|| drop(field(Anisotropy::Estimate))));
        times[2].push(secs(|| drop(ParticleTree::build(&balls, Builder::Morton))));
    }
    let [none, with, tree] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[REPEATS / 2]
    });
    println!(
        "{count} particles, {threads} threads: estimate {:.0} ms, Morton build {:.0} ms, {:.1} times as long",
        1e3 * (with - none),
        1e3 * tree,
        (with - none) / tree
    );
    Ok(())
}

fn secs(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
