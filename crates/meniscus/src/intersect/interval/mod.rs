//! Engine `interval`: interval refinement over the particles that a ray meets, found through a bounding
//! volume hierarchy (Ray Tracing Gems II ch. 35, §35.3–35.4).
//!
//! As in the chapter: inner spheres end the collection for rays from outside, the end of the last
//! support for rays from inside; F is bounded over an interval by the sum of tight bounds of each
//! blob, from its monotone pieces; F′ likewise, from its inflections; an interval is split until it
//! holds no root or F is monotone on it; partial sums end the check early where no weight is negative.
//!
//! Made faster than there: the eight-wide hierarchy and leaves of engine `particles` (boxes around the
//! supports, also those of ellipsoids, in place of spheres); a sorted stack, which the chapter
//! considers, so that the collection ends at the first node beyond its end; refinement in stretches of
//! a support's size, each with the blobs that meet it, and in sixteen parts at once, lanes for parts.
//! Where no single blob reaches the threshold there are no inner spheres, and a ray from outside
//! collects all that it meets.

mod refine;

use super::particles;
use super::{BlobHit, Scratch};
use crate::accel::particles::ParticleTree;
use crate::frame::Blobs;
use crate::math::ray::Ray;
use refine::Refinement;

/// First crossing of a traceable object-space ray.
pub fn closest(
    blobs: &Blobs,
    tree: &ParticleTree,
    ray: &Ray,
    scratch: &mut Scratch,
) -> Option<BlobHit> {
    particles::closest_by::<Refinement>(blobs, tree, ray, scratch)
}

/// Whether a traceable object-space ray has a crossing.
pub fn occluded(blobs: &Blobs, tree: &ParticleTree, ray: &Ray, scratch: &mut Scratch) -> bool {
    particles::occluded_by::<Refinement>(blobs, tree, ray, scratch)
}
