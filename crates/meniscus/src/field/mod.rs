//! The scalar field F(x) = Σ wᵢ k(qᵢ(x)) of a particle set, packed for the engines.
//!
//! "Local" coordinates are the object's own minus [`BlobField::origin`]: small numbers that f32 can
//! carry even for a cloud a million units away.

mod anisotropy;
mod build;
mod colors;
mod derivatives;
mod error;
mod evaluate;
mod motion;
mod pack;
mod presence;
mod rates;
mod report;
mod search;
mod shape;
mod supports;
mod turning;
mod weights;

pub use build::{FieldBuild, LARGEST_COORDINATE};
pub use error::FieldError;
pub use evaluate::Contribution;

pub use motion::{FieldAt, Motion, MotionBoxes, Span};
pub use report::{FieldReport, SupportSource};
pub use search::Search;
pub use shape::metric::MetricOrder;
pub use turning::MOST_TURN;

use crate::kernel::Kernel;
use crate::math::aabb::Aabb;
use crate::primitive::Shapes;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A column that is blended on the surface by field weight.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldAttribute {
    /// The column's name.
    pub name: String,
    /// Numbers per blob.
    pub components: usize,
    /// The numbers, blob by blob.
    pub data: Vec<f32>,
}

/// A weighted sum of blobs and its threshold; flat arrays, one entry per blob.
#[derive(Debug, Clone, PartialEq)]
pub struct BlobField {
    /// Kernel of every blob.
    pub kernel: Kernel,
    /// The surface is F = threshold; inside is F > threshold.
    pub threshold: f32,
    /// Object-space position of the local origin.
    pub origin: DVec3,
    /// Local centres.
    pub centers: Vec<[f32; 3]>,
    /// Supports.
    pub shapes: Shapes,
    /// Weights wᵢ, finite, never 0.
    pub weights: Vec<f32>,
    /// The particle's row in its file.
    pub rows: Vec<u32>,
    /// How the blobs move while the shutter is open; `None`: they stand still.
    pub motion: Option<Motion>,
    /// Columns to blend.
    pub attributes: Vec<FieldAttribute>,
    /// Median distance of nearest neighbours: the length that tolerances are stated in.
    pub spacing: f32,
    /// Finds the blobs at a point; `Search::default()` until the first question.
    pub search: Search,
}

impl BlobField {
    /// Number of blobs.
    pub fn len(&self) -> usize {
        self.centers.len()
    }

    /// Whether there is no blob.
    pub fn is_empty(&self) -> bool {
        self.centers.is_empty()
    }

    /// Local centre of blob `i`.
    pub fn center(&self, i: usize) -> Vec3 {
        Vec3::from_array(self.centers[i])
    }

    /// Local box around all supports: the field is 0 outside.
    pub fn bounds(&self) -> Aabb {
        (0..self.len())
            .into_par_iter()
            .with_min_len(1 << 14)
            .map(|i| self.support_box(i))
            .reduce(|| Aabb::EMPTY, Aabb::union)
    }

    /// Whether any weight is negative, which switches off every bound that assumes a growing sum.
    pub fn has_negative_weights(&self) -> bool {
        self.weights.iter().any(|&w| w < 0.0)
    }
}

#[cfg(test)]
mod tests;
