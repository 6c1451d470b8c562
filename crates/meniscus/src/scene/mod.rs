//! The scene at rest: plain serialisable data, as scene files and the command line describe it.

pub mod surface;
