//! An eight-wide bounding volume hierarchy over the particles' supports: quick to build and to refit,
//! small, and no worse for large anisotropic particles.
//!
//! Each leaf copies up to sixteen blobs, relative to its own centre. Boxes of neighbours overlap, so a
//! leaf alone says little about the field: the solver gathers until no box begins before the stretch
//! that it looks at ([`frontier`]).

mod curve;
mod fit;
pub mod frontier;
pub mod layout;
mod motion;
mod sah;
mod topology;

use crate::accel::cells::layout::Block;
use crate::field::{BlobField, MotionBoxes};
use crate::math::aabb::Aabb;
use crate::primitive::{Ball, Ellipsoid, Primitive, Shapes};
use crate::scene::{Builder, MotionBounds};
pub use curve::size_class;
use fit::inner_level;
pub use fit::{FINEST_PART, Measures};
use glam::Vec3;
use layout::{Faces, Node};
pub use motion::{Elapsed, MovingFaces};
use motion::{Way, bulge, curve_pad};
use rayon::prelude::*;
use topology::Topology;

/// The structure of engine `particles`.
#[derive(Debug, Default, PartialEq)]
pub struct ParticleTree {
    /// Eight-wide nodes, root first, children behind their parents.
    pub nodes: Vec<Node>,
    /// Boxes of the nodes' children when the shutter closes, where blobs move: those of `nodes` are from
    /// when it opens. A box in between, see [`MovingFaces`], holds what it has to at the time in between.
    closing: Vec<Faces>,
    /// How far they bulge out in between, where they move along curves.
    bulges: Vec<Faces>,
    /// Whether curves were asked for.
    motion_bounds: MotionBounds,
    /// When the shutter opens and closes, in seconds relative to the frame.
    pub shutter_secs: [f64; 2],
    /// Leaves, each a header and one chunk of blobs; see [`layout`].
    pub blocks: Vec<Block>,
    /// Columns that leaves have for their blobs' motion, see [`layout::motion_columns`].
    pub motion_columns: usize,
    /// Local box around all supports.
    pub bounds: Option<Aabb>,
    /// Number of leaves.
    pub leaves: usize,
    /// Mean radius of the supports: the length that stretches are measured by.
    pub typical_support: f32,
    /// Where g reaches this, any single blob reaches the threshold: the inner spheres
    /// of Ray Tracing Gems II §35.4, by the smallest weight. At least 1 where not all blobs have one, or weights are negative.
    pub inner_level: f32,
    /// Boxes that a ray that meets `bounds` meets, by the surface area heuristic: now, and when the
    /// tree was built.
    cost: f32,
    cost_when_built: f32,
}

/// A time within the shutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafTimes {
    /// Since the middle of the shutter, where the blobs' places are taken.
    pub since_middle_secs: f32,
    /// Since the frame's time, where their shapes are.
    pub since_frame_secs: f32,
}

/// Which of its boxes a leaf is asked for.
#[derive(Debug, Clone, Copy)]
enum Time {
    Open,
    Control,
    Close,
}

/// A refitted tree is worn where rays meet this many times the boxes of the one that was built.
pub const WORN: f32 = 1.25;

impl ParticleTree {
    /// Builds the tree of `field`. The same field gives the same tree for any number of threads.
    pub fn build(field: &BlobField, builder: Builder) -> Self {
        Self::build_with(field, builder, MotionBounds::default())
    }

    /// Builds the tree of `field` with boxes that follow motion in a stated way.
    pub fn build_with(field: &BlobField, builder: Builder, motion_bounds: MotionBounds) -> Self {
        let count = field.len() as u32;
        let (topology, order) = match builder {
            Builder::Sah => {
                let mut items: Vec<sah::Item> = (0..count)
                    .into_par_iter()
                    .map(|index| {
                        let i = index as usize;
                        let half = Vec3::from_array(field.shapes.half_extents(i));
                        sah::Item::new(index, field.center(i), half)
                    })
                    .collect();
                let topology = Topology::build(&sah::Sah, &mut items);
                (topology, items.iter().map(sah::Item::index).collect())
            }
            Builder::Morton | Builder::Device => {
                let mut items = curve::along_curve(field);
                let topology = Topology::build(&curve::Curve::new(field), &mut items);
                (topology, items.iter().map(curve::Item::index).collect())
            }
        };
        match field.shapes {
            Shapes::Balls(_) => Self::from_topology::<Ball>(field, topology, order, motion_bounds),
            Shapes::Ellipsoids(_) => {
                Self::from_topology::<Ellipsoid>(field, topology, order, motion_bounds)
            }
        }
    }

    fn from_topology<P: Primitive>(
        field: &BlobField,
        topology: Topology,
        order: Vec<u32>,
        motion_bounds: MotionBounds,
    ) -> Self {
        let Topology { nodes, leaves } = topology;
        let motion_columns = layout::motion_columns(field);
        let mut tree = Self {
            nodes,
            blocks: fit::leaves_of::<P>(&leaves, &order, motion_columns),
            leaves: leaves.len(),
            motion_columns,
            motion_bounds,
            ..Self::default()
        };
        tree.fit::<P>(field);
        tree.cost_when_built = tree.cost;
        tree
    }

    /// Whether refitting has made the boxes so much larger that a new tree is worth its build.
    pub fn is_worn(&self) -> bool {
        self.cost > WORN * self.cost_when_built
    }

    /// Fits the tree to blobs that have moved, changed their shape or their weight: the same blobs in
    /// the same leaves. Right for any motion, good for small ones ([`ParticleTree::is_worn`]).
    ///
    /// # Panics
    /// If `field` does not have the blobs that the tree was built of, or moves or turns and the other did
    /// not.
    pub fn refit(&mut self, field: &BlobField) {
        match field.shapes {
            Shapes::Balls(_) => self.fit::<Ball>(field),
            Shapes::Ellipsoids(_) => self.fit::<Ellipsoid>(field),
        }
    }

    /// Fills the leaves and all boxes from `field`.
    fn fit<P: Primitive>(&mut self, field: &BlobField) {
        let measures = Measures::of(field);
        self.typical_support = measures.typical_support;
        self.inner_level = inner_level(field);
        self.bounds = None;
        if self.leaves == 0 {
            return;
        }
        let fitted: Vec<MotionBoxes> = self
            .blocks
            .par_chunks_mut(layout::leaf_blocks::<P>(self.motion_columns))
            .map(|leaf| fit::fit_leaf::<P>(field, &measures, leaf))
            .collect();
        let (way, pad) = match &field.motion {
            None => (Way::Straight, 0.0),
            Some(motion) => {
                self.shutter_secs = motion.shutter;
                match Way::of(self.motion_bounds, &fitted) {
                    Way::Straight => (Way::Straight, 0.0),
                    Way::Curved => (Way::Curved, curve_pad(&fitted)),
                }
            }
        };
        let at = |time: Time| {
            fit::fit_nodes(&self.nodes, |leaf| {
                let MotionBoxes { ends, curve } = &fitted[leaf];
                match (way, time) {
                    (Way::Straight, Time::Open) => ends[0],
                    (Way::Straight, Time::Close) => ends[1],
                    (Way::Curved, Time::Open) => curve[0].padded(pad),
                    (Way::Curved, Time::Close) => curve[2].padded(pad),
                    (_, Time::Control) => curve[1].padded(pad),
                }
            })
        };
        let open = at(Time::Open);
        self.cost = open.cost;
        self.closing.clear();
        self.bulges.clear();
        if field.motion.is_some() {
            self.closing = at(Time::Close).faces;
        }
        if way == Way::Curved {
            let control = at(Time::Control).faces;
            let faces = open.faces.par_iter().zip(&control).zip(&self.closing);
            self.bulges = faces
                .map(|((open, control), close)| bulge([open, control, close]))
                .collect();
        }
        for (node, faces) in self.nodes.iter_mut().zip(open.faces) {
            node.bounds = faces;
        }
        let always = fitted.iter().fold(Aabb::EMPTY, |all, boxes| {
            all.union(boxes.ends[0]).union(boxes.ends[1])
        });
        self.bounds = Some(always.padded(pad));
    }

    /// Whether its blobs move while the shutter is open.
    pub fn moves(&self) -> bool {
        !self.closing.is_empty()
    }

    /// Whether the boxes of its nodes move along curves.
    pub fn moves_along_curves(&self) -> bool {
        !self.bulges.is_empty()
    }

    /// The boxes of node `index` and how they move.
    #[inline(always)]
    pub fn faces(&self, index: usize) -> MovingFaces<'_> {
        MovingFaces {
            open: &self.nodes[index].bounds,
            close: self.closing.get(index),
            bulge: self.bulges.get(index),
        }
    }

    /// Whether the tree can be [refitted](Self::refit) to `field`.
    pub fn suits(&self, field: &BlobField) -> bool {
        self.motion_columns == layout::motion_columns(field)
    }

    /// A time as the leaves' blobs count it.
    pub fn times(&self, time_secs: f64) -> LeafTimes {
        let [open, close] = self.shutter_secs;
        let clamped = time_secs.clamp(open, close);
        LeafTimes {
            since_middle_secs: (clamped - 0.5 * (open + close)) as f32,
            since_frame_secs: clamped as f32,
        }
    }

    /// Memory held.
    pub fn structure_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Node>()
            + size_of_val(&*self.closing)
            + size_of_val(&*self.bulges)
            + self.blocks.len() * size_of::<Block>()
    }
}

#[cfg(test)]
mod tests;
