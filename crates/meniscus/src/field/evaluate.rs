//! What the field is at any point, in float64 on the packed numbers. Points are local: object space
//! minus [`BlobField::origin`].

use super::{BlobField, FieldAt};
use crate::math::ray::Side;
use glam::{DMat3, DVec3};

/// One blob's part in the field at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contribution {
    /// Index of the blob.
    pub blob: u32,
    /// wᵢ·k(qᵢ).
    pub weight: f64,
}

/// A sum of weights this much smaller than the sum of their sizes is noise.
const CANCELLED: f64 = 1e-9;

impl FieldAt<'_> {
    /// F = Σ wᵢ k(qᵢ).
    pub fn value(&self, local: DVec3) -> f64 {
        let mut sum = 0.0;
        self.for_each_blob_at(local, |i, _, q| {
            sum += f64::from(self.field.weights[i]) * self.field.kernel.value(q);
        });
        sum
    }

    /// ∇F = Σ wᵢ k′(qᵢ)·2Aᵀy, in 1/length.
    pub fn gradient(&self, local: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        self.for_each_blob_at(local, |i, y, q| {
            let factor = 2.0 * f64::from(self.field.weights[i]) * self.field.kernel.derivative(q);
            sum += factor * self.transform_transposed(i, y);
        });
        sum
    }

    /// ∇∇F, in 1/length²: that of [`FieldAt::level_set`].
    pub fn hessian(&self, local: DVec3) -> DMat3 {
        self.level_set(local).hessian
    }

    /// Velocities blended by field weight, in lengths per second; 0 where nothing moves or reaches.
    pub fn velocity(&self, local: DVec3) -> DVec3 {
        if self.field.motion.is_none() {
            return DVec3::ZERO;
        }
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        self.for_each_blob_at(local, |i, _, q| {
            let weight = f64::from(self.field.weights[i]) * self.field.kernel.value(q);
            sum += self.blob_velocity(i).unwrap_or(DVec3::ZERO) * weight;
            weights += weight;
        });
        if weights == 0.0 {
            DVec3::ZERO
        } else {
            sum / weights
        }
    }

    /// Inside where F > T, outside otherwise.
    pub fn side(&self, local: DVec3) -> Side {
        if self.value(local) > f64::from(self.field.threshold) {
            Side::Inside
        } else {
            Side::Outside
        }
    }

    /// Every blob whose support contains the point, with its part in F; replaces what is in `parts`.
    pub fn contributions(&self, local: DVec3, parts: &mut Vec<Contribution>) {
        parts.clear();
        self.for_each_blob_at(local, |i, _, q| {
            parts.push(Contribution {
                blob: i as u32,
                weight: f64::from(self.field.weights[i]) * self.field.kernel.value(q),
            });
        });
    }

    /// The blob with the largest |wᵢ kᵢ|, of equals the first; `None` outside all supports.
    pub fn strongest(&self, local: DVec3) -> Option<u32> {
        let mut strongest: Option<(f64, usize)> = None;
        self.for_each_blob_at(local, |i, _, q| {
            let part = (f64::from(self.field.weights[i]) * self.field.kernel.value(q)).abs();
            let better =
                strongest.is_none_or(|(best, blob)| part > best || (part == best && i < blob));
            if better {
                strongest = Some((part, i));
            }
        });
        strongest.map(|(_, blob)| blob as u32)
    }
}

/// At the frame's time.
impl BlobField {
    /// F = Σ wᵢ k(qᵢ).
    pub fn value(&self, local: DVec3) -> f64 {
        self.at(0.0).value(local)
    }

    /// [`FieldAt::gradient`].
    pub fn gradient(&self, local: DVec3) -> DVec3 {
        self.at(0.0).gradient(local)
    }

    /// [`FieldAt::hessian`].
    pub fn hessian(&self, local: DVec3) -> DMat3 {
        self.at(0.0).hessian(local)
    }

    /// Inside where F > T, outside otherwise.
    pub fn side(&self, local: DVec3) -> Side {
        self.at(0.0).side(local)
    }

    /// [`FieldAt::contributions`].
    pub fn contributions(&self, local: DVec3, parts: &mut Vec<Contribution>) {
        self.at(0.0).contributions(local, parts);
    }

    /// [`FieldAt::strongest`].
    pub fn strongest(&self, local: DVec3) -> Option<u32> {
        self.at(0.0).strongest(local)
    }

    /// The attribute of index `attribute` blended by field weight: Σ wᵢkᵢaᵢ / Σ wᵢkᵢ over `parts`, one
    /// number per component. With negative weights the result can leave the range of the aᵢ, and where
    /// the sum cancels (it cannot on the surface, where it is T) the sizes |wᵢkᵢ| weigh instead.
    /// Entries that are not finite take no part. A component with no part at all is 0.
    ///
    /// # Panics
    /// If `attribute` is out of range or `blend` is shorter than the attribute has components.
    pub fn blend(&self, attribute: usize, parts: &[Contribution], blend: &mut [f64]) {
        let attribute = &self.attributes[attribute];
        for (component, blend) in blend[..attribute.components].iter_mut().enumerate() {
            let mut signed = (0.0, 0.0);
            let mut sizes = (0.0, 0.0);
            for part in parts {
                let index = part.blob as usize * attribute.components + component;
                let value = f64::from(attribute.data[index]);
                if value.is_finite() {
                    signed.0 += part.weight * value;
                    signed.1 += part.weight;
                    sizes.0 += part.weight.abs() * value;
                    sizes.1 += part.weight.abs();
                }
            }
            let (sum, weight) = if signed.1.abs() > CANCELLED * sizes.1 {
                signed
            } else {
                sizes
            };
            *blend = if weight == 0.0 { 0.0 } else { sum / weight };
        }
    }

    /// [`BlobField::blend`] at a point.
    ///
    /// # Panics
    /// If `attribute` is out of range.
    pub fn attribute(&self, attribute: usize, local: DVec3) -> Vec<f64> {
        let mut parts = Vec::new();
        self.contributions(local, &mut parts);
        let mut blend = vec![0.0; self.attributes[attribute].components];
        self.blend(attribute, &parts, &mut blend);
        blend
    }
}
