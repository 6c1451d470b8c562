//! The suite that every engine passes at every SIMD level: [`engine_suite!`](crate::engine_suite)
//! expands to one test per function below.

mod checks;

pub use checks::{
    all_crossings, any_hit, bundles, evil_rays, evil_sets, grazing_rays, inside_rays,
    ordinary_rays, same_for_any_number_of_threads, shadow_rays,
};

use crate::corpus::Scene;
use crate::examine::{Question, Tracer, examine};
use crate::oracle::Oracle;
use crate::rays::{self, SurfacePoint};
use meniscus::math::ray::Ray;
use meniscus::math::simd::{Level, SimdLevel, level_name};

/// Expands to a module of tests: the whole suite for one engine.
///
/// ```ignore
/// meniscus_testing::engine_suite!(sweep, meniscus::accel::Engine::Sweep);
/// ```
#[macro_export]
macro_rules! engine_suite {
    ($name:ident, $engine:expr) => {
        $crate::engine_suite!($name, $engine; ordinary_rays shadow_rays grazing_rays inside_rays
            bundles evil_rays evil_sets any_hit all_crossings same_for_any_number_of_threads);
    };
    ($name:ident, $engine:expr; $($check:ident)*) => {
        mod $name {
            $(#[test]
            fn $check() {
                $crate::suite::$check($engine);
            })*
        }
    };
}

/// The SIMD levels that this machine has, each once.
pub fn levels() -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    for (_, level) in SimdLevel::ALL {
        if let Some(level) = level.resolve()
            && !levels
                .iter()
                .any(|&known| level_name(known) == level_name(level))
        {
            levels.push(level);
        }
    }
    levels
}

/// A scene with its oracle's points on the surface.
pub struct Stage<'a> {
    /// Its name.
    pub name: &'a str,
    /// The oracle of its field.
    pub oracle: &'a Oracle<'a>,
    /// Points on the surface; empty where there is no surface.
    pub points: Vec<SurfacePoint>,
}

impl<'a> Stage<'a> {
    /// A stage with up to `count` surface points.
    pub fn new(scene: &'a Scene, oracle: &'a Oracle<'a>, count: usize) -> Self {
        Self {
            name: &scene.name,
            oracle,
            points: rays::surface_points(oracle, count, 21),
        }
    }
}

/// Complaints about an engine: empty when it is right.
pub fn complaints(
    tracer: &impl Tracer,
    stage: &Stage,
    rays: &[Ray],
    question: Question,
) -> Option<String> {
    let tally = examine(tracer, stage.oracle, rays, question);
    (tally.real_errors() > 0).then(|| format!("{} {question:?}: {tally}", stage.name))
}

#[cfg(test)]
mod tests;
