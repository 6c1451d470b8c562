//! Rays against surfaces: the engines, and what they answer with.

pub mod cells;
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
}

impl std::ops::AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.nodes += other.nodes;
        self.leaves += other.leaves;
        self.blob_evaluations += other.blob_evaluations;
    }
}

/// Buffers that one thread reuses from ray to ray.
#[derive(Debug, Default)]
pub struct Scratch {
    /// Work counted so far.
    pub counters: Counters,
    /// Of engine `cells`.
    pub cells: cells::CellsScratch,
    /// Of engine `sweep`.
    pub sweep: sweep::SweepScratch,
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
            Accel::Sweep(tree) => sweep::closest(self, tree, ray, scratch).is_some(),
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
        let mut rest = *ray;
        while let Some(hit) = self.closest(&rest, scratch) {
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

impl Frame {
    /// The first surface that a world-space ray meets.
    pub fn closest_hit(&self, ray: &Ray, scratch: &mut Scratch) -> Option<Hit> {
        let mut closest: Option<Hit> = None;
        let mut rest = *ray;
        for (surface, instance) in self.instances.iter().enumerate() {
            let moved;
            let object_ray = if instance.object_from_world == glam::DAffine3::IDENTITY {
                &rest
            } else {
                moved = transformed(&rest, &instance.object_from_world);
                &moved
            };
            let found = match &self.geometries[instance.geometry as usize] {
                Geometry::Blobs(blobs) => blobs
                    .closest(object_ray, scratch)
                    .map(|hit| (hit.t, hit.outward, Some(hit.strongest), hit.entering)),
                Geometry::Plane(plane) => plane
                    .closest(object_ray)
                    .map(|(t, entering)| (t, plane.normal, None, entering)),
            };
            if let Some((t, outward, blob, entering)) = found {
                rest.t_max = t;
                let normal_matrix = instance.object_from_world.matrix3.transpose();
                closest = Some(Hit {
                    t,
                    position: ray.at(t),
                    normal: (normal_matrix * outward).normalize_or_zero(),
                    surface: surface as u32,
                    blob,
                    entering,
                });
            }
        }
        closest
    }

    /// Whether a world-space ray meets any surface.
    pub fn any_hit(&self, ray: &Ray, scratch: &mut Scratch) -> bool {
        self.instances.iter().any(|instance| {
            let object_ray = transformed(ray, &instance.object_from_world);
            match &self.geometries[instance.geometry as usize] {
                Geometry::Blobs(blobs) => blobs.occluded(&object_ray, scratch),
                Geometry::Plane(plane) => plane.closest(&object_ray).is_some(),
            }
        })
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

fn transformed(ray: &Ray, object_from_world: &glam::DAffine3) -> Ray {
    if *object_from_world == glam::DAffine3::IDENTITY {
        return *ray;
    }
    Ray {
        origin: object_from_world.transform_point3(ray.origin),
        direction: object_from_world.transform_vector3(ray.direction),
        ..*ray
    }
}
