//! glTF meshes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use meniscus::mesh::MeshFormat;

fuzz_target!(|bytes: &[u8]| meniscus_fuzz::read_mesh(MeshFormat::Gltf, bytes));
