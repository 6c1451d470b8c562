//! Where to split a node: binned planes and the surface area heuristic with the cost of metaballs
//! (Wald 2007; Gourmel et al. 2010, §4.1, §5.1.1).

use super::fit::Member;
use crate::math::aabb::Aabb;
use crate::scene::LeafCost;
use glam::Vec3;

/// Bins per axis.
const BINS: usize = 16;

/// Disjoint children take at least this many bins of their parent: slivers, which the plain heuristic
/// likes where supports are much larger than boxes, multiply the tree and gain nothing.
const THINNEST: usize = 3;

/// Boxes narrower than this, in half extents of the smallest support in them, are not cut across. Boxes
/// fitted to where a surface barely enters are slivers of no width, which cuts divide at no cost in area.
const NARROW: f32 = 0.5;

/// A plane that parts a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    pub(super) axis: usize,
    pub(super) position: f32,
    /// Σ (area · cost of a leaf) over both children.
    pub(super) cost: f32,
}

/// Cost of intersecting a leaf of `count` metaballs.
pub(super) fn leaf_cost(cost: LeafCost, count: usize) -> f32 {
    let n = count as f32;
    match cost {
        LeafCost::N => n,
        LeafCost::N2 => n * n,
    }
}

/// Cost of visiting a node with two children, in units of [`leaf_cost`]. The paper states none; without
/// one, trees of a handful of metaballs per point are split without end.
pub(super) fn node_cost(cost: LeafCost) -> f32 {
    match cost {
        LeafCost::N => 1.0,
        LeafCost::N2 => 16.0,
    }
}

/// Metaballs of a bin and the box around their supports.
#[derive(Debug, Clone, Copy)]
struct Bin {
    count: usize,
    around: Aabb,
}

impl Bin {
    const EMPTY: Self = Self {
        count: 0,
        around: Aabb::EMPTY,
    };

    fn add(&mut self, around: Aabb) {
        self.count += 1;
        self.around = self.around.union(around);
    }

    fn merge(self, other: Self) -> Self {
        Self {
            count: self.count + other.count,
            around: self.around.union(other.around),
        }
    }
}

/// What is binned along one axis, and the planes between the bins.
struct Bins {
    low: f32,
    width: f32,
    /// By where metaballs begin (or by their centres).
    begin: [Bin; BINS],
    /// By where they end.
    end: [Bin; BINS],
}

impl Bins {
    fn new(low: f32, high: f32) -> Option<Self> {
        let width = (high - low) / BINS as f32;
        // Also false where the extent is too small to be divided, or not a number.
        (width > 0.0 && (1.0 / width).is_finite()).then_some(Self {
            low,
            width,
            begin: [Bin::EMPTY; BINS],
            end: [Bin::EMPTY; BINS],
        })
    }

    fn bin_of(&self, coordinate: f32) -> usize {
        (((coordinate - self.low) / self.width).max(0.0) as usize).min(BINS - 1)
    }

    /// The plane before bin `bin`.
    fn position(&self, bin: usize) -> f32 {
        self.low + self.width * bin as f32
    }

    /// The best of the planes by `cost` of what begins before it and what ends behind it.
    fn best(
        &self,
        axis: usize,
        thinnest: usize,
        cost: impl Fn(f32, Bin, Bin) -> Option<f32>,
    ) -> Option<Plane> {
        let mut behind = [Bin::EMPTY; BINS];
        let mut sum = Bin::EMPTY;
        for bin in (1..BINS).rev() {
            sum = sum.merge(self.end[bin]);
            behind[bin] = sum;
        }
        let mut best: Option<Plane> = None;
        let mut before = Bin::EMPTY;
        for bin in 1..BINS {
            before = before.merge(self.begin[bin - 1]);
            if bin < thinnest || bin > BINS - thinnest {
                continue;
            }
            let position = self.position(bin);
            if let Some(cost) = cost(position, before, behind[bin])
                && best.is_none_or(|best| cost < best.cost)
            {
                best = Some(Plane {
                    axis,
                    position,
                    cost,
                });
            }
        }
        best
    }
}

fn cheapest(planes: impl Iterator<Item = Plane>) -> Option<Plane> {
    planes.reduce(
        |best, plane| {
            if plane.cost < best.cost { plane } else { best }
        },
    )
}

/// The best plane through `bounds` for children that share no space: each holds what reaches into its
/// part, own and split alike, and is fitted to it if `fit`.
pub(super) fn disjoint(
    cost: LeafCost,
    fit: bool,
    own: &[Member],
    split: &[Member],
    bounds: Aabb,
) -> Option<Plane> {
    let smallest = (own.iter().chain(split)).fold(Vec3::INFINITY, |least, m| least.min(m.half));
    let along = |axis: usize| {
        if bounds.size()[axis] < NARROW * smallest[axis] {
            return None;
        }
        let mut bins = Bins::new(bounds.min[axis], bounds.max[axis])?;
        for member in own.iter().chain(split) {
            let around = member.support_box();
            let (begin, end) = (bins.bin_of(around.min[axis]), bins.bin_of(around.max[axis]));
            bins.begin[begin].add(around);
            bins.end[end].add(around);
        }
        bins.best(axis, THINNEST, |position, before, behind| {
            let (mut lower, mut upper) = (bounds, bounds);
            lower.max[axis] = position;
            upper.min[axis] = position;
            let priced = |part: Aabb, bin: Bin| {
                let kept = if fit {
                    overlap_of(part, bin.around)
                } else {
                    part
                };
                kept.half_area() * leaf_cost(cost, bin.count)
            };
            Some(priced(lower, before) + priced(upper, behind))
        })
    };
    cheapest((0..3).filter_map(along))
}

/// The best plane between centres for children that keep their metaballs whole; both get some.
pub(super) fn overlapping(cost: LeafCost, own: &[Member]) -> Option<Plane> {
    let centers = own.iter().fold(Aabb::EMPTY, |centers, member| Aabb {
        min: centers.min.min(member.center),
        max: centers.max.max(member.center),
    });
    let along = |axis: usize| {
        let mut bins = Bins::new(centers.min[axis], centers.max[axis])?;
        for member in own {
            let bin = bins.bin_of(member.center[axis]);
            bins.begin[bin].add(member.support_box());
            bins.end[bin].add(member.support_box());
        }
        bins.best(axis, 1, |_, before, behind| {
            let priced = |bin: Bin| bin.around.half_area() * leaf_cost(cost, bin.count);
            (before.count > 0 && behind.count > 0).then(|| priced(before) + priced(behind))
        })
    };
    cheapest((0..3).filter_map(along))
}

fn overlap_of(a: Aabb, b: Aabb) -> Aabb {
    Aabb {
        min: a.min.max(b.min),
        max: a.max.min(b.max),
    }
}
