//! A ray's own start, where f32 cannot tell leaving the surface from entering it.

use super::T_TOLERANCE_SPACINGS;
use super::local::LocalRay;
use crate::frame::Blobs;
use crate::math::aabb::Aabb;
use crate::math::ray::Side;

/// What lies this close to t_min may hold the start although rounding says otherwise; `bounds` is the box
/// around the structure.
pub(in crate::intersect) fn start_margin(bounds: Option<Aabb>) -> f32 {
    4e-6 * bounds.map_or(0.0, |b| b.size().max_element())
}

/// Whether float64 sees the point `along` the stretch inside.
pub(in crate::intersect) fn is_inside(blobs: &Blobs, ray: &LocalRay, along: f64) -> bool {
    let field = blobs.field.at(ray.time_secs);
    field.side(ray.origin + ray.direction * along) == Side::Inside
}

/// Up to this distance from a ray's own start, in spacings, a crossing has to be seen in float64: in
/// f32 a ray that leaves the surface at a grazing angle cannot be told from one that enters.
const NEAR_START_SPACINGS: f32 = 1e-2;

/// Steps in which float64 looks about a crossing near the start, in parts of that distance.
const TOLERANCE_PER_REACH: f32 = T_TOLERANCE_SPACINGS / NEAR_START_SPACINGS;

/// Distance from a ray's own start within which crossings need float64: [`NEAR_START_SPACINGS`], or
/// what f32 cannot resolve where blobs are far smaller than the scene.
pub(in crate::intersect) fn near_start(blobs: &Blobs, bounds: Option<Aabb>) -> f32 {
    (NEAR_START_SPACINGS * blobs.field.spacing).max(8.0 * start_margin(bounds))
}

/// How exactly a field is traced in f32, in the field's lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Accuracy of a crossing.
    pub crossing: f32,
    /// How far rounding may move a blob along a ray, or a ray's start.
    pub rounding: f32,
    /// Up to this distance from the start of a ray that states its side, a crossing takes float64.
    pub near_start: f32,
}

impl Tolerances {
    /// Those of a field; `bounds` is the box around its structure.
    pub fn of(blobs: &Blobs, bounds: Aabb) -> Self {
        Self {
            crossing: T_TOLERANCE_SPACINGS * blobs.field.spacing,
            rounding: start_margin(Some(bounds)),
            near_start: near_start(blobs, Some(bounds)),
        }
    }
}

/// The neighbourhood of the start of a ray that states its side there.
pub(in crate::intersect) struct OwnStart {
    /// Crossings at smaller distances need float64; negative where none does.
    pub(in crate::intersect) reach: f64,
    /// Accuracy of a crossing.
    tolerance: f64,
    /// How far behind a crossing that is not there the search goes on at first.
    pub(in crate::intersect) stride: f32,
}

impl OwnStart {
    pub(in crate::intersect) fn new(blobs: &Blobs, bounds: Option<Aabb>, ray: &LocalRay) -> Self {
        let near = near_start(blobs, bounds);
        Self {
            reach: if ray.starts_at_t_min && !ray.side_is_proven {
                f64::from(near)
            } else {
                -1.0
            },
            tolerance: f64::from(near * TOLERANCE_PER_REACH),
            stride: 16.0 * near * TOLERANCE_PER_REACH,
        }
    }

    /// Whether a crossing at `t` is one: the field is on the stated side before it and on the other
    /// behind it.
    pub(in crate::intersect) fn is_sure(&self, blobs: &Blobs, ray: &LocalRay, t: f64) -> bool {
        if t > self.reach {
            return true;
        }
        let beyond = |along: f64| is_inside(blobs, ray, along) != ray.inside;
        [0.0, 0.5 * t, t - self.tolerance]
            .into_iter()
            .any(|before| before >= 0.0 && !beyond(before))
            && [1.0, 4.0, 16.0]
                .into_iter()
                .any(|steps| beyond(t + steps * self.tolerance))
    }

    /// The crossing behind `t`, where f32 sees it a little early, and before `beyond`, where float64
    /// sees the other side; `None` if the ray is there already.
    pub(in crate::intersect) fn crossing_before(
        &self,
        blobs: &Blobs,
        ray: &LocalRay,
        t: f64,
        beyond: f64,
    ) -> Option<f64> {
        let is_beyond = |along: f64| is_inside(blobs, ray, along) != ray.inside;
        let (mut before, mut behind) = ((t - self.tolerance).max(0.0), beyond);
        if is_beyond(before) {
            return None;
        }
        while behind - before > self.tolerance {
            let middle = 0.5 * (before + behind);
            if is_beyond(middle) {
                behind = middle;
            } else {
                before = middle;
            }
        }
        Some(behind)
    }
}
