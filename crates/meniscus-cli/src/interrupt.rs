//! Ctrl-C: the first asks to stop, the second stops at once.

use crate::exit::{Failure, Outcome};
use std::sync::atomic::{AtomicBool, Ordering};

/// Set once somebody pressed Ctrl-C (or sent SIGTERM).
pub(crate) static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Watches for Ctrl-C from now on.
pub(crate) fn watch() -> Outcome {
    ctrlc::set_handler(|| {
        if CANCELLED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    })
    .map_err(|error| Failure::work(format!("cannot watch for Ctrl-C: {error}")))
}

/// Ends the work if somebody asked for it.
pub(crate) fn check() -> Outcome {
    if CANCELLED.load(Ordering::SeqCst) {
        return Err(Failure::Interrupted);
    }
    Ok(())
}
