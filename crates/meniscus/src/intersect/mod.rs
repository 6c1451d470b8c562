//! Rays against surfaces: the engines, and what they answer with.

pub mod cells;
pub mod interval;
pub mod metaballs;
pub mod particles;
mod clip;
mod coinciding;
mod mesh;
mod solids;
mod solve;
pub mod surface;
pub mod sweep;
mod tracer;
mod world;

pub use solids::SolidHit;
pub use solve::{ClippedRay, Tolerances};
pub use tracer::{BlobTracer, OnCpu, TraceError};

use crate::accel::Accel;
use crate::frame::Blobs;
use crate::math::ray::{Ray, Side};
use glam::DVec3;

/// Work done by rays, summed over the life of a [`Scratch`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Rays traced.
    pub rays: u64,
    /// Nodes visited.
    pub nodes: u64,
    /// Leaves visited.
    pub leaves: u64,
    /// Blobs tested against a ray segment in leaves.
    pub blob_evaluations: u64,
    /// Engine `sweep`: polynomials searched for a root.
    pub polynomials: u64,
    /// Engine `sweep`: clips and halvings in those searches.
    pub clip_iterations: u64,
    /// Engine `sweep` with a paper's clipping rule: searches that ended at the limit of iterations or
    /// of the stack, so that a root may be lost.
    pub clip_failures: u64,
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nodes += other.nodes;
        self.leaves += other.leaves;
        self.blob_evaluations += other.blob_evaluations;
        self.polynomials += other.polynomials;
        self.clip_iterations += other.clip_iterations;
        self.clip_failures += other.clip_failures;
    }
}

/// Buffers that one thread reuses from ray to ray.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Work counted so far.
    pub counters: Counters,
    /// Of engine `cells`.
    pub cells: cells::CellsScratch,
    /// Of engines `particles` and `interval`.
    pub particles: particles::ParticlesScratch,
    /// Of engines `metaball-bvh` and `fitted-bvh`.
    pub metaballs: metaballs::MetaballScratch,
    /// Of engine `sweep`.
    pub sweep: sweep::SweepScratch,
    /// Nodes of a mesh's hierarchy that are still to be visited.
    nodes: Vec<u32>,
    object_rays: world::ObjectRays,
}

impl Scratch {
    /// Leaves with blobs too small for f32 that single rays have visited so far.
    fn fine_leaves(&self) -> u64 {
        self.cells.fine_leaves + self.particles.fine_leaves
    }
}

/// Where a ray meets a blob surface, in the object's space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlobHit {
    /// Ray parameter, in lengths of the ray's direction.
    pub t: f64,
    /// −∇F, not normalised (object space): points outside.
    pub outward: DVec3,
    /// Index of the blob with the largest |wᵢ kᵢ| at the hit.
    pub strongest: u32,
    /// Whether the ray goes from outside (F < T) to inside here.
    pub entering: bool,
}

/// Where a ray meets a surface of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Ray parameter, in lengths of the ray's direction.
    pub t: f64,
    /// World position.
    pub position: DVec3,
    /// Unit outward normal in world space, −∇F/|∇F|, on a mesh that of the face; never flipped towards
    /// the eye.
    pub normal: DVec3,
    /// Unit normal for shading, on the same side: [`Hit::normal`] but for smooth meshes.
    pub shading_normal: DVec3,
    /// Index into [`Frame::instances`](crate::frame::Frame::instances).
    pub surface: u32,
    /// The strongest particle: index of the blob within its field (`None` on other geometry).
    pub blob: Option<u32>,
    /// Whether the ray enters the surface here.
    pub entering: bool,
}

/// One of all crossings of a ray with a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Ray parameter.
    pub t: f64,
    /// From outside to inside.
    pub entering: bool,
}

/// How far behind a crossing, in spacings, the next search begins: as close as the field allows.
const CROSSING_STEPS: [f64; 3] = [1e-6, 1e-5, 1e-4];

impl Blobs {
    /// First crossing of an object-space ray, with its gradient.
    pub fn closest(&self, ray: &Ray, scratch: &mut Scratch) -> Option<BlobHit> {
        if !ray.is_traceable() {
            return None;
        }
        match &self.accel {
            Accel::Cells(cells) => cells::closest(self, cells, ray, scratch),
            Accel::Particles(tree) => particles::closest(self, tree, ray, scratch),
            Accel::Interval(tree) => interval::closest(self, tree, ray, scratch),
            Accel::Metaballs(tree) => metaballs::closest(self, tree, ray, scratch),
            Accel::Sweep(_) | Accel::Elsewhere => {
                sweep::closest(self, self.exact_tree(), ray, scratch)
            }
        }
    }

    /// Whether an object-space ray crosses the surface at all.
    pub fn occluded(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        if !ray.is_traceable() {
            return false;
        }
        match &self.accel {
            Accel::Cells(cells) => cells::occluded(self, cells, ray, scratch),
            Accel::Particles(tree) => particles::occluded(self, tree, ray, scratch),
            Accel::Interval(tree) => interval::occluded(self, tree, ray, scratch),
            Accel::Metaballs(tree) => metaballs::occluded(self, tree, ray, scratch),
            Accel::Sweep(_) | Accel::Elsewhere => {
                sweep::closest(self, self.exact_tree(), ray, scratch).is_some()
            }
        }
    }

    /// First crossings of object-space rays, one per entry of `hits`. Rays that lie close together and
    /// follow each other are traced together, which is several times faster than one by one.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_many(&self, rays: &[Ray], hits: &mut [Option<BlobHit>], scratch: &mut Scratch) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        match &self.accel {
            Accel::Cells(cells) => cells::answer_many(self, cells, rays, hits, scratch),
            Accel::Particles(_)
            | Accel::Interval(_)
            | Accel::Metaballs(_)
            | Accel::Sweep(_)
            | Accel::Elsewhere => {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.closest(ray, scratch);
                }
            }
        }
    }

    /// Whether object-space rays cross the surface at all, one per entry of `hits`, as
    /// [`Blobs::closest_many`].
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn occluded_many(&self, rays: &[Ray], hits: &mut [bool], scratch: &mut Scratch) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        match &self.accel {
            Accel::Cells(cells) => cells::answer_many(self, cells, rays, hits, scratch),
            Accel::Particles(_)
            | Accel::Interval(_)
            | Accel::Metaballs(_)
            | Accel::Sweep(_)
            | Accel::Elsewhere => {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.occluded(ray, scratch);
                }
            }
        }
    }

    /// Every crossing of object-space rays, in order, appended to the ray's entry of `crossings`.
    ///
    /// # Panics
    /// If `crossings` is not as long as `rays`.
    pub fn crossings_many(
        &self,
        rays: &[Ray],
        crossings: &mut [Vec<Crossing>],
        scratch: &mut Scratch,
    ) {
        assert_eq!(rays.len(), crossings.len(), "one list per ray");
        for (ray, list) in rays.iter().zip(crossings) {
            self.crossings(ray, scratch, list);
        }
    }

    /// Every crossing of an object-space ray, in order, appended to `crossings`.
    pub fn crossings(&self, ray: &Ray, scratch: &mut Scratch, crossings: &mut Vec<Crossing>) {
        if let Accel::Sweep(_) | Accel::Elsewhere = &self.accel {
            if ray.is_traceable() {
                sweep::crossings(self, self.exact_tree(), ray, scratch, crossings);
            }
            return;
        }
        let per_spacing = f64::from(self.field.spacing) / ray.direction.length();
        let local_origin = ray.origin - self.field.origin;
        let field = self.field.at(ray.time);
        let side_at = |t: f64| field.side(local_origin + ray.direction * t);
        let first = crossings.len();
        let fine_leaves = scratch.fine_leaves();
        let mut rest = *ray;
        while let Some(hit) = self.closest(&rest, scratch) {
            if scratch.fine_leaves() != fine_leaves {
                crossings.truncate(first);
                sweep::crossings(self, self.exact_tree(), ray, scratch, crossings);
                return;
            }
            let after = if hit.entering {
                Side::Inside
            } else {
                Side::Outside
            };
            let ulp = hit.t.abs().max(f64::MIN_POSITIVE) * f64::EPSILON;
            let behind = CROSSING_STEPS.map(|step| hit.t + (step * per_spacing).max(8.0 * ulp));
            // Within the accuracy of t the field must show the new side, else the ray only touched.
            let last = behind[CROSSING_STEPS.len() - 1];
            let was_there =
                last - rest.t_min <= 2.0 * (last - hit.t) && side_at(rest.t_min) == after;
            let seen = behind
                .into_iter()
                .find(|&t| !was_there && side_at(t) == after);
            let alternates = crossings[first..]
                .last()
                .is_none_or(|last| last.entering != hit.entering);
            if seen.is_some() && alternates {
                crossings.push(Crossing {
                    t: hit.t,
                    entering: hit.entering,
                });
            }
            // The field decides again, which keeps the list right where f32 sees only noise; what
            // the caller states holds until the first crossing.
            if crossings.len() > first {
                rest.side = Side::Unknown;
            }
            rest.t_min = seen.unwrap_or(last);
            if !(rest.t_min > hit.t && rest.t_min <= ray.t_max) {
                break;
            }
        }
    }
}
