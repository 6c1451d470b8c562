//! How much blobs move against their neighbours: whether cells whose planes move pay.

use crate::field::{BlobField, Span};
use crate::primitive::Shapes;
use glam::DVec3;
use rayon::prelude::*;

/// Cells of balls that move more than this against each other, in supports, are crossed by too many of
/// them to pay; and those of ellipsoids, whose leaves are large as it is.
const COHERENT_BALLS: f64 = 0.3;
const COHERENT_ELLIPSOIDS: f64 = 0.15;

/// How much blobs move against their neighbours.
#[derive(Debug, Clone, Copy)]
pub(in crate::accel::cells) struct Unrest {
    /// How far they depart from the way of the group that they are in while the shutter is open, over
    /// their support, in the root mean square: at their own velocities, and by acceleration alone.
    straight: f64,
    bent: f64,
    /// Up to which departure cells are worth building.
    limit: f64,
}

impl Unrest {
    /// How far they depart in each of `slabs` slabs of the time, over how far they may.
    pub(in crate::accel::cells) fn within(self, slabs: u32) -> f64 {
        let slabs = f64::from(slabs);
        (self.straight / slabs + self.bent / (slabs * slabs)) / self.limit
    }

    /// That of a field; `None` where shapes turn, which cells do not know.
    pub(in crate::accel::cells) fn of(field: &BlobField) -> Option<Self> {
        let limit = match field.shapes {
            Shapes::Balls(_) => COHERENT_BALLS,
            Shapes::Ellipsoids(_) => COHERENT_ELLIPSOIDS,
        };
        let Some(motion) = &field.motion else {
            return Some(Self {
                straight: 0.0,
                bent: 0.0,
                limit,
            });
        };
        if motion.turns() {
            return None;
        }
        let groups: Vec<&[u32]> = field.support_tree().groups().collect();
        // Groups in a fixed order, so that the sums do not depend on the number of threads.
        let parts: Vec<[f64; 2]> = groups
            .par_iter()
            .map(|blobs| {
                let ways = || {
                    blobs.iter().map(|&blob| {
                        let blob = blob as usize;
                        let [_, velocity, half] =
                            motion.by_phase(motion.whole(), blob, DVec3::ZERO);
                        (velocity, half, 2.0 / field.shapes.mean_radius(blob))
                    })
                };
                let mean =
                    ways().map(|(velocity, ..)| velocity).sum::<DVec3>() / blobs.len() as f64;
                ways().fold(
                    [0.0; 2],
                    |[straight, bent], (velocity, half, per_radius)| {
                        [
                            straight + ((velocity - mean) * per_radius).length_squared(),
                            bent + (half * per_radius).length_squared(),
                        ]
                    },
                )
            })
            .collect();
        let root_mean = |kind: usize| {
            let sum: f64 = parts.iter().map(|part| part[kind]).sum();
            (sum / field.len() as f64).sqrt()
        };
        Some(Self {
            straight: root_mean(0),
            bent: root_mean(1),
            limit,
        })
    }
}

/// How far blobs move in `span`, in the root mean square; 0 where nothing moves.
pub(in crate::accel::cells) fn way_spacings(field: &BlobField, span: Span) -> f32 {
    let Some(motion) = &field.motion else {
        return 0.0;
    };
    let squares: f64 = (0..field.len())
        .map(|i| motion.by_phase(span, i, DVec3::ZERO)[1].length_squared())
        .sum();
    2.0 * (squares / field.len() as f64).sqrt() as f32 / field.spacing
}
