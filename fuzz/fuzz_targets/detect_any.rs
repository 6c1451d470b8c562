//! Any content, as a file on disk would be read: gzip, detection, every reader.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| meniscus_fuzz::read_any(bytes));
