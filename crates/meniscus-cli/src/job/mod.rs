//! From arguments to a validated job: what the words mean, and whether they make sense together.

pub(crate) mod columns;
pub(crate) mod device;
pub(crate) mod engine;
pub(crate) mod files;
pub(crate) mod input;
pub(crate) mod load;
pub(crate) mod output;
pub(crate) mod scene;
pub(crate) mod trajectory;
pub(crate) mod watch;
