//! How rays are traced, and on what.

use clap::Args;

/// Engine options.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Engine")]
pub(crate) struct EngineArgs {
    /// Acceleration structure and solver: cells, particles, interval, metaball-bvh,
    /// fitted-bvh, sweep; on a GPU particles, peel [default: cells; on a GPU particles]
    ///
    /// cells: engine.time_slabs=1 to 8, into how many parts the shutter's time is cut for blobs that
    /// move [default: 0, by their motion]; engine.leaves=copies|indices [default: copies], with indices
    /// its leaves take a fraction of the memory, and rays more time.
    /// The papers' engines have switches in the scene's table `engine`, so --set reaches them.
    /// metaball-bvh and fitted-bvh: engine.cost=n|n2 [default: n2]. fitted-bvh: engine.fit,
    /// engine.rmax_boxes and engine.discard, each true|false [default: true].
    /// sweep: engine.clipping=own|nishita|kanamori [default: own].
    /// particles, interval: engine.builder=sah|morton|device [default: sah]; with device the card
    /// builds the tree; engine.motion_bounds=auto|linear|bezier [default: auto], their boxes under
    /// an open shutter.
    /// peel: engine.peel=tiles|sprites [default: tiles]; with sprites engine.clipping=own|kanamori.
    #[arg(long, value_name = "NAME")]
    pub engine: Option<String>,
    /// Where to trace: cpu, gpu, auto [default: auto]
    ///
    /// auto: a graphics card where there is one that can do the work, else the processor; if the card
    /// fails in the middle of a picture, the processor does the rest. gpu: a card or an error.
    /// MENISCUS_GPU=off hides cards, MENISCUS_GPU=software lets --device gpu run on software drivers.
    #[arg(long, value_name = "NAME")]
    pub device: Option<String>,
    /// Threads; the result is the same for any number [default: one per logical core]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub threads: Option<usize>,
    /// Instruction set: auto, baseline, sse2, avx2, avx512, neon [default: auto]
    #[arg(long, value_name = "LEVEL")]
    pub simd: Option<String>,
}
