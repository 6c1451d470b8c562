//! Scene files in TOML and JSON.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::scene::file;

fuzz_target!(|text: &str| {
    for name in ["scene.toml", "scene.json"] {
        if let Err(error) = file::parse(text, name) {
            assert!(!error.to_string().is_empty());
        }
    }
});
