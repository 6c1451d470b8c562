//! Environment images, Radiance HDR and OpenEXR.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::frame::Environment;
use meniscus::math::DVec3;

fuzz_target!(|bytes: &[u8]| {
    meniscus_fuzz::as_file(bytes, |path| {
        match Environment::read(path, [DVec3::X, DVec3::Y, DVec3::NEG_Z], 0.0) {
            Ok(environment) => {
                if let Some((direction, density)) = environment.sample([0.3, 0.7]) {
                    assert!(density > 0.0 && environment.radiance(direction).is_finite());
                }
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
});
