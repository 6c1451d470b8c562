//! A packet in one leaf: gathers the blobs that any of its rays meets, steps to the crossings, and
//! takes the gradient there.

use super::gather::ActiveLanes;
use super::step::{self, Stepped};
use super::{Job, Lanes, Outcome};
use crate::accel::cells::layout::LANES;
use crate::intersect::cells::LeafView;
use crate::kernel::KernelShape;
use crate::math::number::Number;
use crate::math::simd::xyz;
use crate::primitive::Primitive;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

impl LeafView<'_> {
    /// Where the lanes' segments begin, relative to the leaf's centre.
    #[inline(always)]
    fn origin<S: Simd>(&self, simd: S, lanes: &Lanes<'_, S>, near: f32x16<S>) -> [f32x16<S>; 3] {
        let near: [f32; LANES] = near.to_array();
        xyz(
            #[inline(always)]
            |axis| {
                let origin = &lanes.prepared.origin[axis];
                let direction = &lanes.prepared.direction[axis];
                let center = f64::from(self.header.center[axis]);
                let mut relative = [0.0; LANES];
                for lane in 0..LANES {
                    let along = direction[lane] * f64::from(near[lane]);
                    relative[lane] = (origin[lane] + along - center) as f32;
                }
                f32x16::from_slice(simd, &relative)
            },
        )
    }

    /// Traces the lanes of `mask` through the leaf; returns those that are done.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "one call, inlined")]
    pub(super) fn trace<
        S: Simd,
        K: KernelShape,
        P: Primitive,
        const MOVES: bool,
        const ALIKE: bool,
    >(
        &self,
        simd: S,
        job: &Job,
        lanes: &mut Lanes<'_, S>,
        active: &mut ActiveLanes,
        (mask, near, far): (u32, f32x16<S>, f32x16<S>),
        seen_leaf: &mut u32,
        outcomes: &mut [Outcome; LANES],
    ) -> u32 {
        if self.header.fine_beta < f32::INFINITY {
            set(outcomes, mask, Outcome::Alone);
            return mask;
        }
        let origin = self.origin(simd, lanes, near);
        let length = far - near;
        let gathered = self.gather::<S, K, P, MOVES, ALIKE>(
            simd,
            &job.alike,
            lanes,
            (mask, origin, length),
            active,
        );
        // The ray starts in a dropped cell, and whether that agrees with what it states is not known.
        let away = near
            .simd_gt(f32x16::splat(simd, job.start_margin))
            .to_bitmask() as u32;
        let doubtful =
            mask & away & !*seen_leaf & !lanes.on_stated_side & !lanes.prepared.side_is_proven;
        *seen_leaf |= mask;
        let reached = gathered
            .upper
            .simd_ge(f32x16::splat(simd, job.threshold))
            .to_bitmask() as u32;
        lanes.on_stated_side |= mask & !doubtful & !reached;
        let todo = mask & reached & !doubtful;
        let mut alone = doubtful;
        let mut done = 0;
        if todo != 0 {
            // Elsewhere a field above the threshold at entry means that the surface lies at this seam.
            let at_start = todo
                & !lanes.prepared.side_is_proven
                & !(lanes.on_stated_side & (away | !lanes.prepared.starts_at_t_min));
            let extent = origin[0]
                .abs()
                .max(origin[1].abs())
                .max(origin[2].abs())
                .max(length);
            let in_radii = job.alike.per_radius;
            let Stepped {
                crossed,
                unclear,
                at,
            } = step::first_crossings::<S, K, P, ALIKE>(
                simd,
                job,
                active,
                (todo, at_start),
                (length * in_radii, gathered.rise, gathered.last_approach),
                extent * in_radii,
            );
            let at = at / in_radii;
            let at_own_start = (near + at)
                .simd_lt(f32x16::splat(simd, job.near_start))
                .to_bitmask() as u32
                & lanes.prepared.starts_at_t_min
                & !lanes.prepared.side_is_proven;
            let unclear = unclear | crossed & at_own_start;
            let crossed = crossed & !unclear;
            alone |= unclear;
            done = crossed;
            lanes.on_stated_side |= todo & !crossed & !unclear;
            if crossed != 0 && job.any {
                set(
                    outcomes,
                    crossed,
                    Outcome::Hit {
                        t: 0.0,
                        outward: [0.0; 3],
                        strongest: 0,
                    },
                );
            } else if crossed != 0 {
                let point = xyz(
                    #[inline(always)]
                    |axis| Number::mul_add(lanes.direction[axis], at, origin[axis]),
                );
                let (outward, strongest) = self.gradient::<S, K, P, MOVES, ALIKE>(
                    simd,
                    &job.alike,
                    active,
                    point,
                    lanes.phase,
                );
                let (near, at): ([f32; LANES], [f32; LANES]) = (near.to_array(), at.to_array());
                for lane in 0..LANES {
                    if crossed >> lane & 1 == 1 {
                        outcomes[lane] = Outcome::Hit {
                            t: f64::from(near[lane]) + f64::from(at[lane]),
                            outward: [outward[0][lane], outward[1][lane], outward[2][lane]],
                            strongest: strongest[lane],
                        };
                    }
                }
            }
        }
        set(outcomes, alone, Outcome::Alone);
        done | alone
    }
}

#[inline(always)]
fn set(outcomes: &mut [Outcome; LANES], mask: u32, outcome: Outcome) {
    for (lane, slot) in outcomes.iter_mut().enumerate() {
        if mask >> lane & 1 == 1 {
            *slot = outcome;
        }
    }
}
