//! Rays against triangle meshes in float64: watertight (S. Woop, C. Benthin, I. Wald, *Watertight
//! Ray/Triangle Intersection*, JCGT 2 (2013) 65), with ties on edges broken by moving the ray
//! infinitesimally (simulation of simplicity): it passes every edge on one side, so that the number
//! of crossings of a closed mesh is exact.

use super::Crossing;
use super::solids::{SolidHit, contradicts};
use crate::frame::MeshSurface;
use crate::math::ray::{Ray, Side};
use crate::mesh::area_direction;
use glam::DVec3;
use std::cell::OnceCell;

/// Where rays that ask for a side go: along no edge that people make.
const PROBE: DVec3 = DVec3::new(0.357_182_9, 0.548_917_3, 0.755_631_1);

/// A ray in a mesh's own coordinates, its origin moved close to the mesh.
struct OwnRay {
    origin: DVec3,
    /// One over the components of the unit direction.
    inverse: DVec3,
    /// Axes: x and y of the sheared space, and the one that dominates the direction.
    axes: [usize; 3],
    /// Shear and scale that turn the direction into (0, 0, 1).
    shear: DVec3,
    /// Own parameter is `(t − shift)·speed`.
    shift: f64,
    speed: f64,
    t_min: f64,
    t_max: f64,
    side: Side,
    /// The ray's start.
    start: DVec3,
    /// How far the start may be off its surface by rounding.
    tolerance: f64,
    /// Whether it is that close to the surface, once somebody has asked.
    starts_on: OnceCell<bool>,
}

/// A crossing of one triangle in own parameters.
#[derive(Clone, Copy)]
struct TriangleHit {
    triangle: usize,
    t: f64,
    /// Barycentric coordinates.
    weights: [f64; 3],
    entering: bool,
}

impl OwnRay {
    fn new(mesh: &MeshSurface, ray: &Ray, origin_error: f64) -> Option<Self> {
        if !ray.is_traceable() {
            return None;
        }
        let far_origin = (ray.origin - mesh.center) / mesh.size;
        let per_t = ray.direction / mesh.size;
        let speed = per_t.length();
        let direction = per_t / speed;
        if !(direction.is_finite() && far_origin.is_finite()) {
            return None;
        }
        // The box is [−1, 1]³: where a ray comes from far away its origin is moved up to it.
        let reach = far_origin.length();
        let shift = (reach - 2.0).max(0.0) / speed;
        let origin = far_origin + direction * (shift * speed);
        let along = direction.abs();
        let z = if along.x > along.y && along.x > along.z {
            0
        } else if along.y > along.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        Some(Self {
            origin,
            inverse: direction.recip(),
            axes: [x, y, z],
            shear: DVec3::new(
                direction[x] / direction[z],
                direction[y] / direction[z],
                1.0 / direction[z],
            ),
            shift,
            speed,
            t_min: (ray.t_min - shift) * speed,
            t_max: (ray.t_max - shift) * speed,
            side: ray.side,
            start: far_origin + direction * (ray.t_min * speed),
            tolerance: origin_error / mesh.size,
            starts_on: OnceCell::new(),
        })
    }

    fn outer_t(&self, t: f64) -> f64 {
        t / self.speed + self.shift
    }

    /// Where the ray enters a box, if it does before `t_max`. Boxes are rounded outwards.
    fn enters(&self, min: [f32; 3], max: [f32; 3], t_max: f64) -> Option<f64> {
        let (mut near, mut far) = (self.t_min, t_max);
        for axis in 0..3 {
            let a = (f64::from(min[axis]) - self.origin[axis]) * self.inverse[axis];
            let b = (f64::from(max[axis]) - self.origin[axis]) * self.inverse[axis];
            // A NaN (0 · ∞, within a side) leaves the other value.
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far * (1.0 + 4.0 * f64::EPSILON) + f64::MIN_POSITIVE).then_some(near)
    }

    /// A corner in sheared coordinates about the origin.
    fn sheared(&self, corner: DVec3) -> [f64; 3] {
        let [x, y, z] = self.axes;
        let from = corner - self.origin;
        [
            from[x] - self.shear.x * from[z],
            from[y] - self.shear.y * from[z],
            self.shear.z * from[z],
        ]
    }

    fn crosses(&self, triangle: usize, corners: [DVec3; 3]) -> Option<TriangleHit> {
        let [a, b, c] = corners.map(|corner| self.sheared(corner));
        let (u, v, w) = (edge(c, b), edge(a, c), edge(b, a));
        let entering = u.is_positive;
        if v.is_positive != entering || w.is_positive != entering {
            return None;
        }
        let sum = u.value + v.value + w.value;
        if sum == 0.0 || !sum.is_finite() {
            return None;
        }
        let weights = [u.value / sum, v.value / sum, w.value / sum];
        let t = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        (t >= self.t_min && t <= self.t_max).then_some(TriangleHit {
            triangle,
            t,
            weights,
            entering,
        })
    }
}

/// Twice the signed area of the origin and an edge, and its sign once the origin has been moved by
/// (ε, ε²).
#[derive(Clone, Copy)]
struct Edge {
    value: f64,
    is_positive: bool,
}

fn edge(p: [f64; 3], q: [f64; 3]) -> Edge {
    let value = p[0] * q[1] - p[1] * q[0];
    let sign = if value != 0.0 {
        value
    } else if p[1] != q[1] {
        p[1] - q[1]
    } else {
        q[0] - p[0]
    };
    Edge {
        value,
        is_positive: sign > 0.0,
    }
}

impl MeshSurface {
    /// First crossing of an object-space ray. `origin_error` bounds how far rounding may have moved
    /// the ray's origin (object space): the surface that a ray with a stated side starts on is not
    /// hit from the other side.
    pub fn closest(&self, ray: &Ray, origin_error: f64, stack: &mut Vec<u32>) -> Option<SolidHit> {
        let own = OwnRay::new(self, ray, origin_error)?;
        let mut best: Option<TriangleHit> = None;
        self.traverse(&own, stack, |hit, t_max| {
            if best.is_none_or(|best| hit.t < best.t) {
                best = Some(hit);
                *t_max = hit.t;
            }
            true
        });
        best.map(|hit| self.hit(&own, hit))
    }

    /// Whether an object-space ray meets the mesh at all, as [`MeshSurface::closest`].
    pub fn occluded(&self, ray: &Ray, origin_error: f64, stack: &mut Vec<u32>) -> bool {
        let Some(own) = OwnRay::new(self, ray, origin_error) else {
            return false;
        };
        let mut found = false;
        self.traverse(&own, stack, |_, _| {
            found = true;
            false
        });
        found
    }

    /// Every crossing of an object-space ray in order, appended to `crossings`. Of a closed mesh those
    /// that lead from outside to inside or back: walls within the solid do not count.
    pub fn crossings(
        &self,
        ray: &Ray,
        origin_error: f64,
        stack: &mut Vec<u32>,
        crossings: &mut Vec<Crossing>,
    ) {
        let Some(own) = OwnRay::new(self, ray, origin_error) else {
            return;
        };
        let mut all: Vec<(f64, bool)> = Vec::new();
        self.traverse(&own, stack, |hit, _| {
            all.push((hit.t, hit.entering));
            true
        });
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let as_crossing = |&(t, entering): &(f64, bool)| Crossing {
            t: own.outer_t(t),
            entering,
        };
        if !self.is_closed {
            crossings.extend(all.iter().map(as_crossing));
            return;
        }
        let mut depth = match ray.side {
            Side::Unknown => self.winding(ray.at(ray.t_min), stack),
            Side::Outside => 0,
            Side::Inside => 1,
        };
        for pair in &all {
            let before = depth;
            depth += if pair.1 { 1 } else { -1 };
            if (before > 0) != (depth > 0) {
                crossings.push(as_crossing(pair));
            }
        }
    }

    /// Which side an object-space point lies on; open meshes have no inside.
    pub fn side(&self, point: DVec3, stack: &mut Vec<u32>) -> Side {
        if self.is_closed && self.winding(point, stack) > 0 {
            Side::Inside
        } else {
            Side::Outside
        }
    }

    /// How often the mesh winds around a point.
    fn winding(&self, point: DVec3, stack: &mut Vec<u32>) -> i32 {
        let mut winding = 0;
        if let Some(own) = OwnRay::new(self, &Ray::new(point, PROBE * self.size), 0.0) {
            self.traverse(&own, stack, |hit, _| {
                winding += if hit.entering { -1 } else { 1 };
                true
            });
        }
        winding
    }

    /// Calls `visit` with every triangle that the ray crosses, near boxes first; it may shorten the
    /// ray, and ends the walk with `false`.
    fn traverse(
        &self,
        ray: &OwnRay,
        stack: &mut Vec<u32>,
        mut visit: impl FnMut(TriangleHit, &mut f64) -> bool,
    ) {
        let nodes = &self.tree.nodes;
        let mut t_max = ray.t_max;
        stack.clear();
        let Some(root) = nodes.first() else { return };
        if ray.enters(root.min, root.max, t_max).is_none() {
            return;
        }
        stack.push(0);
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            if node.count > 0 {
                let places = node.first as usize..(node.first + node.count) as usize;
                for &triangle in &self.tree.order[places] {
                    let triangle = triangle as usize;
                    let crossed = ray.crosses(triangle, self.corners(triangle));
                    if let Some(hit) = crossed.filter(|hit| hit.t <= t_max)
                        && !self.is_own_start(ray, hit.entering)
                        && !visit(hit, &mut t_max)
                    {
                        return;
                    }
                }
                continue;
            }
            let children = [node.first, node.first + 1];
            let [near, far] = children.map(|child| {
                let child = &nodes[child as usize];
                ray.enters(child.min, child.max, t_max)
            });
            match (near, far) {
                (Some(a), Some(b)) if b < a => stack.extend(children),
                (Some(_), Some(_)) => stack.extend([children[1], children[0]]),
                (Some(_), None) => stack.push(children[0]),
                (None, Some(_)) => stack.push(children[1]),
                (None, None) => {}
            }
        }
    }

    /// Whether a crossing only shows that rounding has put the start on the other side of the surface
    /// that the ray leaves: it would come from the side that the ray is not on, and the start is as
    /// close to the surface as rounding can bring it. A ray that leaves at a grazing angle may seem to
    /// come out through a neighbour of the triangle that it left.
    fn is_own_start(&self, ray: &OwnRay, entering: bool) -> bool {
        contradicts(ray.side, entering)
            && *ray
                .starts_on
                .get_or_init(|| self.is_on_surface(ray.start, ray.tolerance))
    }

    /// Whether a point lies within `tolerance` of a triangle (own coordinates).
    fn is_on_surface(&self, point: DVec3, tolerance: f64) -> bool {
        let nodes = &self.tree.nodes;
        let mut stack: Vec<u32> = Vec::with_capacity(64);
        stack.extend((!nodes.is_empty()).then_some(0));
        while let Some(index) = stack.pop() {
            let node = &nodes[index as usize];
            let is_in_box = (0..3).all(|axis| {
                point[axis] >= f64::from(node.min[axis]) - tolerance
                    && point[axis] <= f64::from(node.max[axis]) + tolerance
            });
            if !is_in_box {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, node.first + 1]);
                continue;
            }
            let places = node.first as usize..(node.first + node.count) as usize;
            let is_near = self.tree.order[places].iter().any(|&triangle| {
                let [a, b, c] = self.corners(triangle as usize);
                let (low, high) = (a.min(b).min(c) - tolerance, a.max(b).max(c) + tolerance);
                let height = area_direction([a, b, c]).dot(point - a);
                height.abs() <= tolerance && point.cmpge(low).all() && point.cmple(high).all()
            });
            if is_near {
                return true;
            }
        }
        false
    }

    fn hit(&self, ray: &OwnRay, hit: TriangleHit) -> SolidHit {
        let corners = self.corners(hit.triangle);
        let outward = area_direction(corners);
        let [u, v, w] = hit.weights;
        // From the corners, not along the ray: no error of a far origin.
        let position = corners[0] * u + corners[1] * v + corners[2] * w;
        let shading = self.corner_normals.get(hit.triangle).map(|normals| {
            let [a, b, c] = normals.map(|normal| match normal.as_dvec3() {
                DVec3::ZERO => outward,
                normal => normal,
            });
            (a * u + b * v + c * w).normalize_or(outward)
        });
        SolidHit {
            t: ray.outer_t(hit.t),
            position: self.center + position * self.size,
            outward,
            shading: shading.unwrap_or(outward),
            entering: hit.entering,
        }
    }
}

#[cfg(test)]
mod tests;
