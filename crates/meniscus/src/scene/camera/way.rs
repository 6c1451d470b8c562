//! What a camera that moves does while the shutter is open.

use super::Camera;
use crate::math::aabb::DAabb;
use crate::math::cubics::{Piece, pieces};
use glam::DVec3;

/// A camera's eye, view direction, directions to the right and to the top, and side of a pixel.
pub type CameraPiece = Piece<5>;

/// How well cubics keep unit vectors.
const TOLERANCE: f64 = 1e-8;
/// Pieces of the shutter's time over which bounds are taken.
const BOUNDED_PIECES: u32 = 16;

impl Camera {
    /// Its way while the shutter is open, its eye relative to `origin`; `None` where it stands still then.
    pub fn way(&self, [open, close]: [f64; 2], origin: DVec3) -> Option<Vec<CameraPiece>> {
        let path = self.path.as_ref().filter(|_| open < close)?;
        let part_of = |time: f64| (time - path.frame_secs - open) / (close - open);
        // The eye's way is made of cubics.
        let mut tolerances = [TOLERANCE; 5];
        tolerances[0] = f64::INFINITY;
        tolerances[4] *= self.pixel_side;
        let cuts = path.times.iter().map(|&time| part_of(time));
        Some(pieces(cuts, tolerances, |part| {
            let there = path.at(open + (close - open) * part);
            let side = DVec3::X * there.pixel_side;
            let eye = there.eye - origin;
            [eye, there.forward, there.right, there.up, side]
        }))
    }

    /// Box around the eye while the shutter is open: piece by piece where it is in the middle, widened by
    /// how far it can get from there.
    pub fn eye_bounds(&self, [open, close]: [f64; 2]) -> DAabb {
        let Some(path) = &self.path else {
            return DAabb {
                min: self.eye,
                max: self.eye,
            };
        };
        let half = 0.5 * (close - open) / f64::from(BOUNDED_PIECES);
        (0..BOUNDED_PIECES).fold(DAabb::EMPTY, |all, piece| {
            let middle = path.frame_secs + open + half * f64::from(2 * piece + 1);
            let reach = path.eye.fastest(middle - half, middle + half) * half;
            let eye = path.eye.at(middle);
            all.union(DAabb {
                min: eye - reach,
                max: eye + reach,
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CameraKey, CameraSettings};
    use super::*;

    #[test]
    fn the_way_of_a_camera_in_pieces_is_its_path() {
        let keys =
            [(0.0, 30.0), (1.0, 50.0), (2.0, 35.0)].map(|(time, fov): (f64, f64)| CameraKey {
                time,
                eye: DVec3::new(100.0 + 3.0 * time, time.sin(), 4.0),
                target: DVec3::new(100.0, 0.2 * time, 0.0),
                up: None,
                fov: Some(fov),
            });
        let settings = CameraSettings {
            keys: keys.to_vec(),
            ..CameraSettings::default()
        };
        let moving = Camera::on_path(&settings, [64, 48], 1.0).unwrap();
        let (shutter, origin) = ([-0.7, 0.6], DVec3::X * 100.0);
        let bounds = moving.eye_bounds(shutter);
        assert!(bounds.size().max_element() < 8.0);
        let way = moving.way(shutter, origin).unwrap();
        // The key in the middle is a seam.
        assert!(
            way.iter()
                .any(|piece| (piece.start - 0.7 / 1.3).abs() < 1e-12)
        );
        for piece in way {
            assert!(piece.is_close);
            for u in [0.0, 0.2, 0.9] {
                let there = moving.at(-0.7 + 1.3 * (piece.start + piece.length * u));
                let [eye, forward, right, up, side] = piece.at(u);
                assert!(eye.distance(there.eye - origin) < 1e-12);
                assert!(forward.distance(there.forward) < 2.0 * TOLERANCE);
                assert!(right.distance(there.right) < 2.0 * TOLERANCE);
                assert!(up.distance(there.up) < 2.0 * TOLERANCE);
                assert!((side.x / there.pixel_side - 1.0).abs() < 2.0 * TOLERANCE);
                assert!(bounds.contains(there.eye));
            }
        }
        assert_eq!(moving.way([0.3, 0.3], origin), None);
        let still = moving.turned(origin, DVec3::Y, 1.0);
        assert_eq!(still.way(shutter, origin), None);
        assert_eq!(still.eye_bounds(shutter).size(), DVec3::ZERO);
    }
}
