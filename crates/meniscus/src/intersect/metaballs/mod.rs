//! Engines `metaball-bvh` and `fitted-bvh` (Gourmel et al. 2010): in each leaf that the ray pierces, the
//! field at the centres' projections gives a bracket and the secant method the crossing.
//!
//! That the field is beyond T at some projection wherever a ray crosses the surface is an assumption: it
//! fails for some rays that nearly touch. What is found is a crossing, what is not found may be one.
//!
//! Beyond the paper: points lie within the leaf's stretch, outside of which its metaballs do not give the
//! field; rays from inside look at the ends of supports instead; a ray that enters a leaf on the other
//! side crosses at the seam; a ray's own start is looked at in float64, as in engine `cells`.

mod gather;
mod solve;
mod traverse;

use super::cells::gradient;
use super::solve::{LocalRay, local_ray, specialised};
use super::{BlobHit, Scratch};
use crate::accel::cells::layout::{Block, Columns};
use crate::accel::metaballs::{Boxes, LeafHeader, MetaballTree};
use crate::frame::Blobs;
use crate::kernel::KernelShape;
use crate::math::ray::{Ray, Side};
use crate::primitive::Primitive;
use fearless_simd::Simd;
use gather::Active;
use glam::{DVec3, Vec3};
use solve::Search;
use traverse::{Stack, visit_leaves};

/// Accuracy of t that the secant method aims at, in spacings.
const T_TOLERANCE_SPACINGS: f32 = 2e-5;

/// Nearer to a ray's own start, in spacings, a crossing has to be seen in float64.
const NEAR_START_SPACINGS: f32 = 1e-2;

/// First step, in spacings, of a ray that gets away from its own start.
const FIRST_STEP_SPACINGS: f32 = 1e-3;

/// A leaf entered this close to the start, in parts of the structure's size, may hold it.
const START_MARGIN: f32 = 4e-6;

/// Buffers of one thread.
#[derive(Debug, Default)]
pub struct MetaballScratch {
    stack: Stack,
    active: Active,
}

/// What is asked of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Question {
    /// Where the first crossing is.
    First,
    /// Whether there is one.
    Any,
}

/// A crossing on the clipped ray, and the leaf that knows it.
#[derive(Debug, Clone, Copy)]
struct Found {
    t: f32,
    block: u32,
}

/// First crossing of a traceable object-space ray.
pub fn closest(
    blobs: &Blobs,
    tree: &MetaballTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    scratch.counters.rays += 1;
    let local = local_ray(blobs, tree.bounds, ray)?;
    let Found { t, block } = find(blobs, tree, &local, Question::First, scratch)?;
    let t = local.parameter(ray, f64::from(t));
    let (outward, strongest) = gradient_at(blobs, tree, block, ray.at(t) - blobs.field.origin);
    Some(BlobHit {
        t,
        outward,
        strongest,
        entering: !local.inside,
    })
}

/// Whether a traceable object-space ray has a crossing.
pub fn occluded(blobs: &Blobs, tree: &MetaballTree, ray: &Ray, scratch: &mut Scratch) -> bool {
    scratch.counters.rays += 1;
    local_ray(blobs, tree.bounds, ray)
        .is_some_and(|local| find(blobs, tree, &local, Question::Any, scratch).is_some())
}

fn find(
    blobs: &Blobs,
    tree: &MetaballTree,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    scratch.metaballs.active.reserve(tree.largest_leaf);
    specialised!(blobs, simd, K, P => {
        find_in_tree::<_, K, P>(simd, blobs, tree, ray, question, scratch)
    })
}

#[inline(always)]
fn find_in_tree<S: Simd, K: KernelShape, P: Primitive>(
    simd: S,
    blobs: &Blobs,
    tree: &MetaballTree,
    ray: &LocalRay,
    question: Question,
    scratch: &mut Scratch,
) -> Option<Found> {
    let slab_ray = ray.slab_ray();
    let MetaballScratch { stack, active } = &mut scratch.metaballs;
    let counters = &mut scratch.counters;
    let start_margin = tree
        .bounds
        .map_or(0.0, |bounds| START_MARGIN * bounds.size().max_element());
    let mut place = LeafSearch {
        blobs,
        ray,
        direction: ray.direction.as_vec3(),
        start_margin,
        first_step: (FIRST_STEP_SPACINGS * blobs.field.spacing).max(start_margin),
        search: Search {
            threshold: blobs.field.threshold,
            inside: ray.inside,
            tolerance: T_TOLERANCE_SPACINGS * blobs.field.spacing,
        },
        disjoint: tree.boxes == Boxes::Disjoint,
    };
    if question == Question::Any {
        place.search.tolerance = f32::INFINITY;
    }
    let mut found: Option<Found> = None;
    let mut limit = ray.length;
    let nodes = simd.vectorize(
        #[inline(always)]
        || {
            visit_leaves(
                tree,
                &slab_ray,
                stack,
                #[inline(always)]
                |block, near, far| {
                    let header = LeafHeader::from_block(&tree.blocks[block as usize]);
                    counters.leaves += 1;
                    counters.blob_evaluations += header.count as u64;
                    let chunks = leaf_chunks::<P>(&tree.blocks, block, &header);
                    let crossing =
                        place.crossing::<S, K, P>(simd, &header, chunks, (near, far), active);
                    if let Some(t) = crossing
                        && t <= limit
                    {
                        limit = t;
                        found = Some(Found { t, block });
                        if place.disjoint || question == Question::Any {
                            return -1.0;
                        }
                    }
                    limit
                },
            )
        },
    );
    counters.nodes += nodes;
    found
}

/// What all leaves of a ray have in common.
struct LeafSearch<'a> {
    blobs: &'a Blobs,
    ray: &'a LocalRay,
    direction: Vec3,
    start_margin: f32,
    /// Length of the first step away from the ray's own start.
    first_step: f32,
    search: Search,
    disjoint: bool,
}

impl LeafSearch<'_> {
    /// The first crossing in a leaf.
    #[inline(always)]
    fn crossing<S: Simd, K: KernelShape, P: Primitive>(
        &self,
        simd: S,
        header: &LeafHeader,
        chunks: &[Block],
        (near, far): (f32, f32),
        active: &mut Active,
    ) -> Option<f32> {
        let search = &self.search;
        let center = Vec3::from_array(header.center).as_dvec3();
        let start = self.ray.origin + self.ray.direction * f64::from(near) - center;
        let length = far - near;
        let upper = active.gather::<S, K, P>(
            simd,
            chunks,
            header.own_chunks,
            start.as_vec3().to_array(),
            self.direction.to_array(),
            length,
        );
        let holds_start = self.ray.starts_at_t_min && near <= self.start_margin;
        if search.inside {
            active.support_ends(simd, length, self.disjoint);
        } else if upper < search.threshold {
            return None;
        } else {
            active.project_centers(simd, length);
        }
        search.look::<S, K>(simd, active, !holds_start);
        let mut from = 0.0;
        if holds_start
            && !self.ray.side_is_proven
            && search
                .nearest(simd, active, 0.0, true)
                .is_some_and(|s| s == 0.0)
        {
            // By rounding or by mistake: where the field is on the stated side again the search begins.
            from = search.step_off::<S, K>(simd, active, 0.0, self.first_step, length)?;
        }
        loop {
            let beyond = search.nearest(simd, active, from, true)?;
            let crossing = search.crossing::<S, K>(simd, active, from, beyond);
            if !holds_start || self.is_sure(near + crossing) {
                return Some(near + crossing);
            }
            from = search.step_off::<S, K>(simd, active, crossing, self.first_step, length)?;
        }
    }

    /// Whether a crossing in the leaf that holds the ray's start is one: far from it, or seen in
    /// float64.
    #[cold]
    #[inline(never)]
    fn is_sure(&self, t: f32) -> bool {
        let spacing = self.blobs.field.spacing;
        if t > (NEAR_START_SPACINGS * spacing).max(8.0 * self.start_margin) {
            return true;
        }
        let (t, tolerance) = (f64::from(t), f64::from(T_TOLERANCE_SPACINGS * spacing));
        let beyond = |along: f64| {
            let point = self.ray.origin + self.ray.direction * along;
            (self.blobs.field.side(point) == Side::Inside) != self.ray.inside
        };
        [0.0, 0.5 * t, t - tolerance]
            .into_iter()
            .any(|before| before >= 0.0 && !beyond(before))
            && [1.0, 4.0, 16.0]
                .into_iter()
                .any(|steps| beyond(t + steps * tolerance))
    }
}

/// The blobs of the leaf at `block`, chunk after chunk.
#[inline(always)]
fn leaf_chunks<'a, P: Primitive>(
    blocks: &'a [Block],
    block: u32,
    header: &LeafHeader,
) -> &'a [Block] {
    let first = block as usize + 1;
    &blocks[first..first + header.chunks * Columns::ALL.blocks_per_chunk::<P>()]
}

/// −∇F and the strongest blob at a local point of the leaf at `block`.
fn gradient_at(blobs: &Blobs, tree: &MetaballTree, block: u32, at: DVec3) -> (DVec3, u32) {
    let header = LeafHeader::from_block(&tree.blocks[block as usize]);
    let center = Vec3::from_array(header.center).as_dvec3();
    let point = (at - center).as_vec3().to_array();
    specialised!(blobs, simd, K, P => simd.vectorize(
        #[inline(always)]
        || gradient::outward_and_strongest::<_, K, P>(
            simd,
            (&Columns::ALL, 0.0),
            leaf_chunks::<P>(&tree.blocks, block, &header),
            point,
        )
    ))
}
