//! Along a Morton curve (Karras 2012): the fastest build. Particles of very different size are parted
//! first, two octaves to a class, so that a large one does not blow up the boxes of small ones.

use super::topology::Split;
use crate::field::BlobField;
use crate::math::morton::morton;
use glam::Vec3;
use rayon::prelude::*;

/// Bits per axis: 57 for the place, above them the class.
const BITS: u32 = 19;

/// A particle on the curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Item {
    code: u64,
    index: u32,
}

impl Item {
    /// The particle.
    pub(super) fn index(&self) -> u32 {
        self.index
    }
}

/// All particles in the order of the curve.
pub(super) fn along_curve(field: &BlobField) -> Vec<Item> {
    let centers = &field.centers;
    let (low, high) = centers
        .par_iter()
        .map(|&center| (Vec3::from_array(center), Vec3::from_array(center)))
        .reduce(
            || (Vec3::INFINITY, Vec3::NEG_INFINITY),
            |a, b| (a.0.min(b.0), a.1.max(b.1)),
        );
    let last = ((1_u32 << BITS) - 1) as f32;
    let extent = (high - low).max_element();
    // One scale for all axes; 0 where there is no extent.
    let scale = if extent > 0.0 { last / extent } else { 0.0 };
    let mut items: Vec<Item> = (0..centers.len() as u32)
        .into_par_iter()
        .map(|index| {
            let i = index as usize;
            // A cast from f32 saturates.
            let cell = ((field.center(i) - low) * scale).to_array();
            let cell = cell.map(|c| (c as u64).min((1 << BITS) - 1));
            let class = size_class(field.shapes.mean_radius(i));
            Item {
                code: class << (3 * BITS) | morton(cell),
                index,
            }
        })
        .collect();
    items.par_sort_unstable();
    items
}

/// Two octaves of the size, in six bits: particles of other classes are parted first.
pub fn size_class(radius: f64) -> u64 {
    (radius.log2() * 0.5 + 32.0).clamp(0.0, 63.0) as u64
}

/// The builder.
pub(super) struct Curve<'a> {
    field: &'a BlobField,
}

impl<'a> Curve<'a> {
    pub(super) fn new(field: &'a BlobField) -> Self {
        Self { field }
    }

    fn center(&self, item: &Item) -> Vec3 {
        self.field.center(item.index as usize)
    }
}

impl Split for Curve<'_> {
    const BOTTOM_BLOBS: usize = 96;

    type Item = Item;

    fn split(&self, items: &mut [Item]) -> usize {
        let differing = items[0].code ^ items[items.len() - 1].code;
        if differing != 0 {
            let bit = 1_u64 << differing.ilog2();
            return items.partition_point(|item| item.code & bit == 0);
        }
        // A cluster far smaller than the whole: the middle of its longest axis.
        let (low, high) =
            items
                .iter()
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), item| {
                    let center = self.center(item);
                    (low.min(center), high.max(center))
                });
        let size = high - low;
        let axis = (0..3).fold(
            0,
            |best, axis| {
                if size[axis] > size[best] { axis } else { best }
            },
        );
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            self.center(a)[axis]
                .total_cmp(&self.center(b)[axis])
                .then(a.index.cmp(&b.index))
        });
        middle
    }
}
