//! Ellipsoids that turn and stretch while the shutter is open (Ray Tracing Gems II, §35.2: a metric that
//! depends on time).

use super::{FieldAt, Motion};
use crate::primitive::Shapes;
use glam::{DMat3, DVec3, Vec3};

/// The turn of a shape, |L|·t, that a shutter may at most hold: with it I − tL + ½t²L² is far from
/// singular.
pub const MOST_TURN: f64 = 0.9;

/// Bounds of a turning ellipsoid's extents are taken for parts of the shutter in which it turns by less.
const PIECE_TURN: f64 = 1.0 / 64.0;

/// Shapes that turn and stretch: q(x, t) = |A·N(t)·(x − p(t))|² with N(t) = I − tL + ½t²L², the inverse
/// of how the material moves to second order.
impl Motion {
    /// Whether any shape turns or stretches.
    pub fn turns(&self) -> bool {
        !self.velocity_gradients.is_empty()
    }

    /// L of blob `i`.
    fn velocity_gradient(&self, i: usize) -> DMat3 {
        DMat3::from_cols_array(&self.velocity_gradients[i].map(f64::from)).transpose()
    }

    /// N(t) of blob `i`.
    pub fn turn(&self, i: usize, time_secs: f64) -> DMat3 {
        let x = self.velocity_gradient(i) * time_secs;
        DMat3::IDENTITY - x + x * x * 0.5
    }

    /// A bound of |N| while the shutter is open.
    pub fn most_turn(&self, i: usize) -> f64 {
        let x = self.longest_secs() * frobenius(self.velocity_gradient(i));
        1.0 + x + 0.5 * x * x
    }

    /// The longest time from the frame's to one at which the shutter is open.
    pub(super) fn longest_secs(&self) -> f64 {
        self.shutter[0].abs().max(self.shutter[1].abs())
    }

    /// Half the box that contains the support of blob `i` around its centre at any time.
    pub(super) fn half_extents(&self, i: usize, shapes: &Shapes) -> Vec3 {
        let at_rest = Vec3::from_array(shapes.half_extents(i));
        let (Shapes::Ellipsoids(factors), true) = (shapes, self.turns()) else {
            return at_rest;
        };
        let inverse = factors[i].matrix().inverse();
        let norm = frobenius(self.velocity_gradient(i));
        let [open, close] = self.shutter;
        let pieces = (norm * (close - open) / PIECE_TURN).ceil().max(1.0);
        let half_piece = 0.5 * (close - open) / pieces;
        // |N(t) − N(u)| for times of a piece with the middle u.
        let departs = half_piece * norm * (1.0 + self.longest_secs() * norm);
        let mut half = DVec3::ZERO;
        for piece in 0..pieces as usize {
            let middle = open + half_piece * (2 * piece + 1) as f64;
            let unturned = self.turn(i, middle).inverse();
            let there = unturned * inverse;
            // (A·N(t))⁻¹ = (I + E)⁻¹(A·N(u))⁻¹ with |E| below this.
            let error = departs * frobenius(unturned);
            let margin = error / (1.0 - error).max(0.1) * frobenius(there);
            let rows = DVec3::from_array([0, 1, 2].map(|row| there.row(row).length()));
            half = half.max(rows + margin);
        }
        (half * (1.0 + 1e-6)).as_vec3()
    }
}

fn frobenius(matrix: DMat3) -> f64 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec3::length_squared);
    (x + y + z).sqrt()
}

impl FieldAt<'_> {
    /// N(t) of blob `i` at this time; `None` where shapes stay as they are.
    #[inline]
    fn turn(&self, i: usize) -> Option<DMat3> {
        let motion = self.field.motion.as_ref().filter(|motion| motion.turns())?;
        Some(motion.turn(i, self.time_secs))
    }

    /// y = A·N(t)·d for blob `i`: its support is |y| < 1.
    #[inline]
    pub fn transform(&self, i: usize, d: DVec3) -> DVec3 {
        match self.turn(i) {
            None => self.field.shapes.transform(i, d),
            Some(turn) => self.field.shapes.transform(i, turn * d),
        }
    }

    /// (A·N(t))ᵀ·y for blob `i`.
    #[inline]
    pub fn transform_transposed(&self, i: usize, y: DVec3) -> DVec3 {
        let pull = self.field.shapes.transform_transposed(i, y);
        match self.turn(i) {
            None => pull,
            Some(turn) => turn.transpose() * pull,
        }
    }

    /// Velocity of what blob `i` carries along, per length from its centre: −N⁻¹·∂N/∂t, in 1/second.
    pub(super) fn material_gradient(&self, i: usize) -> Option<DMat3> {
        let motion = self.field.motion.as_ref().filter(|motion| motion.turns())?;
        let l = motion.velocity_gradient(i);
        let turn_rate = l * l * self.time_secs - l;
        Some(-(motion.turn(i, self.time_secs).inverse() * turn_rate))
    }
}
