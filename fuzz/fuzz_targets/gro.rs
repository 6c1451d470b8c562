//! GRO files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::particles::io::Format;

fuzz_target!(|bytes: &[u8]| meniscus_fuzz::read_as(&[Format::Gro], bytes));
