//! Third-party files that some tests read, where they are present.
//!
//! They lie in the folder that the environment variable `MENISCUS_DATA` names, else in
//! `shared/data` beside the repository. A test without them says so and ends; where
//! `MENISCUS_REQUIRE_DATA` is set, as on a machine that has them, it fails instead.

use std::path::{Path, PathBuf};

/// The folder of the data, if there is one.
pub fn folder() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = std::env::var_os("MENISCUS_DATA").map_or(beside, PathBuf::from);
    folder.is_dir().then_some(folder)
}

/// The file or folder at `relative` within the data; when it is missing the test should end, which
/// this function says on the terminal.
///
/// # Panics
/// When it is missing although `MENISCUS_REQUIRE_DATA` is set.
pub fn file(relative: &str) -> Option<PathBuf> {
    let found = folder()
        .map(|folder| folder.join(relative))
        .filter(|path| path.exists());
    if found.is_none() {
        skip_or_fail(relative);
    }
    found
}

/// Says that a test is skipped because `what` is missing.
///
/// # Panics
/// When `MENISCUS_REQUIRE_DATA` is set.
#[allow(
    clippy::print_stderr,
    reason = "called by tests, to the person who runs them"
)]
pub fn skip_or_fail(what: &str) {
    assert!(
        std::env::var_os("MENISCUS_REQUIRE_DATA").is_none(),
        "MENISCUS_REQUIRE_DATA is set, and {what} was not found (MENISCUS_DATA names its folder)"
    );
    eprintln!("skipped: {what} was not found (MENISCUS_DATA names its folder)");
}
