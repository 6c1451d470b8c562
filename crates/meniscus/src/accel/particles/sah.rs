//! The surface area heuristic with bins (Wald 2007): slower to build than along a curve, faster to
//! trace.

use super::topology::Split;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Candidate planes per axis, plus one.
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

/// Bins along the three axes.
type Bins = [[Bin; BINS]; 3];

/// From a place to the number of its bin.
#[derive(Debug, Clone, Copy)]
struct Grid {
    low: Vec3,
    /// 0 along axes without extent.
    scale: Vec3,
}

impl Grid {
    fn of(items: &[Item]) -> Self {
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
        let scale = Vec3::from_array((high - low).to_array().map(|extent| {
            let scale = BINS as f32 / extent;
            if extent > 0.0 && scale.is_finite() {
                scale
            } else {
                0.0
            }
        }));
        Self { low, scale }
    }

    fn bins(&self, item: &Item) -> [usize; 3] {
        let cell = (item.place() - self.low) * self.scale;
        cell.to_array().map(|bin| (bin as usize).min(BINS - 1))
    }

    fn fill(&self, items: &[Item]) -> Bins {
        let mut bins = [[Bin::EMPTY; BINS]; 3];
        for item in items {
            let places = self.bins(item);
            for axis in 0..3 {
                let bin = &mut bins[axis][places[axis]];
                bin.min = bin.min.min(item.min);
                bin.max = bin.max.max(item.max);
                bin.count += 1;
            }
        }
        bins
    }
}

fn joined(mut a: Bins, b: &Bins) -> Bins {
    for axis in 0..3 {
        for bin in 0..BINS {
            a[axis][bin] = a[axis][bin].union(&b[axis][bin]);
        }
    }
    a
}

/// The axis and first upper bin of the cheapest plane that leaves particles on both sides.
fn cheapest_plane(bins: &Bins) -> Option<(usize, usize)> {
    let mut best: Option<(f32, usize, usize)> = None;
    for (axis, bins) in bins.iter().enumerate() {
        let mut upper_cost = [0.0_f32; BINS];
        let mut upper = Bin::EMPTY;
        for bin in (1..BINS).rev() {
            upper = upper.union(&bins[bin]);
            upper_cost[bin] = upper.cost();
        }
        let all = upper.count + bins[0].count;
        let mut lower = Bin::EMPTY;
        for bin in 1..BINS {
            lower = lower.union(&bins[bin - 1]);
            if lower.count == 0 || lower.count == all {
                continue;
            }
            let cost = lower.cost() + upper_cost[bin];
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, bin));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

/// The builder.
pub(super) struct Sah;

impl Split for Sah {
    type Item = Item;

    fn split(&self, items: &mut [Item]) -> usize {
        let grid = Grid::of(items);
        let bins = if items.len() > PIECE {
            // Least and largest corners and counts: the order of joining does not matter.
            items
                .par_chunks(PIECE)
                .map(|piece| grid.fill(piece))
                .reduce(|| [[Bin::EMPTY; BINS]; 3], |a, b| joined(a, &b))
        } else {
            grid.fill(items)
        };
        let Some((axis, bin)) = cheapest_plane(&bins) else {
            // All at one place.
            return items.len() / 2;
        };
        let mut lower = 0;
        for i in 0..items.len() {
            if grid.bins(&items[i])[axis] < bin {
                items.swap(i, lower);
                lower += 1;
            }
        }
        lower
    }
}
