//! Which blobs reach a box, and between which bounds their field lies in it.
//!
//! For a box and a blob, y = A(centre − p) and e = |A|·half bound q over the box by
//! qmin = Σ max(|yₖ| − eₖ, 0)² and qmax = Σ (|yₖ| + eₖ)², hence F by Σ w·k(qmin) and Σ w·k(qmax).
//! In a box smaller than the supports F at the centre, its gradient and a bound of its second
//! derivative bound F far better.

use super::layout::LANES;
use super::list::{BlobList, copy_lanes, lanes_at, shape_at, weight_at};
use super::moving;
use super::place::Place;
use crate::kernel::KernelShape;
use crate::math::aabb::Aabb;
use crate::math::number::Number;
use crate::math::simd::{splat3, xyz};
use crate::primitive::{Primitive, dot};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::Vec3;

/// Lower and upper bound of the field over a box.
#[derive(Debug, Clone, Copy)]
pub(super) struct FieldBounds {
    pub(super) lower: f32,
    pub(super) upper: f32,
}

impl FieldBounds {
    /// Of nowhere: the neutral element of [`FieldBounds::or`].
    pub(super) const NONE: Self = Self {
        lower: f32::INFINITY,
        upper: f32::NEG_INFINITY,
    };

    /// What both say.
    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            lower: self.lower.max(other.lower),
            upper: self.upper.min(other.upper),
        }
    }

    /// What either allows.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
        }
    }
}

/// Sixteen blobs' shapes and weights.
pub(super) struct BlobLanes<S: Simd, P> {
    shape: [f32x16<S>; 6],
    abs_shape: [f32x16<S>; 6],
    weight: f32x16<S>,
    positive: f32x16<S>,
    negative: f32x16<S>,
    primitive: std::marker::PhantomData<P>,
}

impl<S: Simd, P: Primitive> BlobLanes<S, P> {
    /// Those at `at`.
    #[inline(always)]
    pub(super) fn new(simd: S, list: &BlobList, at: usize) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        let shape = shape_at::<S, P>(simd, list, at);
        let mut abs_shape = [zero; 6];
        for k in 0..P::COLUMNS {
            abs_shape[k] = shape[k].abs();
        }
        let weight = weight_at::<S, P>(simd, list, at);
        Self {
            shape,
            abs_shape,
            weight,
            positive: weight.max(zero),
            negative: weight.min(zero),
            primitive: std::marker::PhantomData,
        }
    }

    /// A·v.
    #[inline(always)]
    pub(super) fn transformed(&self, v: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        P::transform(&self.shape[..P::COLUMNS], v)
    }

    /// |A|·half: how far A·x may be from its middle over a box.
    #[inline(always)]
    pub(super) fn extent(&self, half: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        P::transform(&self.abs_shape[..P::COLUMNS], half)
    }
}

/// How near blobs come at least where A(x − p) stays within `e` of `y`.
#[inline(always)]
pub(super) fn qmin<S: Simd>(simd: S, y: [f32x16<S>; 3], e: [f32x16<S>; 3]) -> f32x16<S> {
    let near = xyz(
        #[inline(always)]
        |k| (y[k].abs() - e[k]).max(f32x16::splat(simd, 0.0)),
    );
    dot(near, near)
}

/// How near and far blobs are over a box.
pub(super) struct Reached<S: Simd> {
    pub(super) qmin: f32x16<S>,
    g_most: f32x16<S>,
    g_least: f32x16<S>,
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
pub(super) struct Sums<S: Simd> {
    /// Σ w·k at the farthest and nearest point of the box.
    lower: f32x16<S>,
    upper: f32x16<S>,
    /// F and ∇F at the centre.
    value: f32x16<S>,
    gradient: [f32x16<S>; 3],
    /// Bounds of −F″ and +F″ along any direction, anywhere in the box; of blobs that move, times half the
    /// square of how far each may be displaced.
    concave: f32x16<S>,
    convex: f32x16<S>,
}

impl<S: Simd> Sums<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
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
        let blobs = BlobLanes::<S, P>::new(simd, list, at);
        let y = blobs.transformed(xyz(
            #[inline(always)]
            |k| place.center[k] - lanes_at(simd, list, k, at),
        ));
        let reached = self.add_reached::<K, P>(simd, &blobs, y, blobs.extent(place.half));
        if close {
            self.add_close::<K, P>(simd, &blobs, y, &reached, None);
        }
        reached.qmin
    }

    /// Adds to the bounds what blobs are at most and at least where A(x − p) stays within `e` of `y`.
    #[inline(always)]
    pub(super) fn add_reached<K: KernelShape, P: Primitive>(
        &mut self,
        simd: S,
        blobs: &BlobLanes<S, P>,
        y: [f32x16<S>; 3],
        e: [f32x16<S>; 3],
    ) -> Reached<S> {
        let zero = f32x16::splat(simd, 0.0);
        let far = xyz(
            #[inline(always)]
            |k| y[k].abs() + e[k],
        );
        let qmin = qmin(simd, y, e);
        let g_most = (qmin * -1.0 + 1.0).max(zero);
        let g_least = (dot(far, far) * -1.0 + 1.0).max(zero);
        let (most, least) = (K::of_g(g_most), K::of_g(g_least));
        let (positive, negative) = (blobs.positive, blobs.negative);
        self.upper = Number::mul_add(positive, most, Number::mul_add(negative, least, self.upper));
        self.lower = Number::mul_add(positive, least, Number::mul_add(negative, most, self.lower));
        Reached {
            qmin,
            g_most,
            g_least,
        }
    }

    /// Adds to value, gradient and curvature at the centre, where A(x − p) is `y`; the curvature times
    /// `reach` (half the square of how far the blob may be displaced), or 1. Returns ∇(w·k).
    #[inline(always)]
    pub(super) fn add_close<K: KernelShape, P: Primitive>(
        &mut self,
        simd: S,
        blobs: &BlobLanes<S, P>,
        y: [f32x16<S>; 3],
        reached: &Reached<S>,
        reach: Option<f32x16<S>>,
    ) -> [f32x16<S>; 3] {
        let zero = f32x16::splat(simd, 0.0);
        let shape = &blobs.shape[..P::COLUMNS];
        let g = (dot(y, y) * -1.0 + 1.0).max(zero);
        self.value = Number::mul_add(blobs.weight, K::of_g(g), self.value);
        let scale = blobs.weight * K::slope(g) * -2.0;
        let pull = P::transform_transposed(shape, y);
        let mut gradient = [zero; 3];
        for k in 0..3 {
            gradient[k] = scale * pull[k];
            self.gradient[k] = Number::mul_add(scale, pull[k], self.gradient[k]);
        }
        // k″ along a unit u is 4k₂(yᵀAu)² − 2k₁|Au|² with k₁, k₂ the derivatives by g.
        let mut steepest = zero;
        for a in shape {
            steepest = Number::mul_add(*a, *a, steepest);
        }
        if let Some(reach) = reach {
            steepest *= reach;
        }
        let (g_most, g_least) = (reached.g_most, reached.g_least);
        let is_reached = g_most.simd_gt(zero);
        let down = K::slope(g_most) * 2.0 * steepest;
        let up = (K::curvature(g_most) * 4.0 * (g_least * -1.0 + 1.0) - K::slope(g_least) * 2.0)
            .max(zero)
            * steepest;
        let (down, up) = (is_reached.select(down, zero), is_reached.select(up, zero));
        let (positive, negative) = (blobs.positive, blobs.negative);
        self.concave = Number::mul_add(positive, down, self.concave - negative * up);
        self.convex = Number::mul_add(positive, up, self.convex - negative * down);
        gradient
    }

    /// The bounds by what is at most and at least.
    #[inline(always)]
    pub(super) fn interval(&self) -> FieldBounds {
        FieldBounds {
            lower: self.lower.reduce_sum(),
            upper: self.upper.reduce_sum(),
        }
    }

    /// F at the centre, and by how much it may change towards the faces in first order.
    #[inline(always)]
    pub(super) fn value_and_slope(&self, half: Vec3) -> (f32, f32) {
        let [x, y, z] = self.gradient;
        let slope = x.reduce_sum().abs() * half.x
            + y.reduce_sum().abs() * half.y
            + z.reduce_sum().abs() * half.z;
        (self.value.reduce_sum(), slope)
    }

    /// `reach`: half the square of how far the faces are, or 1 where the sums hold it.
    #[inline(always)]
    pub(super) fn second_order(&self, (value, slope): (f32, f32), reach: f32) -> FieldBounds {
        FieldBounds {
            lower: value - slope - reach * self.concave.reduce_sum(),
            upper: value + slope + reach * self.convex.reduce_sum(),
        }
    }

    #[inline(always)]
    fn bounds(self, half: Vec3, close: bool) -> FieldBounds {
        let bounds = self.interval();
        if !close {
            return bounds;
        }
        let reach = 0.5 * half.length_squared();
        bounds.and(self.second_order(self.value_and_slope(half), reach))
    }
}

/// Centre and half size of a box, rounded so that they cover it.
fn center_and_half(bounds: Aabb) -> (Vec3, Vec3) {
    (bounds.center(), bounds.size() * 0.500_000_2)
}

/// Whether bounds of the field of `list` over `place`, of the tight kind, settle what is asked: `settled`
/// is called with them, where blobs move several times with wider and wider ones, as long as it says so.
#[inline(never)]
pub(super) fn is_settled<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    list: &BlobList,
    place: &Place,
    mut settled: impl FnMut(FieldBounds) -> bool,
) -> bool {
    if list.stored.moves() {
        return moving::is_settled::<S, K, P>(simd, list, place, settled);
    }
    let bounds = place.middle();
    let bounds = simd.vectorize(
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
    );
    settled(bounds)
}

/// The field of `list` at a point, in the middle of the shutter.
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

/// Writes the blobs of `from` that reach `place` to `to` and returns whether the field's bounds there
/// settle what is asked, as [`is_settled`]. With `close` the bounds include those of second order about
/// the centre, worth their cost once the box is no larger than the supports.
#[inline(never)]
pub(super) fn filter<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    from: &BlobList,
    place: &Place,
    close: bool,
    to: &mut BlobList,
    mut settled: impl FnMut(FieldBounds) -> bool,
) -> bool {
    if from.stored.moves() {
        return moving::filter::<S, K, P>(simd, from, place, close, to, settled);
    }
    let bounds = place.middle();
    to.reset::<P>(from.stored, from.count);
    let bounds_there = simd.vectorize(
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
                copy_lanes(simd, from, at, reached, to, count);
                count += bits.count_ones() as usize;
            }
            to.count = count;
            sums.bounds(half, close)
        },
    );
    to.pad::<P>();
    settled(bounds_there)
}
