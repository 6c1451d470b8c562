//! Named scenes: blob fields of every kind that engines must get right.

mod build;
mod evil;
mod points;

pub use build::{Recipe, Shape, Weighting};
pub use evil::evil;

use meniscus::field::BlobField;
use meniscus::kernel::Kernel;

/// A field with a name for messages and tables.
#[derive(Debug, Clone)]
pub struct Scene {
    /// What it is.
    pub name: String,
    /// The field.
    pub field: BlobField,
}

impl Scene {
    /// `field` under `name` and its kernel's name.
    fn new(name: &str, recipe: &Recipe) -> Self {
        Self {
            name: format!("{name}/{}", recipe.kernel.name()),
            field: recipe.field(),
        }
    }
}

/// What [`scene`] builds.
pub const KINDS: [&str; 8] = [
    "scattered",
    "pool",
    "molecule",
    "mixed",
    "ellipsoids",
    "tangent",
    "negative",
    "weighed",
];

/// The scene of one of [`KINDS`] with about `count` blobs.
///
/// # Panics
/// If there is no such kind.
pub fn scene(kind: &str, kernel: Kernel, count: usize) -> Scene {
    let recipe = match kind {
        "scattered" => points::scattered(count),
        "pool" => points::pool(count),
        "molecule" => points::molecule(count, kernel),
        "mixed" => points::mixed_radii(count),
        "ellipsoids" => points::ellipsoids(count),
        "tangent" => points::tangent_ellipsoids(count),
        "negative" => points::negative(count),
        "weighed" => points::weighed(count),
        _ => panic!("no scene is called {kind}"),
    };
    Scene::new(kind, &Recipe { kernel, ..recipe })
}

/// A few dozen blobs each: for checks that look at every blob at every step.
pub fn small() -> Vec<Scene> {
    KINDS
        .iter()
        .enumerate()
        .map(|(i, kind)| scene(kind, Kernel::ALL[i % Kernel::ALL.len()], 30))
        .collect()
}

/// Every kind with every kernel, a few hundred blobs each.
pub fn suite() -> Vec<Scene> {
    KINDS
        .iter()
        .flat_map(|kind| Kernel::ALL.map(|kernel| scene(kind, kernel, 400)))
        .collect()
}
