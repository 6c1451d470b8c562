//! The stages' shaders, put together from files that are named as their CPU twins.

use super::field_stage::FIRST_CHUNK;
use crate::shader::{NONE, ShaderKind, WORKGROUP, constants, field_parts, params_at};
use meniscus::render::STRIP_ROWS;
use meniscus::scene::IntegratorKind;
use meniscus::shade::{
    ALBEDO_ENTRIES, EMITTER_WORDS, MAP_ENTRIES, MATERIAL_WORDS, NO_NUMBER, SURFACE_WORDS,
};

/// Steps of the pixel filter's table.
pub(crate) const FILTER_STEPS: u32 = 1025;

/// One shader of the stages, with one or a few entry points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StageModule {
    /// The eye's rays.
    Begin,
    /// Planes, spheres and meshes; questions clipped to fields, and answers merged.
    Surfaces,
    /// An integrator.
    Integrator(IntegratorKind),
}

/// What all have.
const COMMON: [&str; 4] = [
    include_str!("../shaders/math/two_floats.wgsl"),
    include_str!("../shaders/math/sampling.wgsl"),
    include_str!("../shaders/frame/looks.wgsl"),
    include_str!("../shaders/shade/asking.wgsl"),
];

const BEGIN: [&str; 5] = [
    include_str!("../shaders/math/cubics.wgsl"),
    include_str!("../shaders/math/level_set.wgsl"),
    include_str!("../shaders/math/differential.wgsl"),
    include_str!("../shaders/scene/camera.wgsl"),
    include_str!("../shaders/shade/begin.wgsl"),
];

const SURFACES: [&str; 8] = [
    include_str!("../shaders/intersect/place.wgsl"),
    include_str!("../shaders/math/cubics.wgsl"),
    include_str!("../shaders/frame/way.wgsl"),
    include_str!("../shaders/intersect/cuts.wgsl"),
    include_str!("../shaders/intersect/solids.wgsl"),
    include_str!("../shaders/intersect/mesh.wgsl"),
    include_str!("../shaders/intersect/world.wgsl"),
    include_str!("../shaders/intersect/clip.wgsl"),
];

/// What all integrators have.
const SHADING: [&str; 8] = [
    include_str!("../shaders/shade/light/lights.wgsl"),
    include_str!("../shaders/shade/light/sun.wgsl"),
    include_str!("../shaders/shade/light/sky.wgsl"),
    include_str!("../shaders/shade/light/sphere.wgsl"),
    include_str!("../shaders/shade/light/rectangle.wgsl"),
    include_str!("../shaders/shade/light/environment.wgsl"),
    include_str!("../shaders/shade/varying.wgsl"),
    include_str!("../shaders/shade/end.wgsl"),
];

/// What those have that widen highlights.
const WIDENING: [&str; 5] = [
    include_str!("../shaders/math/cubics.wgsl"),
    include_str!("../shaders/frame/way.wgsl"),
    include_str!("../shaders/math/level_set.wgsl"),
    include_str!("../shaders/math/differential.wgsl"),
    include_str!("../shaders/shade/antialias.wgsl"),
];

/// What those have that scatter rays.
const SCATTERING: [&str; 14] = [
    include_str!("../shaders/shade/light/drawn.wgsl"),
    include_str!("../shaders/shade/bsdf/bsdf.wgsl"),
    include_str!("../shaders/shade/bsdf/fresnel.wgsl"),
    include_str!("../shaders/shade/bsdf/microfacet.wgsl"),
    include_str!("../shaders/shade/bsdf/albedo.wgsl"),
    include_str!("../shaders/shade/bsdf/diffuse.wgsl"),
    include_str!("../shaders/shade/bsdf/conductor.wgsl"),
    include_str!("../shaders/shade/bsdf/plastic.wgsl"),
    include_str!("../shaders/shade/bsdf/dielectric.wgsl"),
    include_str!("../shaders/shade/bsdf/foam.wgsl"),
    include_str!("../shaders/shade/bsdf/sheet.wgsl"),
    include_str!("../shaders/shade/medium.wgsl"),
    include_str!("../shaders/shade/world.wgsl"),
    include_str!("../shaders/shade/heard.wgsl"),
];

/// What stages have that look at a field's particles at a point, and their parameters' binding.
const AT_POINT: [&str; 4] = [
    include_str!("../shaders/math/cubics.wgsl"),
    include_str!("../shaders/frame/way.wgsl"),
    include_str!("../shaders/intersect/place.wgsl"),
    include_str!("../shaders/field/at_point.wgsl"),
];
const PARAMS: u32 = 12;

/// What the stage has that blends attributes.
const ATTRIBUTES: [&str; 3] = [
    include_str!("../shaders/shade/light/drawn.wgsl"),
    include_str!("../shaders/shade/medium.wgsl"),
    include_str!("../shaders/shade/attributes.wgsl"),
];

/// What the stage has that takes a field's derivatives.
const DERIVATIVES: [&str; 3] = [
    include_str!("../shaders/math/level_set.wgsl"),
    include_str!("../shaders/math/differential.wgsl"),
    include_str!("../shaders/field/derivatives.wgsl"),
];

const SHADED: [&str; 2] = [
    include_str!("../shaders/shade/gloss.wgsl"),
    include_str!("../shaders/shade/integrator/shaded.wgsl"),
];
const AO: [&str; 1] = [include_str!("../shaders/shade/integrator/ao.wgsl")];
const WHITTED: [&str; 1] = [include_str!("../shaders/shade/integrator/whitted.wgsl")];
const PATH: [&str; 1] = [include_str!("../shaders/shade/integrator/path.wgsl")];

impl StageModule {
    /// Every module.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::Begin, Self::Surfaces]
            .into_iter()
            .chain(IntegratorKind::ALL.map(Self::Integrator))
    }

    /// Its entry points.
    pub fn entry_points(self) -> &'static [&'static str] {
        match self {
            Self::Begin => &["begin"],
            Self::Surfaces => &["solids", "clip", "merge"],
            Self::Integrator(_) => &["shade"],
        }
    }

    fn parts(self) -> Vec<&'static [&'static str]> {
        match self {
            Self::Begin => vec![&BEGIN],
            Self::Surfaces => vec![&SURFACES],
            Self::Integrator(IntegratorKind::Shaded) => vec![&SHADING, &WIDENING, &SHADED],
            Self::Integrator(IntegratorKind::Ao) => vec![&SHADING, &AO],
            Self::Integrator(IntegratorKind::Whitted) => {
                vec![&SHADING, &WIDENING, &SCATTERING, &WHITTED]
            }
            Self::Integrator(IntegratorKind::Path) => {
                vec![&SHADING, &WIDENING, &SCATTERING, &PATH]
            }
        }
    }

    /// Its whole text.
    pub fn sources(self) -> String {
        let texts = COMMON.iter().chain(self.parts().into_iter().flatten());
        let texts: Vec<&str> = texts.copied().collect();
        numbers() + &texts.join("\n")
    }
}

fn numbers() -> String {
    constants([
        NONE,
        ("WORKGROUP", WORKGROUP),
        ("SURFACE_WORDS", SURFACE_WORDS),
        ("MATERIAL_WORDS", MATERIAL_WORDS),
        ("EMITTER_WORDS", EMITTER_WORDS),
        ("STRIP_ROWS", STRIP_ROWS),
        ("FILTER_STEPS", FILTER_STEPS),
        ("ALBEDO_ENTRIES", ALBEDO_ENTRIES),
    ])
}

/// A stage that looks at a field's particles where rays hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FieldStage {
    /// Blends so many numbers of each particle.
    Attributes(u32),
    /// Takes the field's derivatives.
    Derivatives,
}

impl FieldStage {
    /// Its entry point.
    pub fn entry_point(self) -> &'static str {
        match self {
            Self::Attributes(_) => "attributes",
            Self::Derivatives => "derivatives",
        }
    }

    /// Its whole text for a kind of field.
    pub fn sources(self, kind: &ShaderKind) -> String {
        let own = constants([("STACK", kind.stack)]);
        let (own, parts): (String, [&[&str]; 2]) = match self {
            Self::Attributes(columns) => {
                let more = constants([
                    ("COLUMNS", columns),
                    ("MAP_ENTRIES", MAP_ENTRIES),
                    ("NO_NUMBER", NO_NUMBER),
                ]);
                (own + &more, [&SHADING, &ATTRIBUTES])
            }
            Self::Derivatives => (own, [&DERIVATIVES, &[]]),
        };
        let field = field_parts(kind, FIRST_CHUNK);
        let texts = COMMON.iter().chain(&AT_POINT);
        let texts = texts.chain(parts.into_iter().flatten());
        let texts: Vec<&str> = (field.iter().map(String::as_str))
            .chain(texts.copied())
            .collect();
        numbers() + &own + &params_at(PARAMS) + &texts.join("\n")
    }
}
