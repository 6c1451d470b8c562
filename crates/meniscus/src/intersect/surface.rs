//! What a surface does around a hit: how it is curved, and how it moves.
//!
//! With the outward normal n = −∇F/|∇F|, twice the mean curvature is div n, and the Gaussian curvature
//! ∇Fᵀ adj(∇∇F) ∇F / |∇F|⁴ (Goldman 2005, eqs. 4.1 and 4.2; Ray Tracing Gems II, §35.5).

use super::Hit;
use crate::frame::{Frame, Geometry, Instance};
use glam::{DMat3, DVec3};

/// Curvatures of a surface, positive where it bulges outwards: 1/r and 1/r² on a ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Curvature {
    /// Mean of the two principal curvatures, in 1/length.
    pub mean: f64,
    /// Their product, in 1/length².
    pub gaussian: f64,
}

impl Curvature {
    /// Of the surface F = constant with this gradient and Hessian; flat where the gradient is 0.
    fn of_level_set(gradient: DVec3, hessian: DMat3) -> Self {
        let steepness = gradient.length();
        if steepness == 0.0 {
            return Self::default();
        }
        let n = gradient / steepness;
        let trace = hessian.x_axis.x + hessian.y_axis.y + hessian.z_axis.z;
        let along = n.dot(hessian * n);
        // The adjugate of a symmetric matrix has the cross products of its columns for rows.
        let [a, b, c] = [hessian.x_axis, hessian.y_axis, hessian.z_axis];
        let adjugate_n = b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z;
        Self {
            mean: -0.5 * (trace - along) / steepness,
            gaussian: n.dot(adjugate_n) / (steepness * steepness),
        }
    }
}

impl Frame {
    /// Curvatures at a hit of a ray of this time (seconds relative to the frame), in world space. Meshes,
    /// planes and caps of cuts are flat.
    pub fn curvature(&self, hit: &Hit, time_secs: f64) -> Curvature {
        let instance = &self.instances[hit.surface as usize];
        match &self.geometries[instance.geometry as usize] {
            Geometry::Blobs(_) if self.is_on_cap(hit) => Curvature::default(),
            Geometry::Blobs(blobs) => {
                let object = instance.object_from_world.transform_point3(hit.position);
                let field = blobs.field.at(time_secs);
                let local = object - blobs.field.origin;
                level_set_in_world(field.gradient(local), field.hessian(local), instance)
            }
            Geometry::Sphere(_) if self.is_on_cap(hit) => Curvature::default(),
            Geometry::Sphere(sphere) => {
                // F = −|x − c|².
                let object = instance.object_from_world.transform_point3(hit.position);
                let gradient = (sphere.center - object) * 2.0;
                level_set_in_world(gradient, DMat3::IDENTITY * -2.0, instance)
            }
            Geometry::Mesh(_) | Geometry::Plane(_) => Curvature::default(),
        }
    }

    /// Velocity of what the surface is made of at a hit, in world units per second: that of its
    /// particles, blended by field weight.
    pub fn velocity(&self, hit: &Hit, time_secs: f64) -> DVec3 {
        let instance = &self.instances[hit.surface as usize];
        match &self.geometries[instance.geometry as usize] {
            Geometry::Blobs(blobs) => {
                let object = instance.object_from_world.transform_point3(hit.position);
                let velocity = blobs
                    .field
                    .at(time_secs)
                    .velocity(object - blobs.field.origin);
                instance.world_from_object.transform_vector3(velocity)
            }
            Geometry::Sphere(_) | Geometry::Mesh(_) | Geometry::Plane(_) => DVec3::ZERO,
        }
    }

    fn is_on_cap(&self, hit: &Hit) -> bool {
        self.clips.iter().any(|plane| plane.normal == hit.normal)
    }
}

/// From object space, whose derivatives change like covectors.
fn level_set_in_world(gradient: DVec3, hessian: DMat3, instance: &Instance) -> Curvature {
    let object_from_world = instance.object_from_world.matrix3;
    let covector = object_from_world.transpose();
    Curvature::of_level_set(covector * gradient, covector * hessian * object_from_world)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ball_cylinder_and_saddle() {
        let near = |found: Curvature, mean: f64, gaussian: f64| {
            let off = (found.mean - mean).abs() + (found.gaussian - gaussian).abs();
            assert!(off < 1e-12, "{found:?} instead of {mean}, {gaussian}");
        };
        let x = DVec3::new(0.6, -1.2, 1.3);
        let r = x.length();
        // F = −|x|⁴: another function with the same level sets.
        let outer = DMat3::from_cols(x * x.x, x * x.y, x * x.z);
        let hessian = (DMat3::IDENTITY * x.length_squared() + outer * 2.0) * -4.0;
        let ball = Curvature::of_level_set(x * (-4.0 * x.length_squared()), hessian);
        near(ball, 1.0 / r, 1.0 / (r * r));
        let round = DMat3::from_diagonal(DVec3::new(-2.0, -2.0, 0.0));
        near(
            Curvature::of_level_set(DVec3::new(-2.0 * 0.25, 0.0, 0.0), round),
            0.5 / 0.25,
            0.0,
        );
        // z = (a x² + b y²)/2 seen from above, F = that − z.
        let saddle = DMat3::from_diagonal(DVec3::new(3.0, -2.0, 0.0));
        near(Curvature::of_level_set(DVec3::NEG_Z, saddle), -0.5, -6.0);
    }
}
