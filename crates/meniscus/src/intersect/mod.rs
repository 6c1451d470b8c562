//! Rays against surfaces: the engines, and what they answer with.

pub mod cells;
pub mod interval;
pub mod metaballs;
pub mod particles;
mod solve;
pub mod sweep;

use crate::accel::Accel;
use crate::frame::{Blobs, Frame, Geometry};
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
    object_rays: ObjectRays,
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
    /// Unit outward normal in world space, −∇F/|∇F|; never flipped towards the eye.
    pub normal: DVec3,
    /// Index into [`Frame::instances`].
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
            Accel::Sweep(tree) => sweep::closest(self, tree, ray, scratch),
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
            Accel::Sweep(tree) => sweep::closest(self, tree, ray, scratch).is_some(),
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
            Accel::Cells(cells) => cells::closest_many(self, cells, rays, hits, scratch),
            Accel::Particles(_) | Accel::Interval(_) | Accel::Metaballs(_) | Accel::Sweep(_) => {
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
            Accel::Cells(cells) => cells::occluded_many(self, cells, rays, hits, scratch),
            Accel::Particles(_) | Accel::Interval(_) | Accel::Metaballs(_) | Accel::Sweep(_) => {
                for (ray, hit) in rays.iter().zip(hits) {
                    *hit = self.occluded(ray, scratch);
                }
            }
        }
    }

    /// Every crossing of an object-space ray, in order, appended to `crossings`.
    pub fn crossings(&self, ray: &Ray, scratch: &mut Scratch, crossings: &mut Vec<Crossing>) {
        if let Accel::Sweep(tree) = &self.accel {
            if ray.is_traceable() {
                sweep::crossings(self, tree, ray, scratch, crossings);
            }
            return;
        }
        let per_spacing = f64::from(self.field.spacing) / ray.direction.length();
        let local_origin = ray.origin - self.field.origin;
        let side_at = |t: f64| self.field.side(local_origin + ray.direction * t);
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

/// Rays that [`Frame::closest_hits`] and [`Frame::any_hits`] trace together.
const TOGETHER: usize = 16;

/// Buffers for rays in an object's space.
#[derive(Debug, Default)]
struct ObjectRays {
    rays: Vec<Ray>,
    closest: Vec<Option<BlobHit>>,
    occluded: Vec<bool>,
}

impl Frame {
    /// The first surface that a world-space ray meets.
    pub fn closest_hit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
        let mut hit = [None];
        self.closest_hits(std::slice::from_ref(ray), &mut hit, scratch);
        hit[0]
    }

    /// The first surfaces that world-space rays meet, one per entry of `hits`. Rays that lie close
    /// together and follow each other, such as those of a few neighbouring pixels, are traced
    /// together.
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>], scratch: &mut Scratch) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        let mut buffers = std::mem::take(&mut scratch.object_rays);
        for (rays, hits) in rays.chunks(TOGETHER).zip(hits.chunks_mut(TOGETHER)) {
            hits.fill(None);
            for (surface, instance) in self.instances.iter().enumerate() {
                let object_from_world = &instance.object_from_world;
                let as_they_are = is_identity(object_from_world)
                    && hits.iter().all(Option::is_none)
                    && states_side_of(rays, surface as u32);
                let object_rays = if as_they_are {
                    rays
                } else {
                    buffers.rays.clear();
                    let moved = rays.iter().zip(&*hits).map(|(ray, hit)| {
                        let nearest = hit.map_or(ray.t_max, |hit| hit.t);
                        transformed(ray, object_from_world)
                            .with_range(ray.t_min, nearest)
                            .with_side(ray.side_towards(surface as u32))
                    });
                    buffers.rays.extend(moved);
                    &buffers.rays
                };
                let normal_matrix = instance.object_from_world.matrix3.transpose();
                let hit_at = |ray: &Ray, t: f64, outward: DVec3, blob, entering| Hit {
                    t,
                    position: ray.at(t),
                    normal: (normal_matrix * outward).normalize_or_zero(),
                    surface: surface as u32,
                    blob,
                    entering,
                };
                match &self.geometries[instance.geometry as usize] {
                    Geometry::Blobs(blobs) => {
                        let found = &mut buffers.closest;
                        found.clear();
                        found.resize(rays.len(), None);
                        blobs.closest_many(object_rays, found, scratch);
                        for ((ray, hit), found) in rays.iter().zip(&mut *hits).zip(found) {
                            if let Some(f) = found {
                                *hit = Some(hit_at(
                                    ray,
                                    f.t,
                                    f.outward,
                                    Some(f.strongest),
                                    f.entering,
                                ));
                            }
                        }
                    }
                    Geometry::Plane(plane) => {
                        for ((ray, hit), moved) in rays.iter().zip(&mut *hits).zip(object_rays) {
                            if let Some((t, entering)) = plane.closest(moved) {
                                *hit = Some(hit_at(ray, t, plane.normal, None, entering));
                            }
                        }
                    }
                }
            }
        }
        scratch.object_rays = buffers;
    }

    /// Whether a world-space ray meets any surface.
    pub fn any_hit(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        let mut hit = [false];
        self.any_hits(std::slice::from_ref(ray), &mut hit, scratch);
        hit[0]
    }

    /// Whether world-space rays meet any surface, one per entry of `hits`, as
    /// [`Frame::closest_hits`].
    ///
    /// # Panics
    /// If `hits` is not as long as `rays`.
    pub fn any_hits(&self, rays: &[Ray], hits: &mut [bool], scratch: &mut Scratch) {
        assert_eq!(rays.len(), hits.len(), "one answer per ray");
        hits.fill(false);
        let mut buffers = std::mem::take(&mut scratch.object_rays);
        for (rays, hits) in rays.chunks(TOGETHER).zip(hits.chunks_mut(TOGETHER)) {
            for (surface, instance) in self.instances.iter().enumerate() {
                let surface = surface as u32;
                let object_from_world = &instance.object_from_world;
                let object_rays = if is_identity(object_from_world) && states_side_of(rays, surface)
                {
                    rays
                } else {
                    buffers.rays.clear();
                    let moved = rays.iter().map(|ray| {
                        transformed(ray, object_from_world).with_side(ray.side_towards(surface))
                    });
                    buffers.rays.extend(moved);
                    &buffers.rays
                };
                match &self.geometries[instance.geometry as usize] {
                    Geometry::Blobs(blobs) => {
                        let found = &mut buffers.occluded;
                        found.clear();
                        found.resize(rays.len(), false);
                        blobs.occluded_many(object_rays, found, scratch);
                        for (hit, found) in hits.iter_mut().zip(found) {
                            *hit |= *found;
                        }
                    }
                    Geometry::Plane(plane) => {
                        for (hit, ray) in hits.iter_mut().zip(object_rays) {
                            *hit |= plane.closest(ray).is_some();
                        }
                    }
                }
            }
        }
        scratch.object_rays = buffers;
    }
}

impl Frame {
    /// On which side of surface `surface` a world point lies.
    pub fn side(&self, surface: u32, point: DVec3) -> Side {
        let instance = &self.instances[surface as usize];
        let object = instance.object_from_world.transform_point3(point);
        match &self.geometries[instance.geometry as usize] {
            Geometry::Blobs(blobs) => blobs.field.side(object - blobs.field.origin),
            Geometry::Plane(plane) if (object - plane.point).dot(plane.normal) > 0.0 => {
                Side::Outside
            }
            Geometry::Plane(_) => Side::Inside,
        }
    }
}

impl crate::frame::Plane {
    /// First crossing of an object-space ray: its parameter and whether it enters. A ray with a
    /// stated side can only cross to the other one, so it does not hit the plane that it leaves.
    pub fn closest(&self, ray: &Ray) -> Option<(f64, bool)> {
        let rate = ray.direction.dot(self.normal);
        let t = (self.point - ray.origin).dot(self.normal) / rate;
        let entering = rate < 0.0;
        let can_cross = match ray.side {
            Side::Unknown => true,
            Side::Outside => entering,
            Side::Inside => !entering,
        };
        (can_cross && ray.is_traceable() && t.is_finite() && t >= ray.t_min && t <= ray.t_max)
            .then_some((t, entering))
    }
}

/// Whether what the rays state about sides holds for `surface` as it stands.
fn states_side_of(rays: &[Ray], surface: u32) -> bool {
    rays.iter().all(|ray| ray.side_towards(surface) == ray.side)
}

fn is_identity(object_from_world: &glam::DAffine3) -> bool {
    *object_from_world == glam::DAffine3::IDENTITY
}

fn transformed(ray: &Ray, object_from_world: &glam::DAffine3) -> Ray {
    Ray {
        origin: object_from_world.transform_point3(ray.origin),
        direction: object_from_world.transform_vector3(ray.direction),
        ..*ray
    }
}
