//! Pictures whose highlights are widened (`specular_antialiasing`), shaded by the device's stages beside
//! those of the CPU.

use crate::common::device;
use crate::staged_motion::{CROWD, FLIGHT};
use crate::stages::{BALLS, LAMPS, SUN_AND_SKY, SURFACE, check_field, with};
use meniscus::field::BlobField;
use meniscus::kernel::Kernel;
use meniscus_gpu::Device;
use meniscus_testing::corpus;
use meniscus_testing::turning::turning;

fn set(name: &str) -> BlobField {
    corpus::scene(name, Kernel::Sextic, 400).field
}

/// Both machines widen alike, and it is seen.
fn check_widened(
    device: &Device,
    what: &str,
    integrator: &str,
    spp: u32,
    parts: &[&str],
    field: impl Fn() -> BlobField,
) {
    let [plain, wide] = [false, true].map(|widens| {
        let integrator = format!("{integrator}\nspecular_antialiasing = {widens}");
        check_field(device, what, &with(&integrator, spp, parts), field(), &[])
    });
    let changed = wide.difference(&plain, 2).pixels;
    // More than the budget lets both machines differ by.
    assert!(changed > 3e-3, "{what}: {changed} of the pixels differ");
}

const METAL: &str = "material = \"steel\"\n[material.steel]\ntype = \"metal\"\nroughness = 0.15\n";
const COAT: &str =
    "material = \"lacquer\"\n[material.lacquer]\ntype = \"plastic\"\nroughness = 0.1\n";
const GLOSS: &str = "material = \"gloss\"\n[material.gloss]\ntype = \"glossy\"\nroughness = 0.1\n";

#[test]
fn highlights_of_shaded_are_widened_as_on_the_cpu() {
    let Some(device) = device("highlights_of_shaded_are_widened_as_on_the_cpu") else {
        return;
    };
    let shaded = "type = \"shaded\"";
    let parts = &[SURFACE, GLOSS, LAMPS, SUN_AND_SKY, BALLS];
    check_widened(device, "gloss", shaded, 1, parts, || set("mixed"));
}

#[test]
fn highlights_of_trees_are_widened_as_on_the_cpu() {
    let Some(device) = device("highlights_of_trees_are_widened_as_on_the_cpu") else {
        return;
    };
    let whitted = "type = \"whitted\"\ndepth = 4";
    let cut = "[[clip]]\npoint = [0.8, 0, 0]\nnormal = [1, 0, 0.3]\n";
    let parts = &[SURFACE, METAL, LAMPS, SUN_AND_SKY, BALLS, cut];
    check_widened(device, "metal cut open", whitted, 1, parts, || set("mixed"));
    let field = || turning(&corpus::scene("ellipsoids", Kernel::Wyvill, 400), 0.8).field;
    let motion = "[motion]\nshutter = 1\nfps = 1\n";
    let parts = &[SURFACE, METAL, motion, LAMPS];
    check_widened(device, "metal that turns", whitted, 4, parts, field);
    let crowd = CROWD.replace("file", "material = \"coat\"\nfile");
    let flight = FLIGHT.split_once("fps = 1\n").expect("it has keys").1;
    let parts = &[crowd.as_str(), flight, LAMPS, BALLS];
    check_widened(device, "a crowd", whitted, 4, parts, || set("mixed"));
}

#[test]
fn highlights_on_paths_are_widened_as_on_the_cpu() {
    let Some(device) = device("highlights_on_paths_are_widened_as_on_the_cpu") else {
        return;
    };
    let path = "type = \"path\"\ndepth = 2";
    let parts = &[SURFACE, METAL, LAMPS, BALLS];
    check_widened(device, "metal", path, 4, parts, || set("ellipsoids"));
    let parts = &[SURFACE, COAT, FLIGHT, LAMPS, BALLS];
    check_widened(device, "a flight", path, 4, parts, || set("mixed"));
}
