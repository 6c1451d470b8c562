//! Engine `sweep`: every support along the ray, sorted, one Bézier polynomial per interval
//! (Nishita & Nakamae 1994; Kanamori, Szego & Nishita 2008), in float64.
//!
//! Along a ray one blob is g(s) = g₀ − β(s − c)² between its entry and its exit, and its field a
//! polynomial in g. Between two neighbouring events the set of blobs does not change, so F − T is one
//! polynomial there. It is summed anew for every interval from the blobs that are active (nothing is
//! added and later subtracted, so nothing drifts), relative to the interval's ends, where all numbers
//! are of order one.

mod bezier;
mod clipping;
mod events;

use super::{BlobHit, Counters, Crossing, Scratch};
use crate::accel::Accel;
use crate::accel::supports::{Segment, SupportTree};
use crate::field::{BlobField, FieldAt};
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::number::F64;
use crate::math::ray::{Ray, Side};
use crate::scene::Clipping;
use crate::with_kernel;
use bezier::{Bezier, Piece, first_rise, kernel_of};
use events::{Active, EventQueue};
use glam::DVec3;

/// Relative rounding error of a sum over the active blobs, rounded up.
const SUM_ERROR: f64 = 1e-13;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct SweepScratch {
    queue: EventQueue,
    active: Vec<Active>,
    pieces: Vec<Piece>,
}

/// First crossing.
pub fn closest(
    blobs: &Blobs,
    tree: &SupportTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    scratch.counters.rays += 1;
    first(blobs, tree, ray, scratch)
}

/// First crossing of a ray that is already counted.
pub(super) fn first(
    blobs: &Blobs,
    tree: &SupportTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    let mut found = None;
    sweep(blobs, tree, ray, scratch, |crossing, position, active| {
        let field = &blobs.field;
        let (outward, strongest) = with_kernel!(field.kernel, K => {
            outward_and_strongest::<K>(field.at(ray.time), position, active)
        });
        found = Some(BlobHit {
            t: crossing.t,
            outward,
            strongest,
            entering: crossing.entering,
        });
        false
    });
    found
}

/// Every crossing in order, in one pass.
pub fn crossings(
    blobs: &Blobs,
    tree: &SupportTree,
    ray: &Ray,
    scratch: &mut Scratch,
    crossings: &mut Vec<Crossing>,
) {
    scratch.counters.rays += 1;
    sweep(blobs, tree, ray, scratch, |crossing, _, _| {
        crossings.push(crossing);
        true
    });
}

/// Calls `visit` with each crossing, its local position and the blobs there, until it returns false.
fn sweep(
    blobs: &Blobs,
    tree: &SupportTree,
    ray: &Ray,
    scratch: &mut Scratch,
    visit: impl FnMut(Crossing, DVec3, &[Active]) -> bool,
) {
    // The papers' rules are for comparison: rays of other engines that need float64 need it right.
    let rule = match blobs.accel {
        Accel::Sweep(_) => blobs.settings.clipping,
        _ => Clipping::Own,
    };
    with_kernel!(blobs.field.kernel, K => {
        sweep_with::<K>(&blobs.field, rule, tree, ray, scratch, visit);
    });
}

fn sweep_with<K: KernelShape>(
    field: &BlobField,
    rule: Clipping,
    tree: &SupportTree,
    ray: &Ray,
    scratch: &mut Scratch,
    mut visit: impl FnMut(Crossing, DVec3, &[Active]) -> bool,
) {
    // Lengths squared of very long or short directions leave the range of f64: scale first.
    let largest = ray.direction.abs().max_element();
    let length = (ray.direction / largest).length() * largest;
    let mut segment = Segment {
        origin: ray.origin - field.origin,
        direction: ray.direction / largest / (length / largest),
        start: ray.t_min * length,
        end: ray.t_max * length,
        time_secs: ray.time,
    };
    let Some((near, _)) = tree
        .root()
        .and_then(|root| segment.overlap(tree.bounds(root)))
    else {
        return; // F = 0 on all of the ray
    };
    // Origins far away move next to the supports, so that what follows is relative to the scene.
    segment.origin += segment.direction * near;
    segment.start -= near;
    segment.end -= near;

    let Scratch {
        sweep: SweepScratch {
            queue,
            active,
            pieces,
        },
        counters,
        ..
    } = scratch;
    queue.start(tree, segment);
    active.clear();
    let threshold = f64::from(field.threshold);
    let mut state = None;
    let mut from = segment.start;
    loop {
        let event = queue.next(tree, field, counters);
        let to = event.map_or(segment.end, |event| event.s.min(segment.end));
        if to > from {
            let state =
                state.get_or_insert_with(|| State::at::<K>(ray.side, threshold, active, from));
            let report = |s: f64, entering| {
                let t = ((s + near) / length).clamp(ray.t_min, ray.t_max);
                let position = segment.origin + segment.direction * s;
                visit(Crossing { t, entering }, position, active)
            };
            let mut solver = RootFinder {
                rule,
                pieces: &mut *pieces,
                counters: &mut *counters,
            };
            if !interval::<K>(threshold, active, (from, to), state, &mut solver, report) {
                return;
            }
            from = to;
        }
        match event {
            Some(event) if event.s < segment.end => queue.apply(event, active),
            _ => return,
        }
    }
}

/// Where the ray is with respect to the surface.
#[derive(Debug, Clone, Copy)]
struct State {
    /// Whether the side that the next crossing leaves is the inside.
    inside: bool,
    /// Whether the field is still on the other side and has to come back first.
    returning: bool,
}

impl State {
    /// At the start of a ray whose side is stated or not.
    fn at<K: KernelShape>(side: Side, threshold: f64, active: &[Active], s: f64) -> Self {
        let value: f64 = active
            .iter()
            .map(|blob| blob.weight * kernel_of::<K>(blob.g(s).max(0.0)))
            .sum();
        let above = value > threshold;
        let inside = match side {
            Side::Unknown => above,
            Side::Outside => false,
            Side::Inside => true,
        };
        Self {
            inside,
            returning: inside != above,
        }
    }

    /// Whether F > T here.
    fn is_above(self) -> bool {
        self.inside != self.returning
    }
}

/// How roots are found, with what that takes.
struct RootFinder<'a> {
    rule: Clipping,
    pieces: &'a mut Vec<Piece>,
    counters: &'a mut Counters,
}

impl RootFinder<'_> {
    /// Where the curve first turns positive. The papers' rules look for any change of sign.
    fn first_rise(&mut self, curve: &Bezier, noise: f64) -> Option<f64> {
        self.counters.polynomials += 1;
        match self.rule {
            Clipping::Own => first_rise(curve, noise, self.pieces, self.counters),
            Clipping::Nishita => clipping::nishita(curve, self.pieces, self.counters),
            Clipping::Kanamori => clipping::kanamori(curve, self.pieces, self.counters),
        }
    }
}

/// Reports the crossings in the interval `[from, to]`; false when `report` wants no more.
fn interval<K: KernelShape>(
    threshold: f64,
    active: &[Active],
    (from, to): (f64, f64),
    state: &mut State,
    solver: &mut RootFinder<'_>,
    mut report: impl FnMut(f64, bool) -> bool,
) -> bool {
    let noise = SUM_ERROR * (threshold.abs() + active.iter().map(|b| b.weight.abs()).sum::<f64>());
    if stays::<K>(threshold, active, (from, to), state.is_above(), noise) {
        return true;
    }
    if let ([blob], true) = (active, solver.rule != Clipping::Own) {
        return alone::<K>(threshold, blob, (from, to), state, report);
    }
    let mut curve = bezier::expand::<K>(threshold, active, (from, to));
    if state.is_above() {
        curve = curve.negated();
    }
    let mut low = 0.0;
    while let Some(u) = solver.first_rise(&curve, noise) {
        low += (1.0 - low) * u;
        if state.returning {
            state.returning = false;
        } else {
            let entering = !state.inside;
            state.inside = entering;
            if !report(from + (to - from) * low, entering) {
                return false;
            }
        }
        if 1.0 - u < bezier::NARROWEST {
            break; // what is left is rounding; the next interval starts at this side
        }
        curve = curve.split(u).1.negated();
        curve.c[0] = curve.c[0].min(0.0);
    }
    true
}

/// Reports the crossings of a single blob's surface, a ball or an ellipsoid: the papers' single case,
/// in closed form.
fn alone<K: KernelShape>(
    threshold: f64,
    blob: &Active,
    (from, to): (f64, f64),
    state: &mut State,
    mut report: impl FnMut(f64, bool) -> bool,
) -> bool {
    let level = threshold / blob.weight;
    if !(level > 0.0 && level < 1.0) {
        return true;
    }
    // Not a number where the ray misses the surface: then no comparison below holds.
    let half = ((blob.g0 - K::g_at(level)) / blob.beta).sqrt();
    for (s, entering) in [(blob.center - half, true), (blob.center + half, false)] {
        if !(from <= s && s <= to) || state.is_above() == entering {
            continue;
        }
        if state.returning {
            state.returning = false;
            continue;
        }
        state.inside = entering;
        if !report(s, entering) {
            return false;
        }
    }
    true
}

/// Whether bounds of each blob's field already show that F stays above or below T: cheaper than the
/// polynomial, and enough for most intervals.
fn stays<K: KernelShape>(
    threshold: f64,
    active: &[Active],
    (from, to): (f64, f64),
    above: bool,
    noise: f64,
) -> bool {
    let mut bound = 0.0;
    for blob in active {
        let (g_from, g_to) = (blob.g(from), blob.g(to));
        // A lower bound of F takes positive weights at their least and negative ones at their most.
        let g = if (blob.weight > 0.0) == above {
            g_from.min(g_to)
        } else if from < blob.center && blob.center < to {
            blob.g0
        } else {
            g_from.max(g_to)
        };
        bound += blob.weight * kernel_of::<K>(g.max(0.0));
    }
    if above {
        bound > threshold + noise
    } else {
        bound < threshold - noise
    }
}

/// −∇F at a local position, and the blob with the largest |wᵢ kᵢ| (the first of equals).
fn outward_and_strongest<K: KernelShape>(
    at: FieldAt<'_>,
    position: DVec3,
    active: &[Active],
) -> (DVec3, u32) {
    let field = at.field();
    let mut outward = DVec3::ZERO;
    let (mut strongest, mut most) = (u32::MAX, -1.0);
    for blob in active {
        let i = blob.index as usize;
        let y = at.transform(i, position - at.center(i));
        let g = F64((1.0 - y.length_squared()).max(0.0));
        let weight = f64::from(field.weights[i]);
        outward += at.transform_transposed(i, y) * (2.0 * weight * K::slope(g).0);
        let strength = (weight * kernel_of::<K>(g.0)).abs();
        if strength > most || (strength == most && blob.index < strongest) {
            (strongest, most) = (blob.index, strength);
        }
    }
    (outward, strongest)
}

#[cfg(test)]
mod tests;
