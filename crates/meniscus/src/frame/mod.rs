//! A scene at one shutter: immutable flat arrays that every backend reads.
//!
//! A [`Frame`] is a list of instances of surfaces. Every kind of [`Geometry`] answers the same
//! questions (closest hit, any hit, crossings, side, bounds) in `intersect/`.

mod bounds;
mod build;
mod colors;
pub mod environment;
pub mod looks;
mod path;
mod solids;
mod update;
mod way;

pub use build::{FrameError, FrameSettings};
pub use environment::{Environment, EnvironmentError};
pub use looks::{Absorption, BaseColor, Coloring, GroundLook, Light, Material, Scaling};
pub use path::{InstancePath, Placement};
pub use solids::{MeshSurface, Plane, Sphere};
pub use update::Update;
pub use way::InstancePiece;

use crate::accel::supports::SupportTree;
use crate::accel::{Accel, Engine};
use crate::field::BlobField;
use crate::math::simd::Level;
use crate::scene::{Background, EngineSettings, PlacementKey};
use glam::{DAffine3, DVec3};
use std::sync::{Arc, OnceLock};

/// A blob field with the structure that traces it.
#[derive(Debug)]
pub struct Blobs {
    /// The field.
    pub field: BlobField,
    /// Its acceleration structure.
    pub accel: Accel,
    /// Switches of the engine.
    pub settings: EngineSettings,
    /// The SIMD level that rays run on.
    pub level: Level,
    /// For rays that need float64 whatever the engine; built when the first one comes.
    exact: OnceLock<SupportTree>,
}

impl Blobs {
    /// Builds the structure of `field` for `engine` with its default switches.
    pub fn build(field: BlobField, engine: Engine, level: Level) -> Self {
        Self::build_with(field, engine, EngineSettings::default(), level)
    }

    /// Builds the structure of `field` for `engine`.
    pub fn build_with(
        field: BlobField,
        engine: Engine,
        settings: EngineSettings,
        level: Level,
    ) -> Self {
        // Not left to the first ray: built by several threads, it may not be waited for by one of them.
        field.support_tree();
        let accel = Accel::build(engine, &field, &settings);
        Self {
            field,
            accel,
            settings,
            level,
            exact: OnceLock::new(),
        }
    }

    /// Memory that tracing has taken so far: the structure with what rays have refined, and the trees
    /// over the supports.
    pub fn structure_bytes(&self) -> usize {
        let exact = self.exact.get().map_or(0, SupportTree::structure_bytes);
        let search = match &self.accel {
            // They are refined from it.
            Accel::Cells(_) => self.field.search.bytes(),
            _ => 0,
        };
        self.accel.structure_bytes() + search + exact
    }

    /// Time that threads have spent on refining the structure for rays, summed over them.
    pub fn refinement_secs(&self) -> f64 {
        match &self.accel {
            Accel::Cells(cells) => cells.refinement_secs(),
            Accel::Particles(_)
            | Accel::Interval(_)
            | Accel::Metaballs(_)
            | Accel::Sweep(_)
            | Accel::Elsewhere => 0.0,
        }
    }

    /// The tree over all supports that engine `sweep` walks in float64.
    pub fn exact_tree(&self) -> &SupportTree {
        match &self.accel {
            Accel::Sweep(tree) => tree,
            Accel::Cells(_)
            | Accel::Particles(_)
            | Accel::Interval(_)
            | Accel::Metaballs(_)
            | Accel::Elsewhere => self.exact.get_or_init(|| SupportTree::build(&self.field)),
        }
    }
}

/// What a surface is made of.
#[derive(Debug)]
pub enum Geometry {
    /// The isosurface of a blob field.
    Blobs(Box<Blobs>),
    /// A triangle mesh.
    Mesh(Box<MeshSurface>),
    /// A ball.
    Sphere(Sphere),
    /// A plane.
    Plane(Plane),
}

impl Geometry {
    /// The blob field, where it is one.
    pub fn blobs(&self) -> Option<&Blobs> {
        match self {
            Self::Blobs(blobs) => Some(blobs),
            Self::Mesh(_) | Self::Sphere(_) | Self::Plane(_) => None,
        }
    }
}

/// A surface placed in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct Instance {
    /// Index into [`Frame::geometries`].
    pub geometry: u32,
    /// Object to world, at the frame's time.
    pub world_from_object: DAffine3,
    /// World to object, at the frame's time.
    pub object_from_world: DAffine3,
    /// Index into [`Frame::materials`].
    pub material: u32,
    /// Where it is at other times, if it moves while the shutter is open.
    pub path: Option<Arc<InstancePath>>,
}

impl Instance {
    /// A geometry placed by `world_from_object`, which must be invertible.
    pub fn new(geometry: u32, world_from_object: DAffine3, material: u32) -> Self {
        Self {
            geometry,
            world_from_object,
            object_from_world: world_from_object.inverse(),
            material,
            path: None,
        }
    }

    /// A geometry that moves through sorted keys, for a frame at `frame_secs` seconds of the scene whose
    /// shutter is open from `shutter[0]` to `shutter[1]` relative to it.
    ///
    /// # Panics
    /// If there are no keys.
    pub fn moving(
        geometry: u32,
        keys: &[PlacementKey],
        frame_secs: f64,
        shutter: [f64; 2],
        material: u32,
    ) -> Self {
        let (world_from_object, path) = InstancePath::new(keys, frame_secs, shutter);
        Self {
            path: path.map(Arc::new),
            ..Self::new(geometry, world_from_object, material)
        }
    }
}

/// Everything a backend needs to answer rays at one shutter.
#[derive(Debug)]
pub struct Frame {
    /// Distinct geometries.
    pub geometries: Vec<Geometry>,
    /// Their placements; a hit's `surface` is an index into this list.
    pub instances: Vec<Instance>,
    /// Materials that instances refer to.
    pub materials: Vec<Material>,
    /// Planes in world space that cut everything with an inside open: only what lies below all of
    /// them stays, closed by caps. Planes and open meshes are not solids; planes stay whole.
    pub clips: Vec<Plane>,
    /// Lights.
    pub lights: Vec<Light>,
    /// Unit up direction of the world: of the sky and the ground.
    pub up: DVec3,
    /// The ground, if there is one.
    pub ground: Option<GroundLook>,
    /// What the user wants behind the surfaces; unset, the output's own default.
    pub background: Option<Background>,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            geometries: Vec::new(),
            instances: Vec::new(),
            materials: Vec::new(),
            clips: Vec::new(),
            lights: Vec::new(),
            up: DVec3::Y,
            ground: None,
            background: None,
        }
    }
}

impl Frame {
    /// The blob fields.
    pub fn blobs(&self) -> impl Iterator<Item = &Blobs> {
        self.geometries.iter().filter_map(Geometry::blobs)
    }

    /// Memory that the structures of all surfaces take.
    pub fn structure_bytes(&self) -> usize {
        let bytes = |geometry: &Geometry| match geometry {
            Geometry::Blobs(blobs) => blobs.structure_bytes(),
            Geometry::Mesh(mesh) => mesh.bytes(),
            Geometry::Sphere(_) | Geometry::Plane(_) => 0,
        };
        self.geometries.iter().map(bytes).sum()
    }

    /// Whether anything moves while the shutter is open.
    pub fn moves(&self) -> bool {
        self.instances
            .iter()
            .any(|instance| instance.path.is_some())
            || self.blobs().any(|blobs| blobs.field.motion.is_some())
    }

    /// [`Blobs::refinement_secs`] of all.
    pub fn refinement_secs(&self) -> f64 {
        self.blobs().map(Blobs::refinement_secs).sum()
    }
}

#[cfg(test)]
mod tests;
