//! Particle sets made by formula: the scenes of the papers, and ballistic water.
//!
//! Every generator is a pure function of (count, seed, frame). Its random numbers come from a
//! portable generator, so a scene is the same on every machine up to the last bits of sin and cos.
//! To add one: one file beside these, one line in [`Generator`] and in its tables.

mod ballistic;
mod fountain;
mod molecule;
mod pool;
mod random;
mod scattered;
mod splash;
mod staging;
mod tornado;

use super::Scene;
use crate::particles::Particles;
use std::path::PathBuf;

/// Frames a second of the animated generators.
pub const FRAMES_PER_SECOND: f64 = 25.0;

/// The most particles that a generator makes.
pub const MAX_COUNT: usize = 100_000_000;

/// A generator by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Generator {
    /// Uniformly random in the unit cube (Gourmel et al. 2010, "Scattered metaballs").
    Scattered,
    /// A wavy pool of jittered lattice points (Gourmel et al. 2010, "Pool").
    Pool,
    /// A bent funnel of helical arms (Gourmel et al. 2010, "Tornado").
    Tornado,
    /// A protein-like bundle of helices in ångström (Gourmel et al. 2010, "Molecule").
    Molecule,
    /// Jets of water on parabolas (Kanamori et al. 2008, figure 12).
    Fountain,
    /// A crown that a drop throws up from a puddle.
    Splash,
}

/// A generated particle set and how to look at it.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// The particles; every position is exactly an f32, so that a file of floats holds the same set.
    pub particles: Particles,
    /// Surface settings, camera, light and material that suit it, the same for all frames of a
    /// sequence. The file of its one surface is empty; see [`Generated::scene_of`].
    pub scene: Scene,
}

impl Generated {
    /// The scene of the set once it is stored in `file` (a path as the scene file shall state it).
    pub fn scene_of(&self, file: impl Into<PathBuf>) -> Scene {
        let mut scene = self.scene.clone();
        if let Some(surface) = scene.surfaces.first_mut() {
            surface.file = file.into();
        }
        scene
    }
}

/// What a generator refuses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GenerateError {
    /// The count is 0 or beyond [`MAX_COUNT`].
    #[error("cannot generate {count} particles: the count must be between 1 and {MAX_COUNT}")]
    Count {
        /// The count asked for.
        count: usize,
    },
}

impl Generator {
    /// Every generator.
    pub const ALL: [Self; 6] = [
        Self::Scattered,
        Self::Pool,
        Self::Tornado,
        Self::Molecule,
        Self::Fountain,
        Self::Splash,
    ];

    /// The name in commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scattered => "scattered",
            Self::Pool => "pool",
            Self::Tornado => "tornado",
            Self::Molecule => "molecule",
            Self::Fountain => "fountain",
            Self::Splash => "splash",
        }
    }

    /// The generator of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|generator| generator.name() == name)
    }

    /// How many particles it makes unless told otherwise.
    pub fn default_count(self) -> usize {
        match self {
            Self::Scattered => 30_000,
            Self::Pool => 10_000,
            Self::Tornado => 4_000,
            Self::Molecule => 5_440,
            Self::Fountain => 100_000,
            Self::Splash => 30_000,
        }
    }

    /// Whether its particles move: they then have `velocity`, `acceleration` and `id`.
    pub fn is_animated(self) -> bool {
        matches!(self, Self::Fountain | Self::Splash)
    }

    /// Makes exactly `count` particles. `frame` counts from 0 at [`FRAMES_PER_SECOND`]; `None` is the
    /// moment that shows the scene best. Sets that do not move are the same in every frame.
    ///
    /// # Errors
    /// If `count` is 0 or more than [`MAX_COUNT`].
    pub fn generate(
        self,
        count: usize,
        seed: u64,
        frame: Option<u32>,
    ) -> Result<Generated, GenerateError> {
        if count == 0 || count > MAX_COUNT {
            return Err(GenerateError::Count { count });
        }
        let time_secs = frame.map(|frame| f64::from(frame) / FRAMES_PER_SECOND);
        let mut generated = match self {
            Self::Scattered => scattered::generate(count, seed),
            Self::Pool => pool::generate(count, seed),
            Self::Tornado => tornado::generate(count, seed),
            Self::Molecule => molecule::generate(count, seed),
            Self::Fountain => fountain::generate(count, seed, time_secs),
            Self::Splash => splash::generate(count, seed, time_secs),
        };
        for position in &mut generated.particles.positions {
            *position = position.as_vec3().as_dvec3();
        }
        Ok(generated)
    }
}

#[cfg(test)]
mod tests;
