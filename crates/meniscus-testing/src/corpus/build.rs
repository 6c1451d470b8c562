//! From float64 points to a packed field.

use glam::{DMat3, DVec3};
use meniscus::field::{BlobField, Search};
use meniscus::kernel::Kernel;
use meniscus::primitive::{Ellipsoid, Shapes};

/// Supports of the blobs of a recipe.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Support radii R.
    Balls(Vec<f64>),
    /// Half axes (the columns' lengths) and their directions: the support is the image of the unit ball.
    Ellipsoids(Vec<DMat3>),
}

/// Weights of the blobs of a recipe.
#[derive(Debug, Clone)]
pub enum Weighting {
    /// 1.
    Unit,
    /// 1/Σⱼ k(qⱼ(xᵢ)), as for balls of equal support.
    Volume,
    /// These.
    Given(Vec<f64>),
}

/// What a field is made from.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// Centres.
    pub positions: Vec<DVec3>,
    /// Supports.
    pub shape: Shape,
    /// Weights.
    pub weights: Weighting,
    /// Kernel.
    pub kernel: Kernel,
    /// Threshold.
    pub threshold: f64,
}

impl Recipe {
    /// The packed field. Looks at all pairs of blobs: for small sets.
    pub fn field(&self) -> BlobField {
        let n = self.positions.len();
        let origin = self.positions.iter().sum::<DVec3>() / n.max(1) as f64;
        let shapes = match &self.shape {
            Shape::Balls(radii) => Shapes::Balls(radii.iter().map(|&r| r as f32).collect()),
            Shape::Ellipsoids(axes) => Shapes::Ellipsoids(axes.iter().map(factor).collect()),
        };
        let weights = match &self.weights {
            Weighting::Unit => vec![1.0; n],
            Weighting::Given(weights) => weights.iter().map(|&w| w as f32).collect(),
            Weighting::Volume => self
                .positions
                .iter()
                .map(|&x| self.volume(&shapes, x))
                .collect(),
        };
        BlobField {
            kernel: self.kernel,
            threshold: self.threshold as f32,
            origin,
            centers: self
                .positions
                .iter()
                .map(|&p| (p - origin).as_vec3().to_array())
                .collect(),
            shapes,
            weights,
            rows: (0..n as u32).collect(),
            motion: None,
            attributes: Vec::new(),
            spacing: spacing(&self.positions) as f32,
            search: Search::default(),
        }
    }

    fn volume(&self, shapes: &Shapes, x: DVec3) -> f32 {
        let sum: f64 = (0..self.positions.len())
            .map(|j| self.kernel.value(shapes.q(j, x - self.positions[j])))
            .sum();
        (1.0 / sum) as f32
    }
}

fn factor(axes: &DMat3) -> Ellipsoid {
    let inverse = axes.inverse();
    Ellipsoid::from_metric(inverse.transpose() * inverse).unwrap_or(Ellipsoid::ball(1.0))
}

/// Median distance of nearest neighbours, 1 where there is none.
fn spacing(positions: &[DVec3]) -> f64 {
    let mut nearest: Vec<f64> = positions
        .iter()
        .enumerate()
        .map(|(i, a)| {
            let others = positions.iter().enumerate().filter(|&(j, _)| j != i);
            others
                .map(|(_, b)| a.distance_squared(*b))
                .fold(f64::INFINITY, f64::min)
                .sqrt()
        })
        .filter(|&d| d > 0.0 && d.is_finite())
        .collect();
    nearest.sort_by(f64::total_cmp);
    nearest.get(nearest.len() / 2).copied().unwrap_or(1.0)
}
