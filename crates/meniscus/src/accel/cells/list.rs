//! Blobs as columns, as the build of cells filters them.

use super::layout::{Columns, LANES};
use super::unpack::row_of;
use crate::field::{BlobField, Span};
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

/// A list of blobs as columns: x, y, z, shape…, weight (as far as they vary), rates of motion (if they
/// move), and their indices. Every column is padded to whole chunks with blobs that reach nothing.
#[derive(Debug, Default, Clone)]
pub(super) struct BlobList {
    /// Blobs in the list; columns are longer.
    pub(super) count: usize,
    /// Which columns there are.
    pub(super) stored: Columns,
    /// `columns[k]` holds column k, `count` rounded up to [`LANES`] long plus one spare chunk.
    pub(super) columns: Vec<Vec<f32>>,
    /// Indices into the field.
    pub(super) indices: Vec<u32>,
    /// In how many pieces of the shutter bounds over parts of a cell are taken, at least 1; see
    /// [`moving`](super::moving).
    pub(super) pieces: usize,
    /// Scratch: lanes that reach a box, chunk by chunk.
    pub(super) reached: Vec<u16>,
}

impl BlobList {
    /// Empties the list and makes room for `capacity` blobs.
    pub(super) fn reset<P: Primitive>(&mut self, stored: Columns, capacity: usize) {
        let padded = capacity.next_multiple_of(LANES) + LANES;
        self.count = 0;
        self.stored = stored;
        self.columns.resize_with(stored.count::<P>(), Vec::new);
        for column in &mut self.columns {
            if column.len() < padded {
                column.resize(padded, 0.0);
            }
        }
        if self.indices.len() < padded {
            self.indices.resize(padded, 0);
        }
    }

    /// Replaces the list by `blobs` of `field`, as they move in `span`.
    pub(super) fn fill<P: Primitive>(
        &mut self,
        field: &BlobField,
        span: Span,
        stored: Columns,
        blobs: &[u32],
    ) {
        self.reset::<P>(stored, blobs.len());
        self.count = blobs.len();
        for (row, &blob) in blobs.iter().enumerate() {
            row_of::<P>(field, span, &stored, blob as usize, |k, value| {
                self.columns[k][row] = value;
            });
        }
        self.indices[..blobs.len()].copy_from_slice(blobs);
        self.pad::<P>();
    }

    /// Gives the lanes after the last blob values that no box reaches.
    pub(super) fn pad<P: Primitive>(&mut self) {
        let end = self.count.next_multiple_of(LANES);
        for (k, column) in self.columns.iter_mut().enumerate() {
            column[self.count..end].fill(self.stored.absent::<P>(k));
        }
        self.indices[self.count..end].fill(u32::MAX);
    }

    /// The shape's columns of the blob in row `i`.
    pub(super) fn shape<P: Primitive>(&self, i: usize) -> [f32; 6] {
        let mut shape = [0.0; 6];
        match &self.stored.shape {
            Some(constant) => shape = *constant,
            None => {
                for k in 0..P::COLUMNS {
                    shape[k] = self.columns[Columns::SHAPE + k][i];
                }
            }
        }
        shape
    }

    /// The smallest value of `of` over the shapes; infinite of an empty list.
    pub(super) fn smallest_of_shapes<P: Primitive>(&self, of: impl Fn(&[f32]) -> f32) -> f32 {
        let rows = if self.stored.shape.is_some() {
            self.count.min(1)
        } else {
            self.count
        };
        (0..rows)
            .map(|i| of(&self.shape::<P>(i)[..P::COLUMNS]))
            .fold(f32::INFINITY, f32::min)
    }
}

/// Sixteen numbers of column `k`.
#[inline(always)]
pub(super) fn lanes_at<S: Simd>(simd: S, list: &BlobList, k: usize, at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &list.columns[k][at..at + LANES])
}

/// The shape of sixteen blobs.
#[inline(always)]
pub(super) fn shape_at<S: Simd, P: Primitive>(
    simd: S,
    list: &BlobList,
    at: usize,
) -> [f32x16<S>; 6] {
    let mut shape = [f32x16::splat(simd, 0.0); 6];
    match &list.stored.shape {
        Some(constant) => {
            for k in 0..P::COLUMNS {
                shape[k] = f32x16::splat(simd, constant[k]);
            }
        }
        None => {
            for k in 0..P::COLUMNS {
                shape[k] = lanes_at(simd, list, Columns::SHAPE + k, at);
            }
        }
    }
    shape
}

/// The weights of sixteen blobs.
#[inline(always)]
pub(super) fn weight_at<S: Simd, P: Primitive>(simd: S, list: &BlobList, at: usize) -> f32x16<S> {
    match list.stored.weight {
        Some(constant) => f32x16::splat(simd, constant),
        None => lanes_at(simd, list, list.stored.weight_at::<P>(), at),
    }
}

/// Appends the lanes of `mask` of the chunk at `at` of `from` to the first `count` blobs of `to`.
#[inline(always)]
pub(super) fn copy_lanes<S: Simd>(
    simd: S,
    from: &BlobList,
    at: usize,
    mask: mask32x16<S>,
    to: &mut BlobList,
    count: usize,
) {
    let end = count + LANES;
    for (from, to) in from.columns.iter().zip(&mut to.columns) {
        f32x16::from_slice(simd, &from[at..at + LANES])
            .compress(mask)
            .store_slice(&mut to[count..end]);
    }
    u32x16::from_slice(simd, &from.indices[at..at + LANES])
        .compress(mask)
        .store_slice(&mut to.indices[count..end]);
}
