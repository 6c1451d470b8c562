//! Bounds of what stands in a frame: all of it, and the part that a camera should frame.

use super::{Blobs, Frame, Geometry, Instance, Sphere};
use crate::field::BlobField;
use crate::math::aabb::{Aabb, DAabb};
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

/// Per axis, the part of the particles that may lie outside on each side of the dense middle.
const STRAY_FRACTION: f64 = 0.002;
/// How far the middle is widened on each side, in its own widths, before particles outside it count
/// as strays.
const STRAY_REACH: f32 = 0.5;
/// Particles that one task handles at least.
const PARALLEL: usize = 1 << 14;
/// At most about this many particles decide on the middle.
const SAMPLES: usize = 1 << 16;

impl Geometry {
    /// Object-space box around the surface at any time in `shutter` (seconds relative to the frame);
    /// `None` where it is infinite. Every shutter has the same box, that of the field's own.
    pub fn bounds(&self, _shutter: [f64; 2]) -> Option<DAabb> {
        match self {
            Self::Blobs(blobs) => Some(in_object_space(&blobs.field, blobs.field.bounds())),
            Self::Mesh(mesh) => Some(mesh.bounds()),
            Self::Sphere(sphere) => Some(sphere_box(sphere)),
            Self::Plane(_) => None,
        }
    }
}

impl Frame {
    /// World-space box around the supports of all blobs, meshes and spheres at any time in
    /// `shutter`; planes do not count. Empty when there is nothing else.
    pub fn bounds(&self, shutter: [f64; 2]) -> DAabb {
        self.instances
            .iter()
            .fold(DAabb::EMPTY, |bounds, instance| {
                match self.geometries[instance.geometry as usize].bounds(shutter) {
                    Some(local) => bounds.union(instance.bounds(local, shutter)),
                    None => bounds,
                }
            })
    }

    /// About how far what an instance places extends in the world at the frame's time; of planes, as far as
    /// all the rest.
    pub fn reach_of(&self, instance: &Instance) -> f64 {
        let local = self.geometries[instance.geometry as usize].bounds([0.0; 2]);
        let all = || self.bounds([0.0; 2]);
        let bounds =
            local.map_or_else(all, |local| transformed(local, &instance.world_from_object));
        let reach = 0.5 * bounds.size().max_element();
        if reach > 0.0 { reach } else { 1.0 }
    }

    /// Whether all of a box is sure to lie outside a surface at any time in `shutter`.
    pub fn is_outside(&self, surface: u32, place: &DAabb, shutter: [f64; 2]) -> bool {
        let instance = &self.instances[surface as usize];
        let geometry = &self.geometries[instance.geometry as usize];
        match (geometry.bounds(shutter), geometry) {
            (Some(local), _) => !instance.bounds(local, shutter).touches(place),
            (None, Geometry::Plane(plane)) if instance.path.is_none() => {
                let place = transformed(*place, &instance.object_from_world);
                let reach = (place.size() * 0.5).dot(plane.normal.abs());
                (place.center() - plane.point).dot(plane.normal) > reach
            }
            (None, _) => false,
        }
    }

    /// World-space box that a camera should show and the ground should touch: the surfaces without
    /// stray particles.
    ///
    /// Along each axis the middle 99.6 % of the particles span an interval; widened by half its
    /// width on both sides, it holds everything that belongs to the object. Particles outside (a few
    /// drops that flew ten times as far as the rest) do not count; without such particles this is
    /// the tight box. It includes the surface's distance from the outermost centres.
    pub fn framing_bounds(&self) -> DAabb {
        let mut boxes: Vec<Option<DAabb>> = vec![None; self.geometries.len()];
        self.instances
            .iter()
            .fold(DAabb::EMPTY, |bounds, instance| {
                let index = instance.geometry as usize;
                let tight = || match &self.geometries[index] {
                    Geometry::Blobs(blobs) => without_strays(blobs),
                    Geometry::Mesh(mesh) => mesh.bounds(),
                    Geometry::Sphere(sphere) => sphere_box(sphere),
                    Geometry::Plane(_) => DAabb::EMPTY,
                };
                let local = *boxes[index].get_or_insert_with(tight);
                bounds.union(transformed(local, &instance.world_from_object))
            })
    }
}

fn sphere_box(sphere: &Sphere) -> DAabb {
    DAabb {
        min: sphere.center - sphere.radius,
        max: sphere.center + sphere.radius,
    }
}

fn without_strays(blobs: &Blobs) -> DAabb {
    let field = &blobs.field;
    let Some(middle) = middle_of(field) else {
        return DAabb::EMPTY;
    };
    let lone = field.kernel.q_at(f64::from(field.threshold));
    let all = (0..field.len()).into_par_iter().with_min_len(PARALLEL);
    let kept = all.filter(|&i| middle.contains(field.center(i)));
    let boxes = kept.map(|i| {
        let reach = surface_distance(field, i, lone);
        let center = field.center(i);
        Aabb {
            min: center - reach,
            max: center + reach,
        }
    });
    let bounds = boxes.reduce(|| Aabb::EMPTY, Aabb::union);
    in_object_space(field, bounds)
}

/// The box outside which particles are strays; `None` without particles.
fn middle_of(field: &BlobField) -> Option<Aabb> {
    let stride = (field.len() / SAMPLES).max(1);
    let sample = || field.centers.iter().step_by(stride);
    let strays = (sample().len() as f64 * STRAY_FRACTION) as usize;
    let mut middle = Aabb::EMPTY;
    for axis in 0..3 {
        let mut places: Vec<f32> = sample().map(|center| center[axis]).collect();
        if places.is_empty() {
            return None;
        }
        let (_, low, above) = places.select_nth_unstable_by(strays, f32::total_cmp);
        let low = *low;
        // `above` holds the others in any order; the high mark is `strays` below the largest.
        let high = match above.len() {
            0 => low,
            rest => {
                let (_, high, _) =
                    above.select_nth_unstable_by(rest.saturating_sub(1 + strays), f32::total_cmp);
                *high
            }
        };
        let reach = (high - low) * STRAY_REACH;
        middle.min[axis] = low - reach;
        middle.max[axis] = high + reach;
    }
    Some(middle)
}

/// How far the surface lies from centre `i`, about: where blob `i` alone reaches the threshold, or
/// half a spacing where it needs its neighbours for that. Never beyond the support.
fn surface_distance(field: &BlobField, i: usize, lone: Option<f64>) -> Vec3 {
    let support = Vec3::from_array(field.shapes.half_extents(i));
    let weight = f64::from(field.weights[i]);
    let q = if weight == 1.0 {
        lone
    } else {
        field.kernel.q_at(f64::from(field.threshold) / weight)
    };
    match q {
        Some(q) => support * q.sqrt() as f32,
        None => support.min(Vec3::splat(0.5 * field.spacing)),
    }
}

fn in_object_space(field: &BlobField, local: Aabb) -> DAabb {
    DAabb {
        min: field.origin + local.min.as_dvec3(),
        max: field.origin + local.max.as_dvec3(),
    }
}

/// The box around a transformed box (Arvo 1990).
pub(super) fn transformed(bounds: DAabb, map: &DAffine3) -> DAabb {
    if bounds.is_empty() {
        return bounds;
    }
    let half = bounds.size() * 0.5;
    let center = map.transform_point3(bounds.center());
    let m = map.matrix3;
    let reach: DVec3 = m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z;
    DAabb {
        min: center - reach,
        max: center + reach,
    }
}
