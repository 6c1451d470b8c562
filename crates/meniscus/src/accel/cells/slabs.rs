//! Cells of blobs that move far: one structure for each slab of the time that the shutter is open, so that
//! in none of them blobs move much against their neighbours.

use super::Cells;
use super::moving::{Unrest, way_spacings};
use crate::field::{BlobField, Motion, Span};
use crate::primitive::Shapes;
use crate::scene::Leaves;
use rayon::prelude::*;

/// The structure of engine `cells`: [`Cells`] for each slab of time; one where nothing moves, or little.
#[derive(Debug)]
pub struct TimedCells {
    slabs: Vec<Cells>,
}

/// How many slabs there may be where no number is asked for. Ellipsoids are in many leaves of each slab.
const FOR_BALLS: &[u32] = &[2, 4];
const FOR_ELLIPSOIDS: &[u32] = &[2];

/// Several slabs pay where blobs move no farther than this in one of them, in spacings: for rays side by
/// side, which then still meet the same cells.
const WAY_SPACINGS: f32 = 3.0;

impl TimedCells {
    /// Into how many slabs of time the shutter of `field` is cut: `asked`, or where that is 0 as many as
    /// are best. `None` where shapes turn, or blobs move so much against their neighbours that no cells
    /// are worth building.
    pub fn slabs_for(field: &BlobField, asked: u32) -> Option<u32> {
        let unrest = Unrest::of(field)?;
        if asked > 0 {
            return Some(asked).filter(|&slabs| unrest.within(slabs) <= 1.0);
        }
        if unrest.within(1) <= 1.0 {
            return Some(1);
        }
        let whole = field.motion.as_ref().map(Motion::whole)?;
        let way = way_spacings(field, whole);
        let numbers = match field.shapes {
            Shapes::Balls(_) => FOR_BALLS,
            Shapes::Ellipsoids(_) => FOR_ELLIPSOIDS,
        };
        numbers
            .iter()
            .copied()
            .find(|&slabs| unrest.within(slabs) <= 1.0 && way <= WAY_SPACINGS * slabs as f32)
    }

    /// Builds the coarse cells of `field` in `slabs` slabs of time, at least one.
    pub fn build(field: &BlobField, slabs: u32, leaves: Leaves) -> Self {
        let spans = match &field.motion {
            None => vec![Span::default()],
            Some(_) if field.is_empty() => vec![Span::default()],
            Some(motion) => motion.whole().parts(slabs.max(1) as usize).collect(),
        };
        let slabs = match *spans {
            [span] => vec![Cells::build_in(field, span, leaves, None)],
            _ => spans
                .into_par_iter()
                .map(|span| {
                    let tree = field
                        .support_tree()
                        .refitted(|i| field.path_bounds_in(span, i));
                    Cells::build_in(field, span, leaves, Some(tree))
                })
                .collect(),
        };
        Self { slabs }
    }

    /// The cells of all slabs, in order of time; at least one.
    pub fn slabs(&self) -> &[Cells] {
        &self.slabs
    }

    /// The slab of a time, in seconds relative to the frame.
    #[inline(always)]
    pub fn slab_at(&self, time_secs: f64) -> usize {
        let last = self.slabs.len() - 1;
        if last == 0 {
            return 0;
        }
        let open = self.slabs[0].span().ends_secs()[0];
        let length = 2.0 * self.slabs[0].span().half_secs;
        // What is before the shutter opens becomes 0.
        (((time_secs - open) / length) as usize).min(last)
    }

    /// The cells of a time, in seconds relative to the frame.
    #[inline(always)]
    pub fn at(&self, time_secs: f64) -> &Cells {
        &self.slabs[self.slab_at(time_secs)]
    }

    /// Time that threads have spent on refinement so far, summed over them.
    pub fn refinement_secs(&self) -> f64 {
        self.slabs.iter().map(Cells::refinement_secs).sum()
    }

    /// Memory held now.
    pub fn structure_bytes(&self) -> usize {
        self.slabs.iter().map(Cells::structure_bytes).sum()
    }
}
