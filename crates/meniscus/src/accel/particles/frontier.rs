//! Walks the tree front to back. What is still to be visited stands sorted by where the ray enters it,
//! so nothing that is not yet visited reaches the ray before the frontier.

use super::{Elapsed, MovingFaces, ParticleTree};
use crate::accel::cells::layout::LEAF;
use crate::accel::cells::traverse::SlabRay;
use crate::math::simd::{splat3, xyz};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

/// A ray with its directions' signs, as lanes.
#[derive(Debug, Clone, Copy)]
pub struct Slabs<S: Simd> {
    origin: [f32x8<S>; 3],
    inverse: [f32x8<S>; 3],
    /// Which of the six bounds the ray meets first on each axis, and which last.
    near_row: [usize; 3],
    far_row: [usize; 3],
    end: f32x8<S>,
    /// How much of the shutter's time is over.
    elapsed: Elapsed<f32x8<S>>,
}

impl<S: Simd> Slabs<S> {
    /// From a ray at a time within the shutter.
    #[inline(always)]
    pub fn new(simd: S, ray: &SlabRay, tree: &ParticleTree, time_secs: f64) -> Self {
        let [open, close] = tree.shutter_secs;
        let elapsed = if close > open {
            ((time_secs - open) / (close - open)).clamp(0.0, 1.0) as f32
        } else {
            0.0
        };
        let row = |axis: usize, upper: bool| {
            if (ray.inverse[axis] < 0.0) == upper {
                axis
            } else {
                axis + 3
            }
        };
        Self {
            origin: splat3(simd, ray.origin),
            inverse: splat3(simd, ray.inverse),
            near_row: [row(0, false), row(1, false), row(2, false)],
            far_row: [row(0, true), row(1, true), row(2, true)],
            end: f32x8::splat(simd, ray.t_max),
            elapsed: Elapsed::new(
                f32x8::splat(simd, elapsed),
                f32x8::splat(simd, 1.0 - elapsed),
            ),
        }
    }
}

/// What is still to be visited, the nearest last: the parameter where the ray enters, as bits (those
/// of numbers that are not negative are in the numbers' order), above the reference.
#[derive(Debug, Default)]
pub struct Frontier {
    entries: Vec<u64>,
}

impl Frontier {
    /// Starts a ray.
    #[inline(always)]
    pub fn start(&mut self, tree: &ParticleTree) {
        self.entries.clear();
        if !tree.nodes.is_empty() {
            self.entries.push(0);
        }
    }

    /// Where the ray enters what is nearest; nothing unvisited lies before.
    #[inline(always)]
    pub fn near(&self) -> Option<f32> {
        self.entries
            .last()
            .map(|entry| f32::from_bits((entry >> 32) as u32))
    }

    /// Takes what is nearest: opens a node, or returns the number of a leaf.
    #[inline(always)]
    pub fn visit<S: Simd>(&mut self, simd: S, tree: &ParticleTree, ray: &Slabs<S>) -> Option<u32> {
        let reference = self.entries.pop()? as u32;
        if reference & LEAF != 0 {
            return Some(reference & !LEAF);
        }
        let index = reference as usize;
        self.open(simd, tree.faces(index), &tree.nodes[index].children, ray);
        None
    }

    /// What is nearest now, if it is a leaf.
    #[inline(always)]
    pub fn next_leaf(&self) -> Option<u32> {
        let reference = *self.entries.last()? as u32;
        (reference & LEAF != 0).then_some(reference & !LEAF)
    }

    #[inline(always)]
    fn open<S: Simd>(
        &mut self,
        simd: S,
        faces: MovingFaces<'_>,
        children: &[u32; 8],
        ray: &Slabs<S>,
    ) {
        let near = xyz(
            #[inline(always)]
            |axis| {
                let faces = faces_at(simd, &faces, ray, ray.near_row[axis]);
                (faces - ray.origin[axis]) * ray.inverse[axis]
            },
        );
        let far = xyz(
            #[inline(always)]
            |axis| {
                let faces = faces_at(simd, &faces, ray, ray.far_row[axis]);
                (faces - ray.origin[axis]) * ray.inverse[axis]
            },
        );
        let start = f32x8::splat(simd, 0.0);
        let near = near[0].max(near[1]).max(near[2].max(start));
        let far = far[0].min(far[1]).min(far[2].min(ray.end));
        let mut pierced = near.simd_le(far).to_bitmask() as u32;
        let near: [f32; 8] = near.to_array();
        while pierced != 0 {
            let slot = pierced.trailing_zeros() as usize & 7;
            pierced &= pierced - 1;
            // −0 would stand behind everything.
            let bits = near[slot].abs().to_bits();
            self.insert(u64::from(bits) << 32 | u64::from(children[slot]));
        }
    }

    #[inline(always)]
    fn insert(&mut self, entry: u64) {
        let mut at = self.entries.len();
        self.entries.push(entry);
        while at > 0 && self.entries[at - 1] < entry {
            self.entries[at] = self.entries[at - 1];
            at -= 1;
        }
        self.entries[at] = entry;
    }
}

/// One of the six faces of a node's children at the ray's time.
#[inline(always)]
fn faces_at<S: Simd>(simd: S, faces: &MovingFaces<'_>, ray: &Slabs<S>, row: usize) -> f32x8<S> {
    let open = f32x8::from_slice(simd, &faces.open[row]);
    let Some(close) = faces.close else {
        return open;
    };
    let straight = ray
        .elapsed
        .straight(open, f32x8::from_slice(simd, &close[row]));
    match faces.bulge {
        None => straight,
        Some(bulge) => ray
            .elapsed
            .bent(straight, f32x8::from_slice(simd, &bulge[row])),
    }
}
