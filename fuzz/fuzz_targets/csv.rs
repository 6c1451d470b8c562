//! Tables with a header.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::particles::io::Format;

fuzz_target!(|bytes: &[u8]| meniscus_fuzz::read_as(&[Format::Csv], bytes));
