//! The typical distance between particles.

use super::neighbours::BoxTree;
use crate::math::aabb::DAabb;
use glam::DVec3;
use rayon::prelude::*;
use std::cell::Cell;
use std::ops::Range;

/// How many points are enough for a typical distance: the median of as many varies by some tenths of
/// a percent.
const SAMPLES: usize = 1 << 16;

/// The median over all particles of the distance to the nearest particle at a non-zero distance, or
/// `None` when no two particles are apart. Positions must be finite. The result does not depend on
/// the number of threads; of an even number of distances it is the mean of the middle two.
pub fn median_spacing(positions: &[DVec3]) -> Option<f64> {
    median_spacing_in(&point_tree(positions), positions)
}

/// A tree over points.
pub fn point_tree(positions: &[DVec3]) -> BoxTree {
    BoxTree::build(positions.len(), |i| DAabb {
        min: positions[i],
        max: positions[i],
    })
}

/// [`median_spacing`] with the points' tree at hand.
pub fn median_spacing_in(tree: &BoxTree, positions: &[DVec3]) -> Option<f64> {
    // Along the curve, so that neighbours lie side by side in memory.
    let along: Vec<DVec3> = tree
        .order()
        .par_iter()
        .with_min_len(4096)
        .map(|&item| positions[item as usize])
        .collect();
    median_over(tree, |place| along[place], 1)
}

/// [`median_spacing_in`] from some 65,536 of the points, evenly along the curve; of fewer points it is
/// the same.
pub fn typical_spacing_in(tree: &BoxTree, positions: &[DVec3]) -> Option<f64> {
    let stride = positions.len() / SAMPLES;
    if stride < 2 {
        return median_spacing_in(tree, positions);
    }
    let order = tree.order();
    median_over(tree, |place| positions[order[place] as usize], stride)
        // Only copies of one point among them.
        .or_else(|| median_spacing_in(tree, positions))
}

/// The median over the points of every `stride`-th group, which stand at `point` of their place along
/// the curve.
fn median_over(
    tree: &BoxTree,
    point: impl Fn(usize) -> DVec3 + Sync,
    stride: usize,
) -> Option<f64> {
    let groups: Vec<(&DAabb, Range<usize>)> = tree.ranges().step_by(stride).collect();
    let mut squares: Vec<f64> = groups
        .par_iter()
        .with_min_len(64)
        .flat_map_iter(|(bounds, range)| nearest_of_group(tree, &point, bounds, range.clone()))
        .collect();
    median(&mut squares)
}

/// Squared distances from each point of a group to its nearest neighbour apart from it; infinite when
/// all points lie at one place.
fn nearest_of_group(
    tree: &BoxTree,
    point: &impl Fn(usize) -> DVec3,
    bounds: &DAabb,
    range: Range<usize>,
) -> Vec<f64> {
    let points: Vec<DVec3> = range.clone().map(point).collect();
    let mut nearest: Vec<f64> = points
        .iter()
        .map(|place| nearest_among(points.iter().copied(), place, f64::INFINITY))
        .collect();
    let limit = Cell::new(farthest_of(&nearest));
    tree.for_each_range(
        |other| {
            let gap = (other.min - bounds.max).max(bounds.min - other.max);
            // Subtrees that are nothing but this one point are skipped: duplicates cost nothing.
            let same_point = other.min == bounds.max && other.max == bounds.min;
            gap.max(DVec3::ZERO).length_squared() < limit.get() && !same_point
        },
        |other, others| {
            if others == range {
                return;
            }
            for (place, nearest) in points.iter().zip(&mut nearest) {
                let gap = (other.min - *place).max(*place - other.max);
                if gap.max(DVec3::ZERO).length_squared() < *nearest {
                    *nearest = nearest_among(others.clone().map(point), place, *nearest);
                }
            }
            limit.set(farthest_of(&nearest));
        },
    );
    nearest
}

/// The smallest squared distance from `point` to those of `points` that lie apart from it, if it is
/// below `limit`.
fn nearest_among(points: impl Iterator<Item = DVec3>, point: &DVec3, limit: f64) -> f64 {
    points.fold(limit, |nearest, other| {
        let square = point.distance_squared(other);
        if square > 0.0 && square < nearest {
            square
        } else {
            nearest
        }
    })
}

fn farthest_of(squares: &[f64]) -> f64 {
    squares.iter().copied().fold(0.0, f64::max)
}

/// The square root of the median of squared distances.
fn median(squares: &mut [f64]) -> Option<f64> {
    if squares.is_empty() {
        return None;
    }
    let middle = squares.len() / 2;
    let odd = squares.len() % 2 == 1;
    let (below, upper, _) = squares.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = upper.sqrt();
    let lower = if odd {
        upper
    } else {
        below.iter().fold(0.0, |a: f64, &b| a.max(b)).sqrt()
    };
    let median = lower * 0.5 + upper * 0.5;
    median.is_finite().then_some(median)
}

#[cfg(test)]
mod tests;
