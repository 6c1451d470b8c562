//! Every shader is valid, on any machine: no adapter is asked.

use meniscus::kernel::Kernel;
use meniscus::scene::{IntegratorKind, PeelVariant};
use meniscus_gpu::{
    BuildKind, BuildStep, Clipping, FieldMotion, FieldStage, PeelKind, PeelModule, ShaderKind,
    StageModule, peel_sources, sources,
};
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn kinds() -> Vec<ShaderKind> {
    let mut kinds = Vec::new();
    for kernel in Kernel::ALL {
        for (ellipsoids, motion) in [
            (false, FieldMotion::Still),
            (false, FieldMotion::Moves),
            (true, FieldMotion::Still),
            (true, FieldMotion::Moves),
            (true, FieldMotion::Turns),
        ] {
            for chunks in [1, 3] {
                kinds.push(ShaderKind {
                    kernel,
                    ellipsoids,
                    motion,
                    chunks,
                    chunk_bits: 23,
                    stack: 64,
                });
            }
        }
    }
    kinds
}

fn module(kind: &ShaderKind) -> naga::Module {
    let text = sources(kind);
    naga::front::wgsl::parse_str(&text)
        .unwrap_or_else(|error| panic!("{kind:?}: {}", error.emit_to_string(&text)))
}

#[test]
fn all_are_valid() {
    for kind in kinds() {
        let module = module(&kind);
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        if let Err(error) = validator.validate(&module) {
            panic!("{kind:?}: {}", error.emit_to_string(&sources(&kind)));
        }
        let entries: Vec<&str> = module
            .entry_points
            .iter()
            .map(|e| e.name.as_str())
            .collect();
        assert_eq!(entries, ["closest", "occluded", "crossings"]);
    }
}

#[test]
fn those_that_build_are_valid() {
    for (ellipsoids, moves) in [(false, false), (false, true), (true, false), (true, true)] {
        for chunks in [1, 3] {
            let kind = BuildKind {
                ellipsoids,
                moves,
                raw_chunks: chunks,
                tree_chunks: chunks + 1,
                chunk_bits: 23,
            };
            for step in BuildStep::ALL {
                let text = kind.sources(step);
                let module = naga::front::wgsl::parse_str(&text)
                    .unwrap_or_else(|error| panic!("{step:?}: {}", error.emit_to_string(&text)));
                let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
                if let Err(error) = validator.validate(&module) {
                    panic!("{step:?}: {}", error.emit_to_string(&text));
                }
            }
        }
    }
}

#[test]
fn those_of_peel_are_valid() {
    for kernel in Kernel::ALL {
        for (variant, clipping) in [
            (PeelVariant::Tiles, Clipping::Own),
            (PeelVariant::Sprites, Clipping::Own),
            (PeelVariant::Sprites, Clipping::Kanamori),
        ] {
            let kind = PeelKind {
                kernel,
                variant,
                clipping,
            };
            for &module in PeelModule::of(variant) {
                let text = peel_sources(&kind, module);
                let parsed = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| {
                    panic!("{kind:?} {module:?}: {}", error.emit_to_string(&text))
                });
                let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
                if let Err(error) = validator.validate(&parsed) {
                    panic!("{kind:?} {module:?}: {}", error.emit_to_string(&text));
                }
                assert!(!parsed.entry_points.is_empty(), "{module:?}");
            }
        }
    }
}

#[test]
fn stages_are_valid() {
    for module in StageModule::all() {
        let text = module.sources();
        let parsed = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|error| panic!("{module:?}: {}", error.emit_to_string(&text)));
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        if let Err(error) = validator.validate(&parsed) {
            panic!("{module:?}: {}", error.emit_to_string(&text));
        }
        let entries = parsed.entry_points.iter();
        let entries: Vec<&str> = entries.map(|entry| entry.name.as_str()).collect();
        assert_eq!(entries, module.entry_points(), "{module:?}");
    }
}

#[test]
fn those_that_look_at_particles_are_valid() {
    for kind in kinds() {
        for stage in [
            FieldStage::Attributes(1),
            FieldStage::Attributes(8),
            FieldStage::Derivatives,
        ] {
            let text = stage.sources(&kind);
            let parsed = naga::front::wgsl::parse_str(&text)
                .unwrap_or_else(|error| panic!("{kind:?}: {}", error.emit_to_string(&text)));
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            if let Err(error) = validator.validate(&parsed) {
                panic!("{kind:?}: {}", error.emit_to_string(&text));
            }
            let entries: Vec<&str> = (parsed.entry_points.iter())
                .map(|entry| entry.name.as_str())
                .collect();
            assert_eq!(entries, [stage.entry_point()]);
        }
    }
}

/// Records are written as plain words: these are the places that the host counts on.
#[test]
fn structs_lie_as_the_host_writes_them() {
    let module = module(&kinds()[0]);
    let offsets = |name: &str| offsets_in(&module, name);
    assert_eq!(offsets("Params"), ((0..9).map(|i| 4 * i).collect(), 36));
    assert_eq!(
        offsets("LocalRay"),
        (vec![0, 12, 16, 28, 32, 44, 48, 60], 64)
    );
    assert_eq!(offsets("HitRecord"), (vec![0, 4, 8, 12, 16, 28], 32));
}

#[test]
fn structs_of_stages_lie_as_the_host_writes_them() {
    let parsed =
        |module: StageModule| naga::front::wgsl::parse_str(&module.sources()).expect("it is valid");
    let rows = |count: u32| (0..count).flat_map(|row| [16 * row, 16 * row + 12]);
    let surfaces = parsed(StageModule::Surfaces);
    let picture = rows(10).chain((160..176).step_by(4)).chain([176]);
    let picture = picture.chain((192..304).step_by(4)).collect();
    assert_eq!(offsets_in(&surfaces, "Picture"), (picture, 304));
    assert_eq!(offsets_in(&surfaces, "FieldPlace"), (rows(4).collect(), 64));
    assert_eq!(offsets_in(&surfaces, "Question"), (rows(4).collect(), 64));
    assert_eq!(offsets_in(&surfaces, "Seen"), (rows(3).collect(), 48));
    assert_eq!(offsets_in(&surfaces, "Owner"), (vec![0, 4, 8], 12));
    assert_eq!(offsets_in(&surfaces, "LocalRay"), (rows(4).collect(), 64));
    assert_eq!(offsets_in(&surfaces, "HitRecord").1, 32);
    assert_eq!(offsets_in(&surfaces, "Answer").1, 80);
    assert_eq!(offsets_in(&surfaces, "State").1, 112);
    let whitted = parsed(StageModule::Integrator(IntegratorKind::Whitted));
    assert_eq!(offsets_in(&whitted, "Branch").1, 96);
    assert_eq!(offsets_in(&whitted, "Look").1, 48);
    assert_eq!(offsets_in(&whitted, "Differential").1, 112);
    assert_eq!(offsets_in(&whitted, "LevelSet").1, 80);
}

#[test]
fn structs_of_peel_lie_as_the_host_writes_them() {
    let kind = PeelKind {
        kernel: Kernel::Sextic,
        variant: PeelVariant::Sprites,
        clipping: Clipping::Own,
    };
    let text = peel_sources(&kind, PeelModule::Slots);
    let module = naga::front::wgsl::parse_str(&text).expect("it is valid");
    let offsets = |name: &str| offsets_in(&module, name);
    let params = (0..12).map(|i| 4 * i);
    let params = params.chain([48, 64, 80, 96, 112, 128, 136, 144, 148, 152]);
    assert_eq!(offsets("Params"), (params.collect(), 160));
    assert_eq!(
        offsets("LocalRay"),
        (vec![0, 12, 16, 28, 32, 44, 48, 60], 64)
    );
    assert_eq!(offsets("HitRecord"), (vec![0, 4, 8, 12, 16, 28], 32));
    assert_eq!(offsets("SlotState"), ((0..8).map(|i| 4 * i).collect(), 32));
}

/// Where the members of a struct lie, and its size.
fn offsets_in(module: &naga::Module, name: &str) -> (Vec<u32>, u32) {
    let (_, found) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some(name))
        .unwrap_or_else(|| panic!("there is no struct {name}"));
    let naga::TypeInner::Struct { members, span } = &found.inner else {
        panic!("{name} is no struct");
    };
    let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
    (offsets, *span)
}
