//! A device for the crate's own tests.

use crate::device::{AdapterChoice, Device, OpenOptions};

/// Any adapter that runs shaders. Without one the test `test` has to be skipped, which is said, unless
/// the environment forbids it.
pub(crate) fn device(test: &str) -> Option<Device> {
    let options = OpenOptions {
        choice: AdapterChoice::CardOrSoftware,
        lose_after: None,
    };
    match Device::open(options) {
        Ok(device) => Some(device),
        Err(error) => {
            assert!(
                std::env::var_os("MENISCUS_REQUIRE_GPU").is_none(),
                "{test}: {error}"
            );
            eprintln!("skipped {test}: {error}");
            None
        }
    }
}
