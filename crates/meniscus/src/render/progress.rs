//! How far a rendering is, and how to stop it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Called with (samples done, samples in all) whenever a tile is done, from any thread; may be late
/// by a tile, never runs backwards for one thread.
type ProgressCallback<'a> = dyn Fn(u64, u64) + Sync + 'a;

/// Watches and stops a rendering from outside.
#[derive(Default)]
pub struct Progress<'a> {
    done: AtomicU64,
    cancel: Option<&'a AtomicBool>,
    callback: Option<&'a ProgressCallback<'a>>,
}

impl<'a> Progress<'a> {
    /// Nobody watches, nobody stops.
    pub fn none() -> Self {
        Self::default()
    }

    /// With a flag: once it is true the rendering returns promptly, without a film.
    #[must_use]
    pub fn with_cancel(self, cancel: &'a AtomicBool) -> Self {
        Self {
            cancel: Some(cancel),
            ..self
        }
    }

    /// With a function to call.
    #[must_use]
    pub fn with_callback(self, callback: &'a ProgressCallback<'a>) -> Self {
        Self {
            callback: Some(callback),
            ..self
        }
    }

    /// Samples done so far, over all renderings that were given this watcher.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Whether somebody asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel
            .is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    pub(super) fn advance(&self, samples: u64, total: u64) {
        let done = self.done.fetch_add(samples, Ordering::Relaxed) + samples;
        if let Some(callback) = self.callback {
            callback(done, total);
        }
    }
}
