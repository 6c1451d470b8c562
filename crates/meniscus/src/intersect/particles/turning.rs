//! Sixteen blobs that turn and stretch: N(t) = I − tL + ½t²L² (see `field/turning.rs`).

use crate::accel::cells::layout::Block;
use crate::accel::particles::LeafTimes;
use crate::accel::particles::layout::TURN_COLUMNS;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::dot;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// Their velocity gradients L, row by row, times the time t.
pub(super) struct Turning<S: Simd>([[f32x16<S>; 3]; 3]);

impl<S: Simd> Turning<S> {
    /// Of a leaf's or a hit's columns at the ray's time.
    #[inline(always)]
    pub(super) fn of(simd: S, columns: &[Block], times: LeafTimes) -> Self {
        let columns = &columns[..TURN_COLUMNS];
        let secs = f32x16::splat(simd, times.since_frame_secs);
        Self(xyz(
            #[inline(always)]
            |row| {
                xyz(
                    #[inline(always)]
                    |k| f32x16::from_slice(simd, &columns[3 * row + k].0) * secs,
                )
            },
        ))
    }

    /// N·d.
    #[inline(always)]
    pub(super) fn turned(&self, d: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let once = self.moved(d);
        second_order(d, once, self.moved(once))
    }

    /// Nᵀ·y.
    #[inline(always)]
    pub(super) fn turned_back(&self, y: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        let transposed = Self(xyz(
            #[inline(always)]
            |row| [self.0[0][row], self.0[1][row], self.0[2][row]],
        ));
        transposed.turned(y)
    }

    #[inline(always)]
    fn moved(&self, d: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
        xyz(
            #[inline(always)]
            |row| dot(self.0[row], d),
        )
    }
}

/// d − first + ½·second.
#[inline(always)]
fn second_order<S: Simd>(
    d: [f32x16<S>; 3],
    first: [f32x16<S>; 3],
    second: [f32x16<S>; 3],
) -> [f32x16<S>; 3] {
    xyz(
        #[inline(always)]
        |k| {
            Number::mul_add(
                second[k],
                f32x16::splat(second[k].simd, 0.5),
                d[k] - first[k],
            )
        },
    )
}
