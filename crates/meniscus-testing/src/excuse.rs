//! When a difference from the oracle is excused, and when it is an error.
//!
//! An answer is right when it names the oracle's crossing within the tolerance of t, with the right
//! direction, normal and strongest blob. Another answer is excused only if |F − T| stays within
//! [`tolerance::FIELD`] of its scale wherever the two disagree: between the two t, over the whole of
//! each excursion that one of them does not see, and between the start and a crossing where rounding
//! decides on which side the ray starts. A ray with a stated side that hits its own start is never
//! excused.

use crate::oracle::Oracle;
use crate::tolerance::{self, f32_ulp};
use meniscus::intersect::{BlobHit, Crossing};
use meniscus::math::ray::{Ray, Side};

/// Why a difference is excused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// F − T is within the band all the way between the two t.
    FlatCrossing,
    /// The answer leaves out excursions that never leave the band.
    SkippedExcursion,
    /// The answer counts a touch that ends within the band short of T.
    CountedTouch,
    /// Rounding decides on which side the ray starts.
    Start,
}

/// What is wrong with an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fault {
    /// There is a crossing, and the answer passes over it.
    Missed,
    /// There is no crossing at the answer's t.
    Invented,
    /// A ray with a stated side hits its own start.
    HitsItsStart,
    /// The crossing is there, but the ray enters where the answer says it leaves, or the reverse.
    Direction,
    /// The t is not a number or outside the ray's range.
    Range,
    /// The normal points elsewhere.
    Normal,
    /// Another blob is stronger.
    Strongest,
}

/// The judgement on one answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// Right.
    Match,
    /// Different for a stated reason; `magnitude` is the largest |F − T| in question.
    Excused {
        /// Why.
        reason: Reason,
        /// Largest |F − T| where the answers disagree.
        magnitude: f64,
    },
    /// Wrong.
    Wrong(Fault),
}

impl Verdict {
    /// Whether this is a real error.
    pub fn is_wrong(&self) -> bool {
        matches!(self, Self::Wrong(_))
    }
}

/// The tolerance of t on `ray` at `t`, in the ray's own parameter.
pub fn t_tolerance(oracle: &Oracle, ray: &Ray, t: f64) -> f64 {
    let field = oracle.field();
    let length = ray.direction.length();
    let local_hit = (ray.at(t) - field.origin).abs().max_element();
    let among_blobs = (t.abs() * length).min(oracle.diameter());
    let far = (ray.origin - field.origin)
        .abs()
        .max_element()
        .max(t.abs() * length);
    let distance = (tolerance::T_SPACINGS * f64::from(field.spacing))
        .max(tolerance::F32_ULPS * f32_ulp(local_hit.min(oracle.largest_coordinate())))
        .max(tolerance::F32_ULPS * f32_ulp(among_blobs))
        .max(tolerance::F64_ULPS * far * f64::EPSILON);
    distance / length
}

/// Judges an engine's first crossing.
pub fn judge_closest(oracle: &Oracle, ray: &Ray, answer: Option<&BlobHit>) -> Verdict {
    let Some(hit) = answer else {
        return match oracle.first(ray, None) {
            None => Verdict::Match,
            Some(_) => Case::new(oracle, ray).judge_miss(),
        };
    };
    if !ray.is_traceable() {
        return Verdict::Wrong(Fault::Invented);
    }
    if !(hit.t.is_finite() && hit.t >= ray.t_min && hit.t <= ray.t_max) {
        return Verdict::Wrong(Fault::Range);
    }
    let tolerance = t_tolerance(oracle, ray, hit.t);
    let place = match oracle.first(ray, Some(hit.t)) {
        Some(c) if (c.t - hit.t).abs() <= tolerance && c.entering == hit.entering => Verdict::Match,
        Some(c) if (c.t - hit.t).abs() <= tolerance => Verdict::Wrong(Fault::Direction),
        _ => Verdict::Wrong(Fault::Invented),
    };
    let place = match place {
        Verdict::Match => Verdict::Match,
        _ => Case::new(oracle, ray).judge_hit(hit),
    };
    if place.is_wrong() {
        return place;
    }
    match appearance_fault(oracle, ray, hit, tolerance) {
        Some(fault) => Verdict::Wrong(fault),
        None => place,
    }
}

/// Judges an engine's answer to whether there is any crossing.
pub fn judge_occluded(oracle: &Oracle, ray: &Ray, answer: bool) -> Verdict {
    let first = oracle.first(ray, None);
    match (first, answer) {
        (Some(_), true) | (None, false) => Verdict::Match,
        (Some(_), false) => Case::new(oracle, ray).judge_miss(),
        (None, true) => match oracle.nearly_occluded(ray) {
            Some(magnitude) => Verdict::Excused {
                reason: Reason::CountedTouch,
                magnitude,
            },
            None => Verdict::Wrong(Fault::Invented),
        },
    }
}

/// Judges an engine's list of all crossings of a ray: the stretches where the engine and the oracle
/// believe the ray on different sides must be within the tolerance of t or within the band.
pub fn judge_crossings(oracle: &Oracle, ray: &Ray, answer: &[Crossing]) -> Verdict {
    let expected = oracle.crossings(ray);
    let alternate = answer
        .windows(2)
        .all(|pair| pair[0].entering != pair[1].entering);
    let ordered = answer.windows(2).all(|pair| pair[0].t <= pair[1].t);
    if !(alternate && ordered) {
        return Verdict::Wrong(Fault::Direction);
    }
    let mut changes: Vec<f64> = answer.iter().chain(&expected).map(|c| c.t).collect();
    if changes
        .iter()
        .any(|t| !(*t >= ray.t_min && *t <= ray.t_max))
    {
        return Verdict::Wrong(Fault::Range);
    }
    changes.sort_by(f64::total_cmp);
    changes.push(ray.t_max);
    // Where one of the lists is empty its ray stays on the side on which the other's begins.
    let begins_inside = |list: &[Crossing]| list.first().map(|c| !c.entering);
    let (ours, theirs) = (begins_inside(answer), begins_inside(&expected));
    let (Some(mut ours), Some(mut theirs)) = (ours.or(theirs), theirs.or(ours)) else {
        return Verdict::Match;
    };
    let (mut next_ours, mut next_theirs) = (answer.iter().peekable(), expected.iter().peekable());
    let (mut from, mut magnitude) = (ray.t_min, None::<f64>);
    for to in changes {
        if ours != theirs && to - from > t_tolerance(oracle, ray, from) {
            let (flat, height) = if to.is_finite() {
                oracle.stays_in_band(ray, from, to)
            } else {
                (false, 0.0)
            };
            if !flat {
                return Verdict::Wrong(if ours { Fault::Invented } else { Fault::Missed });
            }
            magnitude = Some(magnitude.unwrap_or(0.0).max(height));
        }
        while let Some(c) = next_ours.next_if(|c| c.t <= to) {
            ours = c.entering;
        }
        while let Some(c) = next_theirs.next_if(|c| c.t <= to) {
            theirs = c.entering;
        }
        from = to;
    }
    magnitude.map_or(Verdict::Match, |magnitude| Verdict::Excused {
        reason: Reason::FlatCrossing,
        magnitude,
    })
}

/// What is wrong with the normal or the strongest blob of a hit, if anything.
fn appearance_fault(oracle: &Oracle, ray: &Ray, hit: &BlobHit, tolerance: f64) -> Option<Fault> {
    let [before, here, after] =
        [-tolerance, 0.0, tolerance].map(|shift| oracle.sample(ray.at(hit.t + shift)));
    let condition = here.absolute_slope / here.outward.length();
    if condition <= tolerance::NORMAL_CONDITION {
        let turned = before.outward.angle_between(after.outward);
        let angle = hit.outward.angle_between(here.outward);
        // Also catches an angle that is not a number.
        let right = angle <= tolerance::NORMAL_RADIANS * condition + turned;
        if !right {
            return Some(Fault::Normal);
        }
    }
    let strong_enough = |shift: f64, strongest: f64| {
        let strength = oracle.strength(hit.strongest, ray.at(hit.t + shift));
        strength >= strongest * (1.0 - tolerance::STRONGEST)
    };
    let strongest_is_right = strong_enough(0.0, here.strongest)
        || strong_enough(-tolerance, before.strongest)
        || strong_enough(tolerance, after.strongest);
    (!strongest_is_right).then_some(Fault::Strongest)
}

/// All there is to know about a ray whose answer is not simply right.
struct Case<'a> {
    oracle: &'a Oracle<'a>,
    ray: &'a Ray,
    /// Whether F > T at the start.
    above: bool,
    /// Sign changes of F − T on the ray and a little beyond its end.
    changes: Vec<Crossing>,
    /// How many of them only bring the field back to the stated side.
    returning: usize,
    tolerance_at_start: f64,
}

/// A list of crossings that an answer may stand in, with what it takes to believe in it.
struct Reading {
    crossings: Vec<Crossing>,
    reason: Option<Reason>,
    magnitude: f64,
}

impl<'a> Case<'a> {
    fn new(oracle: &'a Oracle<'a>, ray: &'a Ray) -> Self {
        let reach = if ray.t_max.is_finite() {
            t_tolerance(oracle, ray, ray.t_max)
        } else {
            0.0
        };
        let longer = ray.with_range(ray.t_min, ray.t_max + reach);
        let (above, changes) = oracle.sign_changes(&longer).unwrap_or_default();
        let wrong_side = match ray.side {
            Side::Unknown => false,
            Side::Outside => above,
            Side::Inside => !above,
        };
        Self {
            oracle,
            ray,
            above,
            changes,
            returning: usize::from(wrong_side),
            tolerance_at_start: t_tolerance(oracle, ray, ray.t_min),
        }
    }

    /// The oracle's own crossings, and those seen by one whom rounding puts on the other side of the
    /// surface where the ray starts.
    fn readings(&self) -> Vec<Reading> {
        let counted = &self.changes[self.returning.min(self.changes.len())..];
        let mut readings = vec![Reading {
            crossings: counted.to_vec(),
            reason: None,
            magnitude: 0.0,
        }];
        let start = self.ray.t_min;
        let (excess, band) = self.oracle.excess(self.ray, start);
        let first = self.changes.first();
        let first_is_near = first.is_some_and(|c| c.t - start <= self.tolerance_at_start);
        let (flat_to_first, height) = match first {
            Some(c) => self.oracle.stays_in_band(self.ray, start, c.t),
            None => (false, excess.abs()),
        };
        let in_band = excess.abs() <= band;
        let mut add = |crossings: Vec<Crossing>| {
            readings.push(Reading {
                crossings,
                reason: Some(Reason::Start),
                magnitude: if first_is_near { excess.abs() } else { height },
            });
        };
        if self.returning == 0 && (first_is_near || (in_band && flat_to_first)) {
            // Seen as starting on the side that the first crossing leads to.
            add(self.changes[1..].to_vec());
        }
        if self.returning == 1
            && let Some(again) = self.changes.get(1)
            && (again.t - start <= self.tolerance_at_start
                || self.oracle.stays_in_band(self.ray, start, again.t).0)
        {
            // Seen as not yet back on the stated side when it is left again.
            add(self.changes[3.min(self.changes.len())..].to_vec());
        }
        let at_start = Crossing {
            t: start,
            entering: self.above,
        };
        let from_start = || std::iter::once(at_start).chain(self.changes.iter().copied());
        // Seen as starting on the other side and coming over at once. With a stated side that holds
        // only where the ray goes deeper than rounding reaches: else it would hit its own start.
        let deep = !first_is_near && !flat_to_first;
        if in_band && (self.ray.side == Side::Unknown || (self.returning == 1 && deep)) {
            add(from_start().collect());
        }
        readings
    }

    /// Whether crossings `[0, count)` of a reading may be passed over, and the largest |F − T| there.
    fn may_skip(&self, crossings: &[Crossing]) -> Option<f64> {
        let mut worst = 0.0_f64;
        for pair in crossings.chunks(2) {
            let end = pair.get(1).map_or(self.ray.t_max, |c| c.t);
            if end - pair[0].t > t_tolerance(self.oracle, self.ray, pair[0].t) || pair.len() == 2 {
                let (flat, height) = if end.is_finite() {
                    self.oracle.stays_in_band(self.ray, pair[0].t, end)
                } else {
                    (false, 0.0)
                };
                if !flat {
                    return None;
                }
                worst = worst.max(height);
            }
        }
        Some(worst)
    }

    fn judge_miss(&self) -> Verdict {
        for reading in self.readings() {
            if let Some(height) = self.may_skip(&reading.crossings) {
                return Verdict::Excused {
                    reason: reading.reason.unwrap_or(Reason::SkippedExcursion),
                    magnitude: height.max(reading.magnitude),
                };
            }
        }
        Verdict::Wrong(Fault::Missed)
    }

    fn judge_hit(&self, hit: &BlobHit) -> Verdict {
        let tolerance = t_tolerance(self.oracle, self.ray, hit.t);
        for reading in self.readings() {
            for rank in (0..reading.crossings.len()).step_by(2) {
                let crossing = reading.crossings[rank];
                let Some(skipped) = self.may_skip(&reading.crossings[..rank]) else {
                    break;
                };
                if crossing.entering != hit.entering {
                    break;
                }
                let near = (crossing.t - hit.t).abs() <= tolerance;
                let (flat, height) = if near {
                    (true, 0.0)
                } else {
                    self.oracle.stays_in_band(self.ray, crossing.t, hit.t)
                };
                if !flat {
                    continue;
                }
                if near && rank == 0 && reading.reason.is_none() {
                    return Verdict::Match;
                }
                let usual = if rank > 0 {
                    Reason::SkippedExcursion
                } else {
                    Reason::FlatCrossing
                };
                return Verdict::Excused {
                    reason: reading.reason.unwrap_or(usual),
                    magnitude: skipped.max(height).max(reading.magnitude),
                };
            }
        }
        self.judge_touch(hit.t, Some(hit.entering), tolerance)
    }

    /// A hit where F − T comes close to 0 and turns back.
    fn judge_touch(&self, t: f64, entering: Option<bool>, tolerance: f64) -> Verdict {
        let counted = &self.changes[self.returning.min(self.changes.len())..];
        let before = counted.iter().filter(|c| c.t < t - tolerance).count();
        let leaves_inside = match self.ray.side {
            Side::Unknown => self.above,
            Side::Outside => false,
            Side::Inside => true,
        };
        let wrong = if self.ray.side != Side::Unknown && t - self.ray.t_min <= tolerance {
            Verdict::Wrong(Fault::HitsItsStart)
        } else if before > 0 {
            Verdict::Wrong(Fault::Missed)
        } else if entering == Some(leaves_inside) {
            Verdict::Wrong(Fault::Direction)
        } else {
            Verdict::Wrong(Fault::Invented)
        };
        let skipped = self.may_skip(&counted[..before - before % 2]);
        if wrong == Verdict::Wrong(Fault::HitsItsStart)
            || entering == Some(leaves_inside)
            || before % 2 == 1
            || skipped.is_none()
        {
            return wrong;
        }
        [0.0, -tolerance, tolerance]
            .into_iter()
            .map(|shift| self.oracle.excess(self.ray, t + shift))
            .find(|(excess, band)| excess.abs() <= *band)
            .map_or(wrong, |(excess, _)| Verdict::Excused {
                reason: Reason::CountedTouch,
                magnitude: excess.abs().max(skipped.unwrap_or(0.0)),
            })
    }
}

#[cfg(test)]
mod tests;
