//! Where an instance is while the shutter is open, for machines with neither keys nor float64.

use super::Instance;
use crate::math::cubics::{Piece, pieces};
use glam::{DMat3, DVec3};

/// Where in the world a point of the object is, and the columns of the map from the world around it into
/// the object around that point.
pub type InstancePiece = Piece<4>;

/// How well cubics keep what they stand for, relative to its size.
const TOLERANCE: f64 = 1e-8;

impl Instance {
    /// Whether it only moves what it places, and that not while the shutter is open.
    pub fn is_upright(&self) -> bool {
        self.path.is_none() && self.world_from_object.matrix3 == DMat3::IDENTITY
    }

    /// Its way while the shutter is open: of the object's point `pivot`, relative to world point `origin`;
    /// lengths in the object count in `unit`s. `reach` is about how far what it places extends, in the
    /// world. One that stands still has one piece.
    pub fn way(
        &self,
        [open, close]: [f64; 2],
        (pivot, unit): (DVec3, f64),
        origin: DVec3,
        reach: f64,
    ) -> Vec<InstancePiece> {
        let cuts = self.path.iter().filter(|_| open < close);
        let cuts = cuts.flat_map(|path| path.key_secs());
        let cuts = cuts.map(|secs| (secs - open) / (close - open));
        let place = |part: f64| {
            let there = self.at(open + (close - open) * part);
            let m = there.object_from_world.matrix3 * unit.recip();
            let pivot = there.world_from_object.transform_point3(pivot);
            [pivot - origin, m.x_axis, m.y_axis, m.z_axis]
        };
        let [_, columns @ ..] = place(0.0);
        let size = columns.iter().fold(0.0, |size, c| c.length().max(size));
        let relative = [reach, size, size, size];
        pieces(cuts, relative.map(|size| TOLERANCE * size), place)
    }
}
