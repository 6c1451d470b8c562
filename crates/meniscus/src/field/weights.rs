//! Volume weights: wᵢ = 1/Σⱼ k(qⱼ(xᵢ))·det Aⱼ/det Aᵢ over all j including i.
//!
//! Float64 on the particles' own numbers. Particles near each other are taken together: they share one
//! list of candidates, in structure-of-arrays blocks of eight. Lane l sums every eighth candidate, and
//! the lanes are added in order, so the result is the same to the last bit for any number of threads
//! and any SIMD level.

use super::supports::Supports;
use crate::kernel::{Kernel, KernelShape};
use crate::math::aabb::DAabb;
use crate::math::number::F64;
use crate::math::simd::Level;
use crate::particles::neighbours::BoxTree;
use crate::primitive::{Ball, Ellipsoid, Primitive};
use crate::with_kernel;
use fearless_simd::dispatch;
use glam::DVec3;
use rayon::prelude::*;

const LANES: usize = 8;
/// Rows of a block before the primitive's own columns: x, y, z, det A.
const HEADER: usize = 4;
/// Groups of particles per task.
const GROUPS: usize = 64;

/// Radii within this factor share the hierarchy of the points.
const SIMILAR: f64 = 2.0;

type Row = [f64; LANES];

/// The weights of all particles. `points` is a tree over the positions. Particles that come or go have
/// `scales` below 1: to others they count as much as their volume does, s³; to themselves in full.
pub(super) fn volume_weights(
    positions: &[DVec3],
    supports: &Supports,
    scales: Option<&[f64]>,
    kernel: Kernel,
    points: &BoxTree,
) -> Vec<f64> {
    let sums: Vec<Vec<f64>> = with_kernel!(kernel, K => match supports {
        Supports::Balls(_) => sums::<K, Ball, { HEADER + 1 }>(positions, supports, scales, points),
        Supports::Ellipsoids(_) => {
            sums::<K, Ellipsoid, { HEADER + 6 }>(positions, supports, scales, points)
        }
    });
    let mut weights = vec![0.0; positions.len()];
    for (&item, sum) in points.order().iter().zip(sums.into_iter().flatten()) {
        let item = item as usize;
        let own = supports.determinant(item);
        // k = 1 at the particle itself.
        let absent = scales.map_or(0.0, |scales| 1.0 - scales[item].powi(3));
        weights[item] = own / (sum + own * absent);
    }
    weights
}

/// Particles in the order of the tree, so that neighbours in space are neighbours in memory.
struct Neighbourhood<const S: usize> {
    /// x, y, z, det A and the primitive's columns.
    rows: Vec<[f64; S]>,
    boxes: Vec<DAabb>,
    tree: BoxTree,
}

/// Σⱼ k(qⱼ(x))·det Aⱼ at all particles, in tree order; `S` rows to a block.
fn sums<K: KernelShape, P: Primitive, const S: usize>(
    positions: &[DVec3],
    supports: &Supports,
    scales: Option<&[f64]>,
    points: &BoxTree,
) -> Vec<Vec<f64>> {
    let order = points.order();
    let boxes: Vec<DAabb> = order
        .par_iter()
        .map(|&item| supports.bounds(item as usize, positions[item as usize]))
        .collect();
    let points = points.ranked();
    let (smallest, largest) = supports.range();
    let neighbourhood = Neighbourhood::<S> {
        rows: order
            .par_iter()
            .map(|&item| {
                let item = item as usize;
                let mut row = row(positions[item], supports, item);
                if let Some(scales) = scales {
                    row[3] *= scales[item].powi(3);
                }
                row
            })
            .collect(),
        tree: if largest <= SIMILAR * smallest {
            points.refitted(|i| boxes[i])
        } else {
            BoxTree::build(boxes.len(), |i| boxes[i])
        },
        boxes,
    };
    let groups: Vec<&[u32]> = points.groups().collect();
    groups
        .par_chunks(GROUPS)
        .map_init(Vec::new, |blocks, groups| {
            neighbourhood.sums_of::<K, P>(groups, blocks)
        })
        .collect()
}

fn row<const S: usize>(position: DVec3, supports: &Supports, item: usize) -> [f64; S] {
    let mut row = [0.0; S];
    row[..3].copy_from_slice(&position.to_array());
    row[3] = supports.determinant(item);
    match supports {
        Supports::Balls(radii) => row[HEADER] = 1.0 / radii[item],
        Supports::Ellipsoids(factors) => row[HEADER..].copy_from_slice(&factors[item]),
    }
    row
}

impl<const S: usize> Neighbourhood<S> {
    fn position(&self, item: u32) -> DVec3 {
        let row = &self.rows[item as usize];
        DVec3::new(row[0], row[1], row[2])
    }

    fn sums_of<K: KernelShape, P: Primitive>(
        &self,
        groups: &[&[u32]],
        blocks: &mut Vec<[Row; S]>,
    ) -> Vec<f64> {
        let level = Level::new();
        let mut sums = Vec::new();
        let mut last = None;
        for group in groups {
            // Particles at one place share a sum: a heap of duplicates costs one.
            let place = self.position(group[0]);
            let one_place = group.iter().all(|&item| self.position(item) == place);
            if let Some((_, sum)) = last.filter(|&(at, _)| one_place && at == place) {
                sums.extend(group.iter().map(|_| sum));
                continue;
            }
            self.gather(group, blocks);
            dispatch!(level, _simd => {
                for &item in *group {
                    sums.push(sum_at::<K, P, S>(blocks, self.position(item)));
                }
            });
            last = sums.last().map(|&sum| (place, sum)).filter(|_| one_place);
        }
        sums
    }

    /// Blocks of the particles whose support may reach the box around the group.
    fn gather(&self, group: &[u32], blocks: &mut Vec<[Row; S]>) {
        blocks.clear();
        let region = group.iter().fold(DAabb::EMPTY, |region, &item| {
            region.including(self.position(item))
        });
        let mut count = 0;
        self.tree.for_each_group_overlapping(&region, |items| {
            for &item in items {
                let bounds = &self.boxes[item as usize];
                let apart = bounds.min.cmpgt(region.max) | region.min.cmpgt(bounds.max);
                if apart.any() {
                    continue;
                }
                let lane = count % LANES;
                if lane == 0 {
                    blocks.push([[0.0; LANES]; S]);
                }
                if let Some(block) = blocks.last_mut() {
                    for (row, value) in block.iter_mut().zip(&self.rows[item as usize]) {
                        row[lane] = *value;
                    }
                }
                count += 1;
            }
        });
    }
}

/// Σⱼ k(qⱼ(point))·det Aⱼ. Lanes beyond the last candidate have det A = 0.
#[inline(always)]
fn sum_at<K: KernelShape, P: Primitive, const S: usize>(blocks: &[[Row; S]], point: DVec3) -> f64 {
    let mut sums: Row = [0.0; LANES];
    for block in blocks {
        for (lane, sum) in sums.iter_mut().enumerate() {
            let d = [
                F64(point.x - block[0][lane]),
                F64(point.y - block[1][lane]),
                F64(point.z - block[2][lane]),
            ];
            let mut columns = [F64(0.0); 6];
            for (column, value) in columns[..P::COLUMNS].iter_mut().enumerate() {
                *value = F64(block[HEADER + column][lane]);
            }
            let y = P::transform(&columns[..P::COLUMNS], d);
            let q = y[0] * y[0] + y[1] * y[1] + y[2] * y[2];
            let g = 1.0 - q.0;
            let g = F64(if g > 0.0 { g } else { 0.0 });
            *sum += K::of_g(g).0 * block[3][lane];
        }
    }
    sums.iter().sum()
}
