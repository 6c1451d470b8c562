//! Shaders of engine `peel`, put together from files as those that walk the tree.

use super::Clipping;
use crate::shader::{WORKGROUP, kernel_source};
use meniscus::kernel::Kernel;
use meniscus::scene::PeelVariant;

/// What a shader of engine `peel` is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PeelKind {
    /// Kernel of the field.
    pub kernel: Kernel,
    /// Which way.
    pub variant: PeelVariant,
    /// How roots are found between two events; the tiled lists have the solver of the tree's shaders.
    pub clipping: Clipping,
}

/// Side of the film's tiles in pixels.
pub(super) fn tile(variant: PeelVariant) -> u32 {
    match variant {
        PeelVariant::Tiles => 8,
        PeelVariant::Sprites => 32,
    }
}

/// A shader module of engine `peel`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeelModule {
    /// Which balls may be seen in which tile.
    Bins,
    /// Where each tile's list begins.
    Scan,
    /// Lists in order.
    Sort,
    /// Rays through sorted lists.
    Tiled,
    /// Sprites of balls.
    Sprites,
    /// What happens between two layers of sprites.
    Slots,
}

impl PeelModule {
    /// Those of a variant.
    pub fn of(variant: PeelVariant) -> &'static [Self] {
        match variant {
            PeelVariant::Tiles => &[Self::Bins, Self::Scan, Self::Sort, Self::Tiled],
            PeelVariant::Sprites => &[
                Self::Bins,
                Self::Scan,
                Self::Sort,
                Self::Sprites,
                Self::Slots,
            ],
        }
    }
}

/// The whole text of a module.
pub fn peel_sources(kind: &PeelKind, module: PeelModule) -> String {
    let numbers = numbers(kind);
    let mut parts = vec![
        numbers.as_str(),
        include_str!("../shaders/math/two_floats.wgsl"),
        include_str!("../shaders/peel/field.wgsl"),
    ];
    match module {
        PeelModule::Bins => parts.extend([
            include_str!("../shaders/peel/image.wgsl"),
            include_str!("../shaders/peel/bins.wgsl"),
        ]),
        PeelModule::Scan => parts.push(include_str!("../shaders/peel/scan.wgsl")),
        PeelModule::Sort => parts.push(include_str!("../shaders/peel/sort.wgsl")),
        PeelModule::Tiled => parts.extend([
            kernel_source(kind.kernel),
            include_str!("../shaders/intersect/hit.wgsl"),
            include_str!("../shaders/peel/tiled.wgsl"),
            include_str!("../shaders/intersect/solve.wgsl"),
            include_str!("../shaders/intersect/stretches.wgsl"),
        ]),
        PeelModule::Sprites => parts.extend([
            include_str!("../shaders/peel/image.wgsl"),
            include_str!("../shaders/peel/state.wgsl"),
            include_str!("../shaders/peel/sprites.wgsl"),
        ]),
        PeelModule::Slots => parts.extend([
            kernel_source(kind.kernel),
            include_str!("../shaders/peel/state.wgsl"),
            include_str!("../shaders/intersect/hit.wgsl"),
            include_str!("../shaders/peel/bezier.wgsl"),
            match kind.clipping {
                Clipping::Own => include_str!("../shaders/peel/own_clipping.wgsl"),
                Clipping::Kanamori => include_str!("../shaders/peel/kanamori_clipping.wgsl"),
            },
            include_str!("../shaders/peel/slots.wgsl"),
        ]),
    }
    parts.join("\n")
}

fn numbers(kind: &PeelKind) -> String {
    let coefficients = kind.kernel.coefficients_in_g();
    let power = coefficients.len() - 1;
    let list: Vec<String> = coefficients.iter().map(|c| format!("{c:?}")).collect();
    format!(
        "const WORKGROUP: u32 = {WORKGROUP}u;\nconst TILE: u32 = {}u;\nconst POWER: u32 = {power}u;\n\
         // The kernel as a polynomial in g, lowest power first.\n\
         var<private> IN_G: array<f32, {}> = array<f32, {}>({});\n",
        tile(kind.variant),
        power + 1,
        power + 1,
        list.join(", "),
    )
}
