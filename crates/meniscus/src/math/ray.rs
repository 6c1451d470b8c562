//! Rays: where they start, where they may end, when, and on which side of the surface.

use super::differential::RayDifferential;
use glam::DVec3;

/// Which side of a surface a point lies on (`F < T` outside, `F > T` inside).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Side {
    /// Not known: the engine evaluates the field where the ray starts.
    #[default]
    Unknown,
    /// `F ≤ T`.
    Outside,
    /// `F > T`.
    Inside,
}

impl Side {
    /// The other side; unknown stays unknown.
    #[must_use]
    pub fn flipped(self) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Outside => Self::Inside,
            Self::Inside => Self::Outside,
        }
    }
}

/// A half line `origin + t·direction` with `t` in `[t_min, t_max]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Start, in the space of whoever is asked.
    pub origin: DVec3,
    /// Direction as given; `t` counts in its length, it need not be a unit vector.
    pub direction: DVec3,
    /// Smallest `t` that counts.
    pub t_min: f64,
    /// Largest `t` that counts; may be infinite.
    pub t_max: f64,
    /// Time within the shutter, in seconds relative to the frame.
    pub time: f64,
    /// Side of the surface at `t_min`, when the caller knows it. A ray that leaves a surface must
    /// state it: that is what keeps it from hitting its own start.
    pub side: Side,
    /// The surface that `side` is about, as an index into the frame's instances; the side of all
    /// others is unknown then. `None`: it is about every surface.
    pub side_of: Option<u32>,
    /// How it changes from pixel to pixel and with time, for those who filter.
    pub differential: Option<RayDifferential>,
}

impl Ray {
    /// A ray over `[0, ∞)` at time 0 with an unknown side.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self {
            origin,
            direction,
            t_min: 0.0,
            t_max: f64::INFINITY,
            time: 0.0,
            side: Side::Unknown,
            side_of: None,
            differential: None,
        }
    }

    /// The same ray limited to `[t_min, t_max]`.
    #[must_use]
    pub fn with_range(self, t_min: f64, t_max: f64) -> Self {
        Self {
            t_min,
            t_max,
            ..self
        }
    }

    /// The same ray with a stated side.
    #[must_use]
    pub fn with_side(self, side: Side) -> Self {
        Self { side, ..self }
    }

    /// The side of surface `surface` at `t_min`, as far as it is stated.
    pub fn side_towards(&self, surface: u32) -> Side {
        match self.side_of {
            Some(about) if about != surface => Side::Unknown,
            _ => self.side,
        }
    }

    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Whether the ray can hit anything: finite origin, finite non-zero direction, finite `t_min`,
    /// `t_min ≤ t_max`. Everything else is a miss by definition.
    pub fn is_traceable(&self) -> bool {
        let length_squared = self.direction.length_squared();
        self.origin.is_finite()
            && self.direction.is_finite()
            && length_squared > 0.0
            && length_squared.is_finite()
            && self.t_min.is_finite()
            && self.time.is_finite()
            && self.t_min <= self.t_max
    }
}
