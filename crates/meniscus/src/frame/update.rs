//! Moving sets: the next field of a surface in the structure of the one before.

use super::Blobs;
use crate::accel::Accel;
use crate::field::BlobField;
use crate::primitive::Shapes;
use std::sync::OnceLock;

/// What [`Blobs::update`] did with the structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update {
    /// The old tree holds the blobs where they are now.
    Refitted,
    /// A new structure was built.
    Rebuilt,
}

impl Blobs {
    /// Replaces the field, for the next frame of a moving set. Engines `particles` and `interval` refit
    /// their tree where the same blobs have moved a little, at a tenth of the cost of a build; all
    /// others build. Both trace the same surface; their answers may differ in the last bits.
    pub fn update(&mut self, field: BlobField) -> Update {
        let same_blobs = field.len() == self.field.len()
            && matches!(field.shapes, Shapes::Balls(_))
                == matches!(self.field.shapes, Shapes::Balls(_));
        match &mut self.accel {
            Accel::Particles(tree) | Accel::Interval(tree) if same_blobs && tree.suits(&field) => {
                tree.refit(&field);
                if !tree.is_worn() {
                    field.support_tree();
                    self.field = field;
                    self.exact = OnceLock::new();
                    return Update::Refitted;
                }
            }
            Accel::Particles(_)
            | Accel::Interval(_)
            | Accel::Cells(_)
            | Accel::Metaballs(_)
            | Accel::Sweep(_)
            | Accel::Elsewhere => {}
        }
        let engine = self.accel.engine();
        *self = Self::build_with(field, engine, self.settings, self.level);
        Update::Rebuilt
    }
}
