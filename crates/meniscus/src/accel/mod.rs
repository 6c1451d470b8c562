//! Acceleration structures: boxes in, candidates out.

pub mod cells;
pub mod metaballs;
pub mod particles;
pub mod supports;
pub mod triangles;

use crate::field::Motion;
use crate::scene::{Builder, EngineSettings};
use cells::TimedCells;
use metaballs::MetaballTree;

/// Which structure and solver answers rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Engine {
    /// Disjoint boxes that contain the surface; see [`cells`].
    #[default]
    Cells,
    /// A hierarchy over the particles, searched behind its frontier; see [`particles`].
    Particles,
    /// Interval refinement over the particles; see [`particles`].
    Interval,
    /// Metaballs in a tree of overlapping boxes (Gourmel et al. 2010, §4); see [`metaballs`].
    MetaballBvh,
    /// Metaballs in a tree of disjoint boxes (Gourmel et al. 2010, §5); see [`metaballs`].
    FittedBvh,
    /// All supports along the ray, sorted, one Bézier polynomial per interval; see [`supports`].
    Sweep,
}

impl Engine {
    /// Every engine.
    pub const ALL: [Self; 6] = [
        Self::Cells,
        Self::Particles,
        Self::Interval,
        Self::MetaballBvh,
        Self::FittedBvh,
        Self::Sweep,
    ];

    /// The name in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cells => "cells",
            Self::Particles => "particles",
            Self::Interval => "interval",
            Self::MetaballBvh => "metaball-bvh",
            Self::FittedBvh => "fitted-bvh",
            Self::Sweep => "sweep",
        }
    }

    /// Whether it traces blobs that move while the shutter is open.
    pub fn traces_motion(self) -> bool {
        match self {
            Self::Cells | Self::Particles | Self::Interval | Self::Sweep => true,
            Self::MetaballBvh | Self::FittedBvh => false,
        }
    }

    /// The engine of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|engine| engine.name() == name)
    }
}

/// The structure of one blob field for one engine.
#[derive(Debug)]
pub enum Accel {
    /// For [`Engine::Cells`].
    Cells(TimedCells),
    /// For [`Engine::Particles`].
    Particles(particles::ParticleTree),
    /// For [`Engine::Interval`].
    Interval(particles::ParticleTree),
    /// For [`Engine::MetaballBvh`] and [`Engine::FittedBvh`].
    Metaballs(metaballs::MetaballTree),
    /// For [`Engine::Sweep`].
    Sweep(supports::SupportTree),
    /// For [`Engine::Particles`] where a device builds the tree ([`Builder::Device`]): rays that are asked
    /// here all the same are answered as by [`Engine::Sweep`].
    Elsewhere,
}

impl Accel {
    /// Builds the structure. Blobs that move are traced by engine `particles` where the engine asked for
    /// knows still ones only, or is `cells` and they move too much against each other.
    pub fn build(
        engine: Engine,
        field: &crate::field::BlobField,
        settings: &EngineSettings,
    ) -> Self {
        let particle_tree = || {
            let EngineSettings {
                builder,
                motion_bounds,
                ..
            } = *settings;
            particles::ParticleTree::build_with(field, builder, motion_bounds)
        };
        let metaballs = |boxes| MetaballTree::build(field, boxes, settings);
        let moves = field.motion.is_some();
        let slabs = match engine {
            Engine::Cells => TimedCells::slabs_for(field, settings.time_slabs),
            _ => None,
        };
        let is_lost = engine == Engine::Cells && slabs.is_none();
        let engine = if is_lost || (moves && !engine.traces_motion()) {
            Engine::Particles
        } else {
            engine
        };
        // No device knows shapes that turn.
        let turns = field.motion.as_ref().is_some_and(Motion::turns);
        let is_elsewhere = settings.builder == Builder::Device && !turns;
        match engine {
            Engine::Cells => Self::Cells(TimedCells::build(
                field,
                slabs.unwrap_or(1),
                settings.leaves,
            )),
            Engine::Particles if is_elsewhere => Self::Elsewhere,
            Engine::Particles => Self::Particles(particle_tree()),
            Engine::Interval => Self::Interval(particle_tree()),
            Engine::MetaballBvh => Self::Metaballs(metaballs(metaballs::Boxes::Overlapping)),
            Engine::FittedBvh => Self::Metaballs(metaballs(metaballs::Boxes::Disjoint)),
            Engine::Sweep => Self::Sweep(supports::SupportTree::build(field)),
        }
    }

    /// The engine that this structure serves.
    pub fn engine(&self) -> Engine {
        match self {
            Self::Cells(_) => Engine::Cells,
            Self::Particles(_) | Self::Elsewhere => Engine::Particles,
            Self::Interval(_) => Engine::Interval,
            Self::Metaballs(tree) => match tree.boxes {
                metaballs::Boxes::Overlapping => Engine::MetaballBvh,
                metaballs::Boxes::Disjoint => Engine::FittedBvh,
            },
            Self::Sweep(_) => Engine::Sweep,
        }
    }

    /// Memory that the structure holds, without the field.
    pub fn structure_bytes(&self) -> usize {
        match self {
            Self::Cells(cells) => cells.structure_bytes(),
            Self::Particles(tree) | Self::Interval(tree) => tree.structure_bytes(),
            Self::Metaballs(tree) => tree.structure_bytes(),
            Self::Sweep(tree) => tree.structure_bytes(),
            Self::Elsewhere => 0,
        }
    }
}
