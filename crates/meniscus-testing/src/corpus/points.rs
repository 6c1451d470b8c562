//! Ordinary scenes of a chosen size.

use super::{Recipe, Shape, Weighting};
use crate::random::Stream;
use glam::{DMat3, DQuat, DVec3};
use meniscus::kernel::Kernel;

fn balls(positions: Vec<DVec3>, radii: Vec<f64>, weights: Weighting, threshold: f64) -> Recipe {
    Recipe {
        positions,
        shape: Shape::Balls(radii),
        weights,
        kernel: Kernel::default(),
        threshold,
    }
}

/// Uniform in a cube; a blob overlaps about four others.
pub(super) fn scattered(count: usize) -> Recipe {
    let side = (count as f64).cbrt();
    let positions: Vec<DVec3> = (0..count as u64)
        .map(|i| Stream::new(1, i).cube() * side)
        .collect();
    balls(positions, vec![1.0; count], Weighting::Unit, 0.2)
}

/// The same in another unit of length and of the field.
pub(super) fn weighed(count: usize) -> Recipe {
    const RADIUS: f64 = 2.5;
    const WEIGHT: f64 = 0.35;
    let Recipe {
        mut positions,
        threshold,
        ..
    } = scattered(count);
    for position in &mut positions {
        *position *= RADIUS;
    }
    let weights = Weighting::Given(vec![WEIGHT; count]);
    balls(positions, vec![RADIUS; count], weights, threshold * WEIGHT)
}

/// A jittered lattice under a wave, with volume weights: a fluid at rest.
pub(super) fn pool(count: usize) -> Recipe {
    let side = (count as f64 * 2.5).cbrt().ceil() as usize;
    let mut positions = Vec::new();
    for i in 0..side * side * side {
        let mut random = Stream::new(2, i as u64);
        let cell = DVec3::new(
            (i % side) as f64,
            (i / side / side) as f64,
            (i / side % side) as f64,
        );
        let p = cell + (random.cube() - 0.5) * 0.6;
        let surface = side as f64 * (0.4 + 0.06 * (p.x * 0.9).sin() + 0.04 * (p.z * 1.3).cos());
        if p.y < surface {
            positions.push(p * 0.05);
        }
    }
    let radii = vec![0.1; positions.len()];
    balls(positions, radii, Weighting::Volume, 0.6)
}

/// A random chain with four bond lengths and van der Waals radii.
pub(super) fn molecule(count: usize, kernel: Kernel) -> Recipe {
    let threshold = 0.2;
    let to_support = 1.0 / kernel.q_at(threshold).unwrap_or(1.0).sqrt();
    let mut at = DVec3::ZERO;
    let home = (count as f64).cbrt();
    let (mut positions, mut radii) = (Vec::new(), Vec::new());
    for i in 0..count as u64 {
        let mut random = Stream::new(3, i);
        let pull = -at * (at.length() / home).powi(4) / home;
        at += (random.direction() + pull).normalize() * [1.09, 1.34, 1.47, 1.53][random.index(4)];
        positions.push(at);
        radii.push([1.1, 1.52, 1.55, 1.7, 1.8][random.index(5)] * to_support);
    }
    balls(positions, radii, Weighting::Unit, threshold)
}

/// Radii over six orders of magnitude, small ones crowding around larger ones.
pub(super) fn mixed_radii(count: usize) -> Recipe {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut radii: Vec<f64> = Vec::new();
    for i in 0..count {
        let mut random = Stream::new(4, i as u64);
        let radius = 10.0_f64.powf(-6.0 * i as f64 / count as f64);
        let position = if i < 6 {
            random.cube() * 2.0
        } else {
            let host = random.index(i / 2);
            positions[host] + random.direction() * radii[host] * random.range(0.3, 1.0)
        };
        positions.push(position);
        radii.push(radius);
    }
    balls(positions, radii, Weighting::Unit, 0.3)
}

/// Ellipsoids of random orientation with axes up to 10:1.
pub(super) fn ellipsoids(count: usize) -> Recipe {
    let side = (count as f64).cbrt();
    let mut axes = Vec::new();
    let positions = (0..count as u64)
        .map(|i| {
            let mut random = Stream::new(5, i);
            let turn = random.direction();
            let rotation = DQuat::from_axis_angle(turn, random.range(0.0, 6.3));
            let long = random.range(0.8, 1.6);
            let lengths = DVec3::new(long, long / random.range(1.0, 10.0), long / 10.0);
            axes.push(DMat3::from_quat(rotation) * DMat3::from_diagonal(lengths));
            random.cube() * side * 0.8
        })
        .collect();
    Recipe {
        positions,
        shape: Shape::Ellipsoids(axes),
        weights: Weighting::Unit,
        kernel: Kernel::default(),
        threshold: 0.25,
    }
}

/// Thin discs, 10:1, side by side and touching in a plane: long tangents along the surface.
pub(super) fn tangent_ellipsoids(count: usize) -> Recipe {
    let side = (count as f64).sqrt().ceil() as usize;
    let positions: Vec<DVec3> = (0..count)
        .map(|i| DVec3::new((i % side) as f64, 0.0, (i / side) as f64))
        .collect();
    let axes = DMat3::from_diagonal(DVec3::new(1.0, 0.1, 1.0));
    Recipe {
        shape: Shape::Ellipsoids(vec![axes; positions.len()]),
        positions,
        weights: Weighting::Unit,
        kernel: Kernel::default(),
        threshold: 0.4,
    }
}

/// Scattered blobs of which a third cut holes.
pub(super) fn negative(count: usize) -> Recipe {
    let side = (count as f64).cbrt() * 0.8;
    let (mut radii, mut weights) = (Vec::new(), Vec::new());
    let positions = (0..count as u64)
        .map(|i| {
            let mut random = Stream::new(6, i);
            let cuts = i % 3 == 2;
            radii.push(if cuts { 0.7 } else { 1.2 });
            weights.push(if cuts {
                -random.range(0.5, 2.0)
            } else {
                random.range(0.5, 1.5)
            });
            random.cube() * side
        })
        .collect();
    balls(positions, radii, Weighting::Given(weights), 0.25)
}
