//! The surface area heuristic with bins along the widest axis (Wald 2007): slower to build than along a
//! curve, faster to trace.

use super::topology::{LEAF_BLOBS, Split};
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Shorter ranges are parted so that all leaves but one are full: a leaf is read as a whole, whatever it
/// holds.
const FULL_LEAVES: usize = 8 * LEAF_BLOBS;

/// Candidate planes, plus one.
const BINS: usize = 16;

/// Longer ranges are binned on several threads, in pieces of this length.
const PIECE: usize = 1 << 15;

/// A particle's box, its index in the bits of `min.w`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    min: Vec4,
    max: Vec4,
}

impl Item {
    /// Particle `index`, whose support lies within `half` of `center`.
    pub(super) fn new(index: u32, center: Vec3, half: Vec3) -> Self {
        Self {
            min: (center - half).extend(f32::from_bits(index)),
            max: (center + half).extend(0.0),
        }
    }

    /// The particle.
    pub(super) fn index(&self) -> u32 {
        self.min.w.to_bits()
    }

    /// Twice the box's centre.
    fn place(&self) -> Vec3 {
        self.min.truncate() + self.max.truncate()
    }
}

/// Some particles' boxes together, and how many they are. The fourth component means nothing.
#[derive(Debug, Clone, Copy)]
struct Bin {
    min: Vec4,
    max: Vec4,
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self {
        min: Vec4::INFINITY,
        max: Vec4::NEG_INFINITY,
        count: 0,
    };

    fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            count: self.count + other.count,
        }
    }

    /// Half the surface area times the count: what the bin costs a ray.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let size = self.max - self.min;
        (size.x * size.y + size.y * size.z + size.z * size.x) * self.count as f32
    }
}

/// Bins across one axis.
type Bins = [Bin; BINS];

/// From a place to the number of its bin.
#[derive(Debug, Clone, Copy)]
struct Grid {
    axis: usize,
    low: f32,
    scale: f32,
}

impl Grid {
    /// Across the widest axis of the items' places; `None` where they have no extent to speak of.
    fn of(items: &[Item]) -> Option<Self> {
        let ends = |items: &[Item]| {
            items
                .iter()
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
                    (low.min(item.place()), high.max(item.place()))
                })
        };
        let (low, high) = if items.len() > PIECE {
            items.par_chunks(PIECE).map(ends).reduce(
                || (Vec3::INFINITY, Vec3::NEG_INFINITY),
                |a, b| (a.0.min(b.0), a.1.max(b.1)),
            )
        } else {
            ends(items)
        };
        let extent = high - low;
        let axis = (1..3).fold(0, |widest, axis| {
            if extent[axis] > extent[widest] {
                axis
            } else {
                widest
            }
        });
        let scale = BINS as f32 / extent[axis];
        (extent[axis] > 0.0 && scale.is_finite()).then_some(Self {
            axis,
            low: low[axis],
            scale,
        })
    }

    fn bin(&self, item: &Item) -> usize {
        let place = item.min[self.axis] + item.max[self.axis];
        (((place - self.low) * self.scale) as usize).min(BINS - 1)
    }

    fn fill(&self, items: &[Item]) -> Bins {
        let mut bins = [Bin::EMPTY; BINS];
        for item in items {
            let bin = &mut bins[self.bin(item)];
            bin.min = bin.min.min(item.min);
            bin.max = bin.max.max(item.max);
            bin.count += 1;
        }
        bins
    }
}

fn joined(mut a: Bins, b: &Bins) -> Bins {
    for (a, b) in a.iter_mut().zip(b) {
        *a = a.union(b);
    }
    a
}

/// The first upper bin of the cheapest plane. The first and the last bin hold items, so every plane
/// leaves some on both sides.
fn cheapest_plane(bins: &Bins) -> usize {
    let mut upper_cost = [0.0_f32; BINS];
    let mut upper = Bin::EMPTY;
    for bin in (1..BINS).rev() {
        upper = upper.union(&bins[bin]);
        upper_cost[bin] = upper.cost();
    }
    let mut lower = Bin::EMPTY;
    let mut best = (f32::INFINITY, BINS / 2);
    for bin in 1..BINS {
        lower = lower.union(&bins[bin - 1]);
        let cost = lower.cost() + upper_cost[bin];
        if cost < best.0 {
            best = (cost, bin);
        }
    }
    best.1
}

/// Parts a few items where the lower ones fill whole leaves and the boxes cost least.
fn into_full_leaves(items: &mut [Item]) -> usize {
    let (low, high) = items
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
            (low.min(item.place()), high.max(item.place()))
        });
    let extent = high - low;
    let widest = |best: usize, axis: usize| {
        if extent[axis] > extent[best] {
            axis
        } else {
            best
        }
    };
    let axis = (1..3).fold(0, widest);
    items.sort_unstable_by(|a, b| {
        let order = a.place()[axis].total_cmp(&b.place()[axis]);
        order.then(a.index().cmp(&b.index()))
    });
    let mut parts = [Bin::EMPTY; FULL_LEAVES / LEAF_BLOBS];
    let mut leaves = 0;
    for (part, items) in parts.iter_mut().zip(items.chunks(LEAF_BLOBS)) {
        for item in items {
            part.min = part.min.min(item.min);
            part.max = part.max.max(item.max);
        }
        part.count = 1;
        leaves += 1;
    }
    let joined = |parts: &[Bin]| parts.iter().fold(Bin::EMPTY, |all, part| all.union(part));
    let mut best = (f32::INFINITY, 1);
    for first in 1..leaves {
        let cost = joined(&parts[..first]).cost() + joined(&parts[first..leaves]).cost();
        if cost < best.0 {
            best = (cost, first);
        }
    }
    best.1 * LEAF_BLOBS
}

/// The builder.
pub(super) struct Sah;

impl Split for Sah {
    const BOTTOM_BLOBS: usize = FULL_LEAVES;

    type Item = Item;

    fn split(&self, items: &mut [Item]) -> usize {
        if items.len() <= FULL_LEAVES {
            return into_full_leaves(items);
        }
        let Some(grid) = Grid::of(items) else {
            // All at one place.
            return items.len() / 2;
        };
        let bins = if items.len() > PIECE {
            // Least and largest corners and counts: the order of joining does not matter.
            items
                .par_chunks(PIECE)
                .map(|piece| grid.fill(piece))
                .reduce(|| [Bin::EMPTY; BINS], |a, b| joined(a, &b))
        } else {
            grid.fill(items)
        };
        let plane = cheapest_plane(&bins);
        let mut lower = 0;
        for i in 0..items.len() {
            if grid.bin(&items[i]) < plane {
                items.swap(i, lower);
                lower += 1;
            }
        }
        lower
    }
}
