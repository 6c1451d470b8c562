//! What stages do not know.

use super::Shader;
use super::varying::MOST_COLUMNS;
use thiserror::Error;

/// Why the processor has to shade a picture whose rays a device traces: the whole list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unstaged {
    /// Media around the eye that may be others at other times.
    #[error("the eye may come into or out of clear surfaces while the shutter is open")]
    MovingMedia,
    /// An eye from which all is at one distance.
    #[error("the camera is more than a thousand times as far away as the scene is large")]
    FarEye,
    /// Looks that follow more numbers of particles than stages keep.
    #[error("a surface's looks follow more than {MOST_COLUMNS} numbers of its particles")]
    Attributes,
    /// More surfaces than a device's stack of media can name.
    #[error("there are more than {MOST_SURFACES} surfaces")]
    ManySurfaces,
    /// No particles: there is nothing for a device.
    #[error("there are no particles")]
    NoBlobs,
    /// The device has no room for them, or binds too few buffers.
    #[error("the card has no room for more")]
    Room,
    /// The device traces by a method of its own.
    #[error("its engine traces rays alone")]
    Engine,
}

/// Most surfaces of a frame that stages shade: a stack of media names them by four bits.
pub const MOST_SURFACES: usize = 14;

impl Shader<'_> {
    /// Whether stages know all that there is.
    pub(super) fn check_stages(&self) -> Result<(), Unstaged> {
        let frame = self.world.frame;
        let found = [
            (
                frame.instances.len() > MOST_SURFACES,
                Unstaged::ManySurfaces,
            ),
            (self.media.is_none(), Unstaged::MovingMedia),
        ];
        match found.iter().find(|(is_so, _)| *is_so) {
            Some(&(_, why)) => Err(why),
            None => Ok(()),
        }
    }
}
