//! What stages do not know.

use super::Shader;
use super::varying::MOST_COLUMNS;
use crate::frame::{Geometry, Instance};
use glam::DMat3;
use thiserror::Error;

/// Why the processor has to shade a picture whose rays a device traces: the whole list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unstaged {
    /// A triangle mesh.
    #[error("there are meshes")]
    Mesh,
    /// Planes that cut.
    #[error("surfaces are cut open")]
    Cuts,
    /// Blobs or spheres that an instance turns or stretches.
    #[error("instances turn or stretch surfaces")]
    Turned,
    /// An instance that moves while the shutter is open.
    #[error("instances move while the shutter is open")]
    MovingInstance,
    /// Media that may be others at other times.
    #[error("clear surfaces move while the shutter is open")]
    MovingMedia,
    /// Blobs that turn while the shutter is open.
    #[error("particles turn while the shutter is open")]
    TurningBlobs,
    /// A camera that moves while the shutter is open.
    #[error("the camera moves while the shutter is open")]
    MovingCamera,
    /// An eye from which all is at one distance.
    #[error("the camera is more than a thousand times as far away as the scene is large")]
    FarEye,
    /// Looks that follow more numbers of particles than stages keep.
    #[error("a surface's looks follow more than {MOST_COLUMNS} numbers of its particles")]
    Attributes,
    /// Wider highlights.
    #[error("specular_antialiasing is on")]
    SpecularAntialiasing,
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

/// Whether an instance only moves what it places.
fn is_upright(instance: &Instance) -> bool {
    instance.world_from_object.matrix3 == DMat3::IDENTITY
}

impl Shader<'_> {
    /// Whether stages know all that there is.
    pub(super) fn check_stages(&self) -> Result<(), Unstaged> {
        let frame = self.world.frame;
        let integrator = &self.settings.integrator;
        let turns = |geometry: &Geometry| {
            let motion = geometry
                .blobs()
                .and_then(|blobs| blobs.field.motion.as_ref());
            motion.is_some_and(crate::field::Motion::turns)
        };
        let may_turn = |instance: &Instance| {
            matches!(
                frame.geometries[instance.geometry as usize],
                Geometry::Plane(_)
            )
        };
        let found = [
            (self.settings.eye_moves, Unstaged::MovingCamera),
            (
                (frame.instances.iter()).any(|instance| instance.path.is_some()),
                Unstaged::MovingInstance,
            ),
            (!frame.clips.is_empty(), Unstaged::Cuts),
            (
                (frame.geometries.iter()).any(|g| matches!(g, Geometry::Mesh(_))),
                Unstaged::Mesh,
            ),
            (
                (frame.instances.iter()).any(|i| !is_upright(i) && !may_turn(i)),
                Unstaged::Turned,
            ),
            (frame.geometries.iter().any(turns), Unstaged::TurningBlobs),
            (
                integrator.specular_antialiasing,
                Unstaged::SpecularAntialiasing,
            ),
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
