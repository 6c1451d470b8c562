//! A surface point as an integrator sees it: its directions, and the rays that leave it.

use super::bsdf::Bsdf;
use super::medium::MediumStack;
use crate::intersect::Hit;
use crate::math::differential::RayDifferential;
use crate::math::level_set::HitChange;
use crate::math::ray::{Ray, Side};
use glam::{DVec3, Vec3};

/// A surface point, seen from one side.
pub(super) struct Interaction<'a> {
    /// The hit.
    pub(super) hit: Hit,
    /// Base colour.
    pub(super) color: Vec3,
    /// How it scatters.
    pub(super) bsdf: Bsdf<'a>,
    /// Towards the viewer, in the surface's frame: z > 0.
    pub(super) view: DVec3,
    /// The frame; the last axis is the normal on the viewer's side.
    pub(super) axes: [DVec3; 3],
    /// Media behind the surface; those in front of it if it is opaque.
    pub(super) beyond: MediumStack,
    /// How the hit changes by the film's x and y and by time, the normals on the viewer's side; where
    /// rays carry differentials.
    pub(super) changes: Option<[HitChange; 3]>,
}

/// What turns a ray that keeps its differential.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Turn {
    /// A mirror, rough ones included.
    Reflection,
    /// The boundary of two clear media; the index on the viewer's side over that beyond.
    Refraction(f64),
}

impl Interaction<'_> {
    /// World direction of one in the surface's frame.
    pub(super) fn to_world(&self, local: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        (x * local.x + y * local.y + z * local.z).normalize()
    }

    /// A world direction in the surface's frame.
    pub(super) fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(world)))
    }

    /// The normal on the viewer's side.
    pub(super) fn normal(&self) -> DVec3 {
        self.axes[2]
    }

    /// Whether a world direction lies on the same side of the face as of the shading normal: on the
    /// viewer's side or beyond. Where they differ, light would leak through the face.
    pub(super) fn agrees(&self, direction: DVec3, on_viewers_side: bool) -> bool {
        let Hit {
            normal,
            shading_normal,
            entering,
            ..
        } = &self.hit;
        shading_normal == normal || (direction.dot(*normal) > 0.0) == (on_viewers_side == *entering)
    }

    /// The differential of `ray`, which met the surface, behind it.
    pub(super) fn differential(&self, ray: &Ray, turn: Turn) -> Option<RayDifferential> {
        let changes = self.changes.as_ref()?;
        let arriving = ray.differential.as_ref()?;
        let (direction, normal) = (ray.direction, self.normal());
        match turn {
            Turn::Reflection => Some(arriving.reflected(direction, normal, changes)),
            Turn::Refraction(eta) => arriving.refracted(direction, normal, eta, changes),
        }
    }

    /// The ray that leaves in world direction `direction`, which lies on the viewer's side or beyond.
    /// It states its side, so it starts on the surface itself.
    pub(super) fn leaving(&self, direction: DVec3, on_viewers_side: bool, time: f64) -> Ray {
        let side = if self.hit.entering == on_viewers_side {
            Side::Outside
        } else {
            Side::Inside
        };
        Ray {
            time,
            side,
            side_of: Some(self.hit.surface),
            ..Ray::new(self.hit.position, direction)
        }
    }
}
