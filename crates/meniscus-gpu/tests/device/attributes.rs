//! Looks that follow particles' attributes, shaded by the device's stages, beside those of the CPU.

use crate::common::{device, moving};
use crate::staged_motion::CROWD;
use crate::stages::{LAMPS, SUN_AND_SKY, SURFACE, check_field, with};
use meniscus::field::{BlobField, FieldAttribute};
use meniscus::frame::{Frame, FrameSettings};
use meniscus::kernel::Kernel;
use meniscus::scene::IntegratorKind;
use meniscus::shade::{MOST_COLUMNS, ShadeSettings, Shader, Unstaged};
use meniscus_testing::corpus;
use meniscus_testing::turning::turning;

/// A set whose particles carry a number, a vector and a colour; some have none.
fn carrying(set: &str) -> BlobField {
    carried_by(corpus::scene(set, Kernel::Sextic, 400).field)
}

fn carried_by(mut field: BlobField) -> BlobField {
    let column = |name: &str, components: usize, number: &dyn Fn(usize, usize) -> f32| {
        let data = (0..field.len()).flat_map(|i| (0..components).map(move |c| number(i, c)));
        FieldAttribute {
            name: name.to_owned(),
            components,
            data: data.collect(),
        }
    };
    let wave = |i: usize, c: usize| {
        let place = field.center(i).to_array();
        0.5 + 0.5 * (3.0 * place[c % 3] + place[(c + 1) % 3] + c as f32).sin()
    };
    let attributes = vec![
        column("heat", 1, &|i, _| match i % 7 {
            3 => f32::NAN,
            _ => wave(i, 0),
        }),
        column("velocity", 3, &|i, c| wave(i, c) - 0.5),
        column("color", 3, &|i, c| wave(i, c).clamp(0.05, 0.95)),
    ];
    field.attributes = attributes;
    field
}

fn check(what: &str, integrator: &str, spp: u32, parts: &[&str], field: BlobField) {
    let Some(device) = device(what) else {
        return;
    };
    let varying = with(integrator, spp, parts);
    let ours = check_field(device, what, &varying, field.clone(), &[]);
    // The looks follow the attributes indeed.
    let parts: Vec<&str> = (parts.iter().copied())
        .filter(|part| !VARYING.contains(part))
        .collect();
    let plain = with(integrator, spp, &parts);
    let plain = check_field(device, what, &plain, field, &[]);
    let apart = ours.difference(&plain, 8).pixels;
    assert!(
        apart > 0.03,
        "{what}: {apart} of the pixels tell attributes"
    );
}

const BY_HEAT: &str = "color_by = \"heat\"\ncolor_map = \"plasma\"\n";
const BY_SPEED: &str = "color_by = \"velocity\"\n";
const BY_COLOR: &str = "color_by = \"color\"\n";
const ROUGH_BY_SPEED: &str = "roughness_by = \"velocity.y\"\nroughness_range = [-0.4, 0.6]\n";
const DENSE_BY_HEAT: &str = "absorption_by = \"heat\"\nabsorption_range = [-0.2, 0.3]\n";
const VARYING: [&str; 5] = [BY_HEAT, BY_SPEED, BY_COLOR, ROUGH_BY_SPEED, DENSE_BY_HEAT];
const METAL: &str = "material = \"m\"\n[material.m]\ntype = \"metal\"\n";
const PLASTIC: &str = "material = \"m\"\n[material.m]\ntype = \"plastic\"\nroughness = 0.3\n";
const INK: &str = "material = \"m\"
[material.m]
type = \"water\"
absorption = [0.2, 0.6, 0.9]
absorption_depth = 0.4
";
const FROSTED: &str = "material = \"m\"\n[material.m]\ntype = \"glass\"\nroughness = 0.2\n";
const BUBBLE: &str = "material = \"m\"\n[material.m]\ntype = \"glass\"\nthin = true\n";
const GROUND: &str = "[ground]\n";

#[test]
fn colours_follow_attributes() {
    let shaded = "type = \"shaded\"";
    let parts = [SURFACE, BY_HEAT, GROUND];
    check("colour by a number", shaded, 4, &parts, carrying("pool"));
    let parts = [SURFACE, BY_SPEED, LAMPS];
    check(
        "colour by a length",
        shaded,
        4,
        &parts,
        carrying("ellipsoids"),
    );
    let parts = [SURFACE, BY_COLOR, GROUND];
    check(
        "own colours",
        "type = \"ao\"\nsamples = 4",
        4,
        &parts,
        carrying("mixed"),
    );
    let parts = [SURFACE, BY_HEAT, SUN_AND_SKY];
    check("negative weights", shaded, 4, &parts, carrying("negative"));
}

#[test]
fn colours_follow_attributes_of_moving_particles() {
    let field = carried_by(moving(corpus::scene("pool", Kernel::Sextic, 400)).field);
    let shutter = "[motion]\nshutter = 1\nfps = 1\n";
    let parts = [shutter, SURFACE, BY_HEAT, GROUND];
    check("moving colours", "type = \"shaded\"", 16, &parts, field);
}

/// Fields that are turned, stretched and on their way.
#[test]
fn looks_follow_attributes_of_instances() {
    let (surface, instances) = CROWD.split_once("[[instance]]").expect("it has some");
    let instances = format!("[[instance]]{instances}");
    let parts = [surface, BY_HEAT, &instances, GROUND];
    let field = carried_by(turning(&corpus::scene("ellipsoids", Kernel::Sextic, 400), 0.5).field);
    check("a crowd in colour", "type = \"shaded\"", 8, &parts, field);
    let parts = [surface, BY_HEAT, DENSE_BY_HEAT, INK, &instances, GROUND];
    let whitted = "type = \"whitted\"\ndepth = 3";
    check("a crowd of ink", whitted, 4, &parts, carrying("pool"));
}

#[test]
fn roughness_follows_attributes() {
    let path = "type = \"path\"";
    let parts = [
        SURFACE,
        BY_COLOR,
        ROUGH_BY_SPEED,
        METAL,
        SUN_AND_SKY,
        GROUND,
    ];
    check("rough metal", path, 4, &parts, carrying("mixed"));
    let parts = [
        SURFACE,
        BY_SPEED,
        ROUGH_BY_SPEED,
        PLASTIC,
        SUN_AND_SKY,
        GROUND,
    ];
    check("rough coats", path, 4, &parts, carrying("pool"));
    let whitted = "type = \"whitted\"\ndepth = 4";
    let parts = [SURFACE, BY_HEAT, ROUGH_BY_SPEED, PLASTIC, LAMPS, GROUND];
    check("whitted", whitted, 1, &parts, carrying("pool"));
}

#[test]
fn absorption_follows_attributes() {
    let path = "type = \"path\"";
    let parts = [SURFACE, DENSE_BY_HEAT, INK, SUN_AND_SKY, GROUND];
    check("ink", path, 4, &parts, carrying("pool"));
    let parts = [SURFACE, BY_COLOR, DENSE_BY_HEAT, FROSTED, LAMPS, GROUND];
    check(
        "frosted",
        "type = \"path\"\ncaustics = false",
        4,
        &parts,
        carrying("mixed"),
    );
    let whitted = "type = \"whitted\"\ndepth = 4";
    let parts = [SURFACE, BY_HEAT, INK, LAMPS, GROUND];
    check("ink in whitted", whitted, 1, &parts, carrying("ellipsoids"));
    let parts = [
        SURFACE,
        BY_COLOR,
        DENSE_BY_HEAT,
        BUBBLE,
        SUN_AND_SKY,
        GROUND,
    ];
    check("sheets", path, 4, &parts, carrying("mixed"));
}

/// More numbers than stages keep: the processor shades, which is said.
#[test]
fn too_many_numbers_are_the_processor_s() {
    let mut field = carrying("pool");
    let components = MOST_COLUMNS + 1;
    let data = vec![0.5; components * field.len()];
    field.attributes[0] = FieldAttribute {
        name: "heat".to_owned(),
        components,
        data,
    };
    let text = with("type = \"shaded\"", 1, &[SURFACE, BY_HEAT]);
    let scene = meniscus::scene::file::parse(&text, "test").expect("the scene is sound");
    let frame = Frame::build(&scene, vec![field], &FrameSettings::default()).expect("it is sound");
    let mut settings = ShadeSettings::default();
    settings.integrator.kind = IntegratorKind::Shaded;
    let staged = Shader::new(&frame, &settings).staged();
    assert_eq!(staged.map(|_| ()), Err(Unstaged::Attributes));
}
