//! `[engine]`: switches of the papers' engines. The default engine has none.

use serde::{Deserialize, Serialize};

/// What a leaf of n metaballs is taken to cost when metaballs are split in two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LeafCost {
    /// n, as for any primitive.
    N,
    /// n²: every projected centre is evaluated with every metaball (Gourmel et al. 2010, §5.1.1).
    #[default]
    N2,
}

/// How engine `sweep` finds the first root of a Bézier polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Clipping {
    /// Clipping and halving with a proof for every piece that is left out: finds every root.
    #[default]
    Own,
    /// Clip to the hull; halve where that is slow (Nishita, Sederberg & Kakimoto 1990; Nishita &
    /// Nakamae 1994).
    Nishita,
    /// Halve wherever the coefficients change sign more than once, else clip; a stack of three
    /// (Kanamori, Szego & Nishita 2008, §5.4).
    Kanamori,
}

/// How engines `particles` and `interval` group particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Builder {
    /// By the surface area heuristic: the faster rays.
    #[default]
    Sah,
    /// Along a Morton curve: the faster build.
    Morton,
    /// By the device that traces, along a Hilbert curve; engine `interval` builds as with `morton`.
    Device,
}

/// How the boxes of engines `particles` and `interval` follow blobs while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MotionBounds {
    /// Straight, unless that makes the boxes of the leaves larger by more than a curve costs.
    #[default]
    Auto,
    /// Straight from where they are when it opens to where they are when it closes, wide enough for
    /// bent ways.
    Linear,
    /// Along quadratic Bézier curves (Ray Tracing Gems II, §35.3); straight on a graphics card.
    Bezier,
}

/// What the leaves of engine `cells` hold of the blobs that reach them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Leaves {
    /// The blobs themselves: the faster rays.
    #[default]
    Copies,
    /// Where they are in the field, which rays look up: a fraction of the memory, and the same hits.
    Indices,
}

/// How engine `peel` finds what the rays through a tile of the film may meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PeelVariant {
    /// A list per tile, sorted by distance, that every ray of the tile walks.
    #[default]
    Tiles,
    /// Sprites of all supports, drawn over and over, nearest layer first (Kanamori, Szego & Nishita 2008).
    Sprites,
}

/// Most parts that [`EngineSettings::time_slabs`] may ask for: more cost more to build and to hold than
/// they save.
pub const MOST_TIME_SLABS: u32 = 8;

/// `[engine]`. Each key concerns the engines that its description names; others ignore it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EngineSettings {
    /// `metaball-bvh`, `fitted-bvh`: `n` or `n2`, the cost of a leaf.
    pub cost: LeafCost,
    /// `fitted-bvh`: whether boxes are fitted to the metaballs in them (§5.1.2). Off where a weight is
    /// negative, as the two below.
    pub fit: bool,
    /// `fitted-bvh`: whether fitted boxes reach only as far as a surface can (§5.3.1); needs `fit`.
    pub rmax_boxes: bool,
    /// `fitted-bvh`: whether split metaballs without part in the surface are left out (§5.3.2).
    pub discard: bool,
    /// `sweep`: `own`, `nishita` or `kanamori`; `peel` with sprites: `own` or `kanamori`.
    pub clipping: Clipping,
    /// `particles`, `interval`: `sah`, `morton` or `device`.
    pub builder: Builder,
    /// `particles`, `interval`: `auto`, `linear` or `bezier`, boxes of blobs that move.
    pub motion_bounds: MotionBounds,
    /// `cells`: into how many slabs of time the shutter is cut for blobs that move, up to
    /// [`MOST_TIME_SLABS`]; 0 leaves it to their motion.
    pub time_slabs: u32,
    /// `cells`: `copies` or `indices`, what leaves hold of their blobs.
    pub leaves: Leaves,
    /// `peel`: `tiles` or `sprites`.
    pub peel: PeelVariant,
}

impl Default for EngineSettings {
    fn default() -> Self {
        Self {
            cost: LeafCost::default(),
            fit: true,
            rmax_boxes: true,
            discard: true,
            clipping: Clipping::default(),
            builder: Builder::default(),
            motion_bounds: MotionBounds::default(),
            time_slabs: 0,
            leaves: Leaves::default(),
            peel: PeelVariant::default(),
        }
    }
}

impl EngineSettings {
    pub(super) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
