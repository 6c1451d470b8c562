//! Which blobs reach a box, and between which bounds their field lies in it.
//!
//! For a box and a blob, y = A(centre − p) and e = |A|·half bound q over the box by
//! qmin = Σ max(|yₖ| − eₖ, 0)² and qmax = Σ (|yₖ| + eₖ)², hence F by Σ w·k(qmin) and Σ w·k(qmax).
//! In a box smaller than the supports F at the centre, its gradient and a bound of its second
//! derivative bound F far better.

use super::layout::{Columns, LANES};
use crate::field::BlobField;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use glam::Vec3;

/// A list of blobs as columns: x, y, z, shape…, weight (as far as they vary), and their indices. Every
/// column is padded to whole chunks with blobs that reach nothing.
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

    /// Replaces the list by `blobs` of `field`.
    pub(super) fn fill<P: Primitive>(&mut self, field: &BlobField, stored: Columns, blobs: &[u32]) {
        self.reset::<P>(stored, blobs.len());
        self.count = blobs.len();
        for (row, &blob) in blobs.iter().enumerate() {
            let blob = blob as usize;
            for k in 0..3 {
                self.columns[k][row] = field.centers[blob][k];
            }
            if stored.shape.is_none() {
                let mut shape = [0.0; 6];
                P::pack(&field.shapes, blob, &mut shape[..P::COLUMNS]);
                for k in 0..P::COLUMNS {
                    self.columns[Columns::SHAPE + k][row] = shape[k];
                }
            }
            if stored.weight.is_none() {
                self.columns[stored.weight_at::<P>()][row] = field.weights[blob];
            }
        }
        self.indices[..blobs.len()].copy_from_slice(blobs);
        self.pad::<P>();
    }

    /// Gives the lanes after the last blob values that no box reaches.
    pub(super) fn pad<P: Primitive>(&mut self) {
        let end = self.count.next_multiple_of(LANES);
        for (k, column) in self.columns.iter_mut().enumerate() {
            let value = if k == 0 { self.stored.nowhere } else { 0.0 };
            column[self.count..end].fill(value);
        }
        if self.stored.shape.is_none() {
            for k in P::DIAGONAL {
                let narrow = 8.0 / self.stored.nowhere;
                self.columns[Columns::SHAPE + k][self.count..end].fill(narrow);
            }
        }
        self.indices[self.count..end].fill(u32::MAX);
    }

    /// The largest value of `of` over the shapes' columns; 0 of an empty list.
    pub(super) fn largest_of_shapes<P: Primitive>(&self, of: impl Fn(&[f32]) -> f32) -> f32 {
        if let Some(constant) = &self.stored.shape {
            return if self.count > 0 {
                of(&constant[..P::COLUMNS])
            } else {
                0.0
            };
        }
        (0..self.count)
            .map(|i| {
                let mut shape = [0.0; 6];
                for k in 0..P::COLUMNS {
                    shape[k] = self.columns[Columns::SHAPE + k][i];
                }
                of(&shape[..P::COLUMNS])
            })
            .fold(0.0, f32::max)
    }
}

/// Lower and upper bound of the field over a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct FieldBounds {
    pub(super) lower: f32,
    pub(super) upper: f32,
}

/// Sixteen numbers of column `k`.
#[inline(always)]
fn lanes_at<S: Simd>(simd: S, list: &BlobList, k: usize, at: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &list.columns[k][at..at + LANES])
}

/// The shape of sixteen blobs.
#[inline(always)]
fn shape_at<S: Simd, P: Primitive>(simd: S, list: &BlobList, at: usize) -> [f32x16<S>; 6] {
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
fn weight_at<S: Simd, P: Primitive>(simd: S, list: &BlobList, at: usize) -> f32x16<S> {
    match list.stored.weight {
        Some(constant) => f32x16::splat(simd, constant),
        None => lanes_at(simd, list, list.stored.weight_at::<P>(), at),
    }
}

struct BoxLanes<S: Simd> {
    center: [f32x16<S>; 3],
    half: [f32x16<S>; 3],
}

impl<S: Simd> BoxLanes<S> {
    #[inline(always)]
    fn new(simd: S, center: Vec3, half: Vec3) -> Self {
        Self {
            center: splat3(simd, center.to_array()),
            half: splat3(simd, half.to_array()),
        }
    }
}

/// Sums over blobs from which the bounds follow, sixteen partial sums each.
struct Sums<S: Simd> {
    /// Σ w·k at the farthest and nearest point of the box.
    lower: f32x16<S>,
    upper: f32x16<S>,
    /// F and ∇F at the centre.
    value: f32x16<S>,
    gradient: [f32x16<S>; 3],
    /// Bounds of −F″ and +F″ along any direction, anywhere in the box.
    concave: f32x16<S>,
    convex: f32x16<S>,
}

impl<S: Simd> Sums<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        Self {
            lower: zero,
            upper: zero,
            value: zero,
            gradient: [zero; 3],
            concave: zero,
            convex: zero,
        }
    }

    /// Adds the sixteen blobs at `at`; returns their qmin over the box.
    #[inline(always)]
    fn add<K: KernelShape, P: Primitive>(
        &mut self,
        simd: S,
        place: &BoxLanes<S>,
        list: &BlobList,
        at: usize,
        close: bool,
    ) -> f32x16<S> {
        let zero = f32x16::splat(simd, 0.0);
        let shape = shape_at::<S, P>(simd, list, at);
        let mut abs_shape = [zero; 6];
        for k in 0..P::COLUMNS {
            abs_shape[k] = shape[k].abs();
        }
        let shape = &shape[..P::COLUMNS];
        let weight = weight_at::<S, P>(simd, list, at);
        let positive = weight.max(zero);
        let negative = weight.min(zero);
        let y = P::transform(
            shape,
            xyz(
                #[inline(always)]
                |k| place.center[k] - lanes_at(simd, list, k, at),
            ),
        );
        let e = P::transform(&abs_shape[..P::COLUMNS], place.half);
        let near = xyz(
            #[inline(always)]
            |k| (y[k].abs() - e[k]).max(zero),
        );
        let far = xyz(
            #[inline(always)]
            |k| y[k].abs() + e[k],
        );
        let qmin = dot(near, near);
        let g_most = (qmin * -1.0 + 1.0).max(zero);
        let g_least = (dot(far, far) * -1.0 + 1.0).max(zero);
        let (most, least) = (K::of_g(g_most), K::of_g(g_least));
        self.upper = Number::mul_add(positive, most, Number::mul_add(negative, least, self.upper));
        self.lower = Number::mul_add(positive, least, Number::mul_add(negative, most, self.lower));
        if close {
            let g = (dot(y, y) * -1.0 + 1.0).max(zero);
            self.value = Number::mul_add(weight, K::of_g(g), self.value);
            let scale = weight * K::slope(g) * -2.0;
            let pull = P::transform_transposed(shape, y);
            for k in 0..3 {
                self.gradient[k] = Number::mul_add(scale, pull[k], self.gradient[k]);
            }
            // k″ along a unit u is 4k₂(yᵀAu)² − 2k₁|Au|² with k₁, k₂ the derivatives by g.
            let mut steepest = zero;
            for a in shape {
                steepest = Number::mul_add(*a, *a, steepest);
            }
            let reached = g_most.simd_gt(zero);
            let down = K::slope(g_most) * 2.0 * steepest;
            let up = (K::curvature(g_most) * 4.0 * (g_least * -1.0 + 1.0)
                - K::slope(g_least) * 2.0)
                .max(zero)
                * steepest;
            let (down, up) = (reached.select(down, zero), reached.select(up, zero));
            self.concave = Number::mul_add(positive, down, self.concave - negative * up);
            self.convex = Number::mul_add(positive, up, self.convex - negative * down);
        }
        qmin
    }

    #[inline(always)]
    fn bounds(self, half: Vec3, close: bool) -> FieldBounds {
        let (lower, upper) = (self.lower.reduce_sum(), self.upper.reduce_sum());
        if !close {
            return FieldBounds { lower, upper };
        }
        let value = self.value.reduce_sum();
        let [x, y, z] = self.gradient;
        let slope = x.reduce_sum().abs() * half.x
            + y.reduce_sum().abs() * half.y
            + z.reduce_sum().abs() * half.z;
        let reach = 0.5 * half.length_squared();
        FieldBounds {
            lower: lower.max(value - slope - reach * self.concave.reduce_sum()),
            upper: upper.min(value + slope + reach * self.convex.reduce_sum()),
        }
    }
}

/// Centre and half size of a box, rounded so that they cover it.
fn center_and_half(bounds: Aabb) -> (Vec3, Vec3) {
    (bounds.center(), bounds.size() * 0.500_000_2)
}

/// Bounds of the field of `list` over `bounds`, the tight kind.
#[inline(never)]
pub(super) fn field_bounds<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    bounds: Aabb,
) -> FieldBounds {
    simd.vectorize(
        #[inline(always)]
        || {
            let (center, half) = center_and_half(bounds);
            let place = BoxLanes::new(simd, center, half);
            let mut sums = Sums::new(simd);
            for at in (0..list.count).step_by(LANES) {
                sums.add::<K, P>(simd, &place, list, at, true);
            }
            sums.bounds(half, true)
        },
    )
}

/// The field of `list` at a point.
#[inline(never)]
pub(super) fn field_value<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    point: Vec3,
) -> f32 {
    simd.vectorize(
        #[inline(always)]
        || {
            let zero = f32x16::splat(simd, 0.0);
            let point: [f32x16<S>; 3] = splat3(simd, point.to_array());
            let mut sum = zero;
            for at in (0..list.count).step_by(LANES) {
                let shape = shape_at::<S, P>(simd, list, at);
                let y = P::transform(
                    &shape[..P::COLUMNS],
                    xyz(
                        #[inline(always)]
                        |k| point[k] - lanes_at(simd, list, k, at),
                    ),
                );
                let g = (dot(y, y) * -1.0 + 1.0).max(zero);
                let weight = weight_at::<S, P>(simd, list, at);
                sum = Number::mul_add(weight, K::of_g(g), sum);
            }
            sum.reduce_sum()
        },
    )
}

/// Writes the blobs of `from` that reach `bounds` to `to` and returns the field's bounds there. With
/// `close` the bounds include those of second order about the centre, worth their cost once the box
/// is no larger than the supports.
#[inline(never)]
pub(super) fn filter<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    from: &BlobList,
    bounds: Aabb,
    close: bool,
    to: &mut BlobList,
) -> FieldBounds {
    let column_count = from.stored.count::<P>();
    to.reset::<P>(from.stored, from.count);
    let result = simd.vectorize(
        #[inline(always)]
        || {
            let (center, half) = center_and_half(bounds);
            let place = BoxLanes::new(simd, center, half);
            let one = f32x16::splat(simd, 1.0);
            let mut sums = Sums::new(simd);
            let mut count = 0;
            for at in (0..from.count).step_by(LANES) {
                let qmin = sums.add::<K, P>(simd, &place, from, at, close);
                let reached = qmin.simd_lt(one);
                let bits = reached.to_bitmask();
                if bits == 0 {
                    continue;
                }
                let end = count + LANES;
                for k in 0..column_count {
                    lanes_at(simd, from, k, at)
                        .compress(reached)
                        .store_slice(&mut to.columns[k][count..end]);
                }
                u32x16::from_slice(simd, &from.indices[at..at + LANES])
                    .compress(reached)
                    .store_slice(&mut to.indices[count..end]);
                count += bits.count_ones() as usize;
            }
            to.count = count;
            sums.bounds(half, close)
        },
    );
    to.pad::<P>();
    result
}
