//! The typical distance between particles.

use super::neighbours::BoxTree;
use crate::math::aabb::DAabb;
use glam::DVec3;
use rayon::prelude::*;

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
    let groups: Vec<&[u32]> = tree.groups().collect();
    let mut squares: Vec<f64> = groups
        .par_iter()
        .with_min_len(64)
        .flat_map_iter(|group| nearest_of_group(tree, positions, group))
        .collect();
    median(&mut squares)
}

/// Squared distances from each of `group` to its nearest neighbour apart from it; infinite when all
/// particles lie at one place.
fn nearest_of_group<'a>(
    tree: &'a BoxTree,
    positions: &'a [DVec3],
    group: &'a [u32],
) -> impl Iterator<Item = f64> + 'a {
    group.iter().map(move |&item| {
        let point = positions[item as usize];
        let nearest = |items: &[u32], limit: f64| {
            items.iter().fold(limit, |nearest, &other| {
                let square = point.distance_squared(positions[other as usize]);
                if square > 0.0 {
                    nearest.min(square)
                } else {
                    nearest
                }
            })
        };
        let mut best = nearest(group, f64::INFINITY);
        tree.for_each_group_nearer(point, best, |items| {
            best = nearest(items, best);
            best
        });
        best
    })
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
