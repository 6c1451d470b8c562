//! Engine `peel`: the first surfaces that one camera sees, by what its tiles of pixels may meet instead of
//! a tree (Kanamori, Szego & Nishita 2008, "GPU-based Fast Ray Casting for a Large Number of Metaballs").
//!
//! Two variants share the lists of balls per tile. With sprites, supports are drawn over and over, each
//! time the next layer of entries and exits, as in the paper; with tiles, every ray walks its tile's
//! list, which is sorted by distance, with the solver of the tree's shaders. Rays that are not the
//! camera's own, or that f32 cannot decide, go to the tree over particles.

mod balls;
mod field;
#[cfg(test)]
mod list_tests;
mod programs;
mod room;
mod round;
mod shader;
mod slots;
mod sprites;
mod times;
mod tracer;
mod view;

pub use field::{PeelField, PeelOptions, PeelWork};
pub use shader::{PeelKind, PeelModule, peel_sources};
pub use times::StageSecs;
pub use tracer::PeelTracer;
pub use view::View;

use crate::device::Device;
use crate::error::GpuError;
use meniscus::scene::PeelVariant;
use room::{Room, RoomKind};
use std::sync::{Mutex, PoisonError};

/// How the sprites' variant finds the first root between two events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Clipping {
    /// Nothing is left out without a proof.
    Own,
    /// The paper's rule, lists and cases, which lose some.
    Kanamori,
}

impl Clipping {
    /// What the scene's switch means here; `None`: nothing.
    fn of(clipping: meniscus::scene::Clipping) -> Option<Self> {
        match clipping {
            meniscus::scene::Clipping::Own => Some(Self::Own),
            meniscus::scene::Clipping::Nishita => None,
            meniscus::scene::Clipping::Kanamori => Some(Self::Kanamori),
        }
    }
}

/// Pairs of balls and tiles that there is room for at first.
const FIRST_PAIRS: u32 = 1 << 18;

/// What a device keeps for the engine.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    programs: programs::Programs,
    idle: Mutex<Vec<Room>>,
}

impl Kept {
    /// Room for a round of up to `slots` rays that meet up to `capacity` balls at a time.
    fn borrow(
        &self,
        device: &Device,
        (variant, slots, capacity): (PeelVariant, u32, u32),
    ) -> Result<Room, GpuError> {
        let limits = &device.limits;
        let largest = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let side = shader::tile(variant);
        let fitting = largest / (16 * u64::from(capacity.max(4)));
        let groups = slots.min(fitting.min(1 << 20) as u32) / (side * side);
        let kind = RoomKind {
            variant,
            slots: groups.max(1) * side * side,
            groups: groups.max(1),
            capacity,
        };
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = idle.iter().position(|room| room.kind == kind) {
            return Ok(idle.swap_remove(at));
        }
        drop(idle);
        Room::new(device, kind, FIRST_PAIRS)
    }

    fn give_back(&self, room: Room) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(room);
    }
}
