//! Derivatives of the field in space and time, in float64 on the packed numbers.

use super::FieldAt;
use crate::math::level_set::LevelSet;
use glam::{DMat3, DVec3};

impl FieldAt<'_> {
    /// All derivatives of F at a local point, from one look at its blobs (Ray Tracing Gems II, eqs. 35.5
    /// and 35.6). With m = Aᵀ A(x − p) and v a blob's velocity at this time, acceleration included,
    /// ∂q/∂t = −2 m·v; a blob that turns and stretches carries along what is about it, which adds G·d to v
    /// at a distance d. Second derivatives jump where a support ends and the kernel is `quartic` or
    /// `wyvill`.
    pub fn level_set(&self, local: DVec3) -> LevelSet {
        let mut sum = LevelSet {
            gradient: DVec3::ZERO,
            hessian: DMat3::ZERO,
            rate: 0.0,
            gradient_rate: DVec3::ZERO,
        };
        let kernel = self.field.kernel;
        self.for_each_blob_at(local, |i, y, q| {
            let weight = f64::from(self.field.weights[i]);
            let slope = 2.0 * weight * kernel.derivative(q);
            let bend = 4.0 * weight * kernel.second_derivative(q);
            let metric = |d: DVec3| self.transform_transposed(i, self.transform(i, d));
            let m = self.transform_transposed(i, y);
            let outer = DMat3::from_cols(m * m.x, m * m.y, m * m.z);
            let [x, y, z] = DVec3::AXES.map(metric);
            sum.gradient += m * slope;
            sum.hessian += outer * bend + DMat3::from_cols(x, y, z) * slope;
            if let Some(mut velocity) = self.blob_velocity(i) {
                let mut turned = DVec3::ZERO;
                if let Some(gradient) = self.material_gradient(i) {
                    velocity += gradient * (local - self.center(i));
                    turned = gradient.transpose() * m;
                }
                let along = m.dot(velocity);
                sum.rate -= slope * along;
                sum.gradient_rate -= m * (bend * along) + (metric(velocity) + turned) * slope;
            }
        });
        sum
    }
}
