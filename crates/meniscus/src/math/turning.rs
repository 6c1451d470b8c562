//! Maps taken apart into a turn and a stretch, and turns half way to others.

use super::symmetric::eigen;
use glam::{DMat3, DQuat, DVec3};

/// A matrix as a turn after a symmetric stretch (polar decomposition, Shoemake & Duff 1992); mirrors are
/// stretches by −1. The turn of a singular matrix is not finite.
pub fn taken_apart(matrix: DMat3) -> (DQuat, DMat3) {
    let (squares, axes) = eigen(matrix.transpose() * matrix);
    let sign = 1.0_f64.copysign(matrix.determinant());
    let lengths = DVec3::from_array(squares.to_array().map(|square| square.max(0.0).sqrt()));
    let back = axes.transpose();
    let stretch = axes * DMat3::from_diagonal(lengths * sign) * back;
    let shrink = axes * DMat3::from_diagonal(lengths.recip() * sign) * back;
    (DQuat::from_mat3(&(matrix * shrink)).normalize(), stretch)
}

/// The turn that leads from one unit quaternion to another, as its axis and its angle from 0 to 2π: the
/// way round that the quaternions' signs say. An angle of 0 has no axis.
pub fn turn_between(from: DQuat, to: DQuat) -> (DVec3, f64) {
    let by = (to * from.conjugate()).normalize();
    // Accurate for small turns, which an arc cosine is not.
    let sine = by.xyz().length();
    if sine == 0.0 {
        return (DVec3::ZERO, 0.0);
    }
    (by.xyz() / sine, 2.0 * sine.atan2(by.w))
}

/// `part` of the turn from one unit quaternion to another, evenly about one axis, the shorter way round
/// (Shoemake 1985).
pub fn turned(from: DQuat, to: DQuat, part: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    let (axis, angle) = turn_between(from, to);
    if angle == 0.0 {
        return from;
    }
    DQuat::from_axis_angle(axis, angle * part) * from
}
