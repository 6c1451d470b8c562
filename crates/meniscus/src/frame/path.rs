//! Instances that move while the shutter is open.

use super::Instance;
use crate::math::aabb::DAabb;
use crate::math::keyframes::{Curve, place};
use crate::math::level_set::AT_REST;
use crate::math::turning::{taken_apart, turn_between};
use crate::scene::PlacementKey;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::borrow::Cow;

/// The way of an instance through its keys: its origin follows a smooth curve, it turns evenly from key
/// to key about one axis (Shoemake 1985), and it is stretched evenly. Each key's map is taken apart into
/// a stretch, which is symmetric, and the turn after it (polar decomposition, Shoemake & Duff 1992).
#[derive(Debug, Clone, PartialEq)]
pub struct InstancePath {
    /// Time of the frame, in seconds of the scene.
    frame_secs: f64,
    /// When the shutter opens and closes, relative to the frame. What comes before or after is traced as
    /// at the nearer end.
    shutter: [f64; 2],
    times: Vec<f64>,
    origin: Curve,
    turns: Vec<DQuat>,
    stretches: Vec<DMat3>,
}

/// A placement and its change per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Object to world.
    pub world_from_object: DAffine3,
    /// World to object.
    pub object_from_world: DAffine3,
    /// Change of `world_from_object` per second.
    pub world_from_object_rate: DAffine3,
    /// Change of `object_from_world` per second.
    pub object_from_world_rate: DAffine3,
}

/// Pieces of the shutter over which bounds are taken.
const PIECES: u32 = 16;

impl InstancePath {
    /// Through sorted keys, for a frame at `frame_secs`; `None` where nothing moves while the shutter is
    /// open, with the map that holds then.
    pub fn new(
        keys: &[PlacementKey],
        frame_secs: f64,
        shutter: [f64; 2],
    ) -> (DAffine3, Option<Self>) {
        let times: Vec<f64> = keys.iter().map(|key| key.time).collect();
        let mut turns: Vec<DQuat> = Vec::with_capacity(keys.len());
        let mut stretches = Vec::with_capacity(keys.len());
        for key in keys {
            let (turn, stretch) = taken_apart(key.matrix.0.matrix3);
            // The shorter way round.
            let last = turns.last();
            turns.push(match last {
                Some(last) if last.dot(turn) < 0.0 => -turn,
                _ => turn,
            });
            stretches.push(stretch);
        }
        let origins = keys.iter().map(|key| key.matrix.0.translation).collect();
        let path = Self {
            frame_secs,
            shutter,
            origin: Curve::new(&times, origins),
            times,
            turns,
            stretches,
        };
        if !path.is_at_rest(keys) {
            return (path.at(0.0).world_from_object, Some(path));
        }
        // A map that is one of the keys' is that map to the last bit.
        let time = frame_secs + shutter[0];
        let (i, part) = place(&path.times, time);
        let map = match keys.get(i + 1) {
            Some(next) if part == 1.0 => next.matrix.0,
            Some(next) if part > 0.0 && next.matrix != keys[i].matrix => {
                path.at(0.0).world_from_object
            }
            _ => keys[i].matrix.0,
        };
        (map, None)
    }

    /// Whether all keys that count while the shutter is open say the same, or it never is.
    fn is_at_rest(&self, keys: &[PlacementKey]) -> bool {
        let [open, close] = self.shutter.map(|secs| self.frame_secs + secs);
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        open == close
            || close <= first
            || open >= last
            || keys.windows(2).all(|pair| pair[0].matrix == pair[1].matrix)
    }

    /// Times of its keys, relative to the frame.
    pub(super) fn key_secs(&self) -> impl Iterator<Item = f64> {
        self.times.iter().map(|time| time - self.frame_secs)
    }

    /// Where the instance is at a time relative to the frame, and how that changes.
    pub fn at(&self, secs: f64) -> Placement {
        let time = self.frame_secs + secs.clamp(self.shutter[0], self.shutter[1]);
        let (i, part) = place(&self.times, time);
        let (turn, spin) = self.turn(i, part);
        let (stretch, growth) = self.stretch(i, part);
        let turn = DMat3::from_quat(turn);
        let matrix3 = turn * stretch;
        let world_from_object = DAffine3 {
            matrix3,
            translation: self.origin.at(time),
        };
        let is_outside = time < self.times[0] || time > self.times[self.times.len() - 1];
        let world_from_object_rate = match is_outside {
            true => AT_REST,
            false => DAffine3 {
                matrix3: cross(spin) * matrix3 + turn * growth,
                translation: self.origin.velocity(time),
            },
        };
        let object_from_world = world_from_object.inverse();
        // d(M⁻¹) = −M⁻¹ dM M⁻¹.
        let inverse = object_from_world.matrix3;
        let rate = inverse * world_from_object_rate.matrix3 * inverse * -1.0;
        let object_from_world_rate = DAffine3 {
            matrix3: rate,
            translation: rate * world_from_object.translation * -1.0
                - inverse * world_from_object_rate.translation,
        };
        Placement {
            world_from_object,
            object_from_world,
            world_from_object_rate,
            object_from_world_rate,
        }
    }

    /// The turn in interval `i`, and the angular velocity in radians per second.
    fn turn(&self, i: usize, part: f64) -> (DQuat, DVec3) {
        let Some(&next) = self.turns.get(i + 1) else {
            return (self.turns[i], DVec3::ZERO);
        };
        let (axis, angle) = turn_between(self.turns[i], next);
        if angle == 0.0 {
            return (self.turns[i], DVec3::ZERO);
        }
        let turn = DQuat::from_axis_angle(axis, angle * part) * self.turns[i];
        let length = self.times[i + 1] - self.times[i];
        (turn, axis * (angle / length))
    }

    /// The stretch in interval `i`, and its change per second.
    fn stretch(&self, i: usize, part: f64) -> (DMat3, DMat3) {
        let start = self.stretches[i];
        let Some(&end) = self.stretches.get(i + 1) else {
            return (start, DMat3::ZERO);
        };
        let length = self.times[i + 1] - self.times[i];
        (start + (end - start) * part, (end - start) * (1.0 / length))
    }

    /// The box around an object-space box at all times in `shutter`: piece by piece where it is in the
    /// middle, widened by how far its points can get from there.
    pub fn bounds(&self, bounds: DAabb, shutter: [f64; 2]) -> DAabb {
        if bounds.is_empty() {
            return bounds;
        }
        let farthest = bounds.min.abs().max(bounds.max.abs()).length();
        let [open, close] = shutter.map(|secs| secs.clamp(self.shutter[0], self.shutter[1]));
        let half = 0.5 * (close - open) / f64::from(PIECES);
        (0..PIECES).fold(DAabb::EMPTY, |all, piece| {
            let middle = open + half * f64::from(2 * piece + 1);
            let [from, to] = [middle - half, middle + half].map(|secs| self.frame_secs + secs);
            let there = self.at(middle).world_from_object;
            let mut reach = self.origin.fastest(from, to);
            let [(first, _), (last, _)] = [from, to].map(|time| place(&self.times, time));
            let mut fastest = 0.0_f64;
            for i in first..=last {
                let (_, spin) = self.turn(i, 0.0);
                let (_, growth) = self.stretch(i, 0.0);
                // A stretch between two is no longer than the longer one.
                let next = (i + 1).min(self.stretches.len() - 1);
                let size = norm(&self.stretches[i]).max(norm(&self.stretches[next]));
                fastest = fastest.max((spin.length() * size + norm(&growth)) * farthest);
            }
            reach = (reach + fastest) * half;
            let piece = super::bounds::transformed(bounds, &there);
            // Rounding of the pieces' middles.
            let rounding = 1e-12 * (piece.min.abs().max(piece.max.abs()).max_element() + reach);
            all.union(DAabb {
                min: piece.min - (reach + rounding),
                max: piece.max + (reach + rounding),
            })
        })
    }
}

impl Instance {
    /// The instance where it stands at a time, in seconds relative to the frame.
    #[inline]
    pub fn at(&self, secs: f64) -> Cow<'_, Self> {
        match &self.path {
            None => Cow::Borrowed(self),
            Some(path) => {
                let placement = path.at(secs);
                Cow::Owned(Self {
                    geometry: self.geometry,
                    world_from_object: placement.world_from_object,
                    object_from_world: placement.object_from_world,
                    material: self.material,
                    path: None,
                })
            }
        }
    }

    /// Where it stands at a time, and how that changes.
    pub fn placement(&self, secs: f64) -> Placement {
        match &self.path {
            Some(path) => path.at(secs),
            None => Placement {
                world_from_object: self.world_from_object,
                object_from_world: self.object_from_world,
                world_from_object_rate: AT_REST,
                object_from_world_rate: AT_REST,
            },
        }
    }

    /// World-space box around an object-space one at all times in `shutter`.
    pub(super) fn bounds(&self, bounds: DAabb, shutter: [f64; 2]) -> DAabb {
        match &self.path {
            None => super::bounds::transformed(bounds, &self.world_from_object),
            Some(path) => path.bounds(bounds, shutter),
        }
    }
}

/// The matrix of v × x.
fn cross(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// A bound of how much longer a matrix makes vectors (Frobenius).
fn norm(matrix: &DMat3) -> f64 {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    columns
        .iter()
        .map(|c| c.length_squared())
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
mod tests;
