//! Blobs that move while the shutter is open: p(t) = p + v·t + ½a·t² (Ray Tracing Gems II, §35.2), and
//! the field at one time.

use super::BlobField;
use crate::math::aabb::{Aabb, DAabb};
use glam::{DVec3, Vec3};

/// How the blobs of a field move; one entry per blob.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Velocities at the frame's time, in lengths per second.
    pub velocities: Vec<[f32; 3]>,
    /// Halves of the accelerations, in lengths per second squared.
    pub half_accelerations: Vec<[f32; 3]>,
    /// Velocity gradients L of the material about each blob, row by row, in 1/second: how its ellipsoid
    /// turns and stretches. Empty where shapes stay as they are; else no shape is a ball's, and
    /// |L| times the longest time is at most [`MOST_TURN`](super::MOST_TURN).
    pub velocity_gradients: Vec<[f32; 9]>,
    /// When the shutter opens and closes, in seconds relative to the frame. What comes before or after
    /// is traced as at the nearer end.
    pub shutter: [f64; 2],
}

impl Motion {
    /// How far blob `i` has moved from its place at the frame's time.
    fn offset(&self, i: usize, time_secs: f64) -> DVec3 {
        let [velocity, half] = self.rates(i);
        (velocity + half * time_secs) * time_secs
    }

    /// Velocity and half acceleration of blob `i`.
    pub fn rates(&self, i: usize) -> [DVec3; 2] {
        [self.velocities[i], self.half_accelerations[i]].map(|rate| Vec3::from(rate).as_dvec3())
    }

    /// Whether any blob is accelerated.
    pub fn is_accelerated(&self) -> bool {
        self.half_accelerations.iter().any(|half| *half != [0.0; 3])
    }

    /// The time within the shutter that is nearest to `time_secs`.
    pub fn clamped(&self, time_secs: f64) -> f64 {
        time_secs.clamp(self.shutter[0], self.shutter[1])
    }

    /// The middle of the shutter.
    pub fn middle_secs(&self) -> f64 {
        0.5 * (self.shutter[0] + self.shutter[1])
    }

    /// Half the time that the shutter is open.
    pub fn half_shutter_secs(&self) -> f64 {
        0.5 * (self.shutter[1] - self.shutter[0])
    }

    /// All the time that the shutter is open.
    pub fn whole(&self) -> Span {
        Span {
            middle_secs: self.middle_secs(),
            half_secs: self.half_shutter_secs(),
        }
    }

    /// Where a blob with the centre `center` at the frame's time is in the middle of `span`, its
    /// velocity there and half its acceleration, on the scale of [`Span::phase`].
    pub fn by_phase(&self, span: Span, i: usize, center: DVec3) -> [DVec3; 3] {
        let [velocity, half] = self.rates(i);
        let (middle, unit) = (span.middle_secs, span.half_secs);
        [
            center + self.offset(i, middle),
            (velocity + half * (2.0 * middle)) * unit,
            half * (unit * unit),
        ]
    }
}

/// A part of the time while the shutter is open, in seconds relative to the frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Span {
    /// Its middle.
    pub middle_secs: f64,
    /// Half its length.
    pub half_secs: f64,
}

impl Span {
    /// A time on the scale on which the span begins at −1 and ends at 1; what lies before or after counts
    /// as its nearer end.
    pub fn phase(&self, time_secs: f64) -> f64 {
        ((time_secs - self.middle_secs) / self.half_secs).clamp(-1.0, 1.0)
    }

    /// Its `count` parts, all equally long, in order of time.
    pub fn parts(self, count: usize) -> impl Iterator<Item = Self> {
        let half_secs = self.half_secs / count as f64;
        (0..count).map(move |part| Self {
            middle_secs: self.middle_secs - self.half_secs + (2 * part + 1) as f64 * half_secs,
            half_secs,
        })
    }

    /// When it begins and ends.
    pub fn ends_secs(&self) -> [f64; 2] {
        [
            self.middle_secs - self.half_secs,
            self.middle_secs + self.half_secs,
        ]
    }
}

/// Boxes that change while the shutter is open and hold a blob's support at all times between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionBoxes {
    /// When the shutter opens and closes; in between in proportion to the time. Half an acceleration a'
    /// bends the way off its chord by up to a'Δ²/4, which they are wider by.
    pub ends: [Aabb; 2],
    /// Around the control points of the way as a quadratic Bézier curve (Ray Tracing Gems II, §35.3);
    /// they are interpolated as the points are.
    pub curve: [Aabb; 3],
}

impl MotionBoxes {
    /// What holds nothing.
    pub const EMPTY: Self = Self {
        ends: [Aabb::EMPTY; 2],
        curve: [Aabb::EMPTY; 3],
    };

    /// What stays where it is.
    pub fn still(bounds: Aabb) -> Self {
        Self {
            ends: [bounds; 2],
            curve: [bounds; 3],
        }
    }

    /// Grown by `margin` on every side.
    #[must_use]
    pub fn padded(self, margin: f32) -> Self {
        Self {
            ends: self.ends.map(|bounds| bounds.padded(margin)),
            curve: self.curve.map(|bounds| bounds.padded(margin)),
        }
    }

    /// What holds both.
    #[must_use]
    pub fn union(mut self, other: Self) -> Self {
        for (mine, other) in self.ends.iter_mut().zip(other.ends) {
            *mine = mine.union(other);
        }
        for (mine, other) in self.curve.iter_mut().zip(other.curve) {
            *mine = mine.union(other);
        }
        self
    }
}

/// A field at one time.
#[derive(Debug, Clone, Copy)]
pub struct FieldAt<'a> {
    pub(super) field: &'a BlobField,
    pub(super) time_secs: f64,
}

impl BlobField {
    /// The field at a time, in seconds relative to the frame.
    pub fn at(&self, time_secs: f64) -> FieldAt<'_> {
        let time_secs = match &self.motion {
            None => 0.0,
            Some(motion) => motion.clamped(time_secs),
        };
        FieldAt {
            field: self,
            time_secs,
        }
    }

    /// Local box around the support of blob `i` at any time while the shutter is open.
    pub fn support_box(&self, i: usize) -> Aabb {
        let whole = self.motion.as_ref().map(Motion::whole);
        self.support_box_in(whole.unwrap_or_default(), i)
    }

    /// Local box around the support of blob `i` at any time in `span`.
    pub fn support_box_in(&self, span: Span, i: usize) -> Aabb {
        let center = self.center(i);
        match &self.motion {
            None => {
                let half = Vec3::from_array(self.shapes.half_extents(i));
                Aabb {
                    min: center - half,
                    max: center + half,
                }
            }
            Some(motion) => {
                let half = motion.half_extents(i, &self.shapes);
                let path = motion.path_box(span, i, center.as_dvec3());
                rounded_outwards(path.min, path.max, half)
            }
        }
    }
}

impl BlobField {
    /// Boxes around the support of blob `i` that move with it while the shutter is open.
    pub fn motion_boxes(&self, i: usize) -> MotionBoxes {
        let whole = self.motion.as_ref().map(Motion::whole);
        self.motion_boxes_in(whole.unwrap_or_default(), i)
    }

    /// Boxes around the support of blob `i` that move with it in `span`.
    pub fn motion_boxes_in(&self, span: Span, i: usize) -> MotionBoxes {
        let Some(motion) = &self.motion else {
            return MotionBoxes::still(self.support_box(i));
        };
        let half = motion.half_extents(i, &self.shapes);
        let bend = motion.rates(i)[1] * span.half_secs.powi(2);
        let [open, close] = span
            .ends_secs()
            .map(|time_secs| self.at(time_secs).center(i));
        let straight = |center: DVec3| {
            let low = center - bend.max(DVec3::ZERO);
            let high = center - bend.min(DVec3::ZERO);
            rounded_outwards(low, high, half)
        };
        // A parabola's tangents at its ends meet as far below its chord as it is below them.
        let control = 0.5 * (open + close) - 2.0 * bend;
        MotionBoxes {
            ends: [straight(open), straight(close)],
            curve: [open, control, close].map(|point| rounded_outwards(point, point, half)),
        }
    }
}

/// A box in f32 that holds what lies within `half` of the one from `low` to `high`.
fn rounded_outwards(low: DVec3, high: DVec3, half: Vec3) -> Aabb {
    let half = half.as_dvec3();
    let (low, high) = ((low - half).as_vec3(), (high + half).as_vec3());
    Aabb {
        min: Vec3::from_array(low.to_array().map(f32::next_down)),
        max: Vec3::from_array(high.to_array().map(f32::next_up)),
    }
}

impl Motion {
    /// The box around the way of blob `i` in `span`, whose centre at the frame's time is `center`.
    fn path_box(&self, span: Span, i: usize, center: DVec3) -> DAabb {
        let [velocity, half] = self.rates(i);
        let mut bounds = DAabb::EMPTY;
        let [from, to] = span.ends_secs();
        for time_secs in [from, to] {
            bounds = bounds.including(center + self.offset(i, time_secs));
        }
        for axis in 0..3 {
            // Where it turns round.
            let turn = -velocity[axis] / (2.0 * half[axis]);
            if from < turn && turn < to {
                let place = center[axis] + self.offset(i, turn)[axis];
                bounds.min[axis] = bounds.min[axis].min(place);
                bounds.max[axis] = bounds.max[axis].max(place);
            }
        }
        bounds
    }
}

impl<'a> FieldAt<'a> {
    /// The field at any time.
    pub fn field(&self) -> &'a BlobField {
        self.field
    }

    /// Local centre of blob `i`, in float64 on the packed numbers.
    #[inline]
    pub fn center(&self, i: usize) -> DVec3 {
        let center = self.field.center(i).as_dvec3();
        match &self.field.motion {
            None => center,
            Some(motion) => center + motion.offset(i, self.time_secs),
        }
    }

    /// Velocity of blob `i` at this time, in lengths per second; `None` where nothing moves.
    #[inline]
    pub fn blob_velocity(&self, i: usize) -> Option<DVec3> {
        let motion = self.field.motion.as_ref()?;
        let [velocity, half_acceleration] = motion.rates(i);
        Some(velocity + half_acceleration * (2.0 * self.time_secs))
    }
}
