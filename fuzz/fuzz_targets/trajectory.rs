//! Trajectories: XTC, TRR and DCD.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| meniscus_fuzz::read_trajectory(bytes));
