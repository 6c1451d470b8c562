//! Where a ray's search may end, by single blobs (Ray Tracing Gems II §35.4, "Tracing toward frontface"
//! and "Tracing toward backface").

use crate::primitive::AlongLine;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

/// What the blobs met so far say about the end of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ends {
    /// Where g reaches this any single blob reaches the threshold; at least 1 where none is sure to.
    inner_level: f32,
    /// Inner spheres entered before this do not count.
    beyond: f32,
    /// Where the ray enters the first inner sphere: coming from outside, it has crossed by there.
    pub(super) inner: f32,
    /// Where the ray leaves the last support.
    pub(super) last_exit: f32,
}

impl Ends {
    /// Before any blob is met.
    pub(super) fn new(inner_level: f32, beyond: f32) -> Self {
        Self {
            inner_level,
            beyond,
            inner: f32::INFINITY,
            last_exit: 0.0,
        }
    }

    /// Notes the blobs of `meets` on a line that begins `near` along the ray.
    #[inline(always)]
    pub(super) fn note<S: Simd>(
        &mut self,
        simd: S,
        line: &AlongLine<f32x16<S>>,
        meets: <f32x16<S> as SimdBase<S>>::Mask,
        near: f32,
    ) {
        let zero = f32x16::splat(simd, 0.0);
        let beta = meets.select(line.beta, f32x16::splat(simd, 1.0));
        let half = (line.g0.max(zero) / beta).sqrt();
        let exit = meets.select(line.c + half, zero).reduce_max();
        self.last_exit = self.last_exit.max(near + exit);
        if self.inner_level >= 1.0 {
            return;
        }
        let rise = line.g0 - self.inner_level;
        let pierces = meets & rise.simd_gt(zero);
        if pierces.to_bitmask() == 0 {
            return;
        }
        let enter = line.c - (rise.max(zero) / beta).sqrt();
        let ahead = pierces & enter.simd_gt(f32x16::splat(simd, self.beyond - near));
        let enter = ahead.select(enter, f32x16::splat(simd, f32::INFINITY));
        self.inner = self.inner.min(near + enter.reduce_min());
    }
}
