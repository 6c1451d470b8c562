//! What one rendering hands to the next.

use crate::shade::ShadeScratch;
use std::sync::{Mutex, PoisonError};

/// Carried through the frames of a sequence: threads find the work buffers of the frame before, grown
/// to what its leaves needed, instead of making their own. A picture never depends on it.
#[derive(Default)]
pub struct RenderState {
    idle: Mutex<Vec<ShadeScratch>>,
}

impl RenderState {
    /// Nothing handed over yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Buffers of which nothing but their capacity and their counters (all 0) matters, returned when
    /// the loan ends.
    pub(super) fn borrow(&self) -> ScratchLoan<'_> {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        ScratchLoan {
            state: self,
            scratch: idle.pop().unwrap_or_default(),
        }
    }
}

/// Buffers lent to one thread.
pub(super) struct ScratchLoan<'a> {
    state: &'a RenderState,
    pub(super) scratch: ShadeScratch,
}

impl Drop for ScratchLoan<'_> {
    fn drop(&mut self) {
        let mut scratch = std::mem::take(&mut self.scratch);
        // A cancelled frame leaves counts that the next one must not inherit.
        scratch.rays = Default::default();
        scratch.trace.counters = Default::default();
        let mut idle = self
            .state
            .idle
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        idle.push(scratch);
    }
}
