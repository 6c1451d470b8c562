//! From columns to ellipsoids.

use super::{Axes, Radii, fits};
use crate::math::symmetric::eigen;
use crate::particles::Several;
use crate::primitive::Ellipsoid;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

/// Axes of what is not stated as an ellipsoid are no shorter than this part of the longest.
const LEAST_RATIO: f64 = 0.1;
/// Longest axis that a deformation gradient may make of the unit ball, and the inverse of the shortest:
/// f32 has to hold the product with any radius.
const LARGEST_STRETCH: f64 = 1e6;
/// Particles that one task handles at least.
const PARALLEL: usize = 1 << 12;

/// Ellipsoids of particles.
pub(super) struct Ellipsoids {
    /// Upper-triangular factors A of their metrics; `None` where there is no ellipsoid.
    pub(super) factors: Vec<Option<[f64; 6]>>,
    /// The particles among them whose axes were lengthened.
    pub(super) lengthened: Vec<u32>,
}

impl Ellipsoids {
    pub(super) fn exact(factors: Vec<Option<[f64; 6]>>) -> Self {
        Self {
            factors,
            lengthened: Vec::new(),
        }
    }

    /// Those that the unit ball becomes under matrices L, of which LLᵀ is given for each of `rows`.
    fn limited(rows: &[u32], square: impl Fn(usize) -> DMat3 + Sync) -> Self {
        let limited: Vec<_> = rows
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|&row| limited(square(row as usize)))
            .collect();
        let lengthened = rows.iter().zip(&limited);
        Self {
            lengthened: lengthened
                .filter(|(_, limited)| limited.is_some_and(|(_, lengthened)| lengthened))
                .map(|(row, _)| *row)
                .collect(),
            factors: limited
                .into_iter()
                .map(|limited| limited.map(|(factor, _)| factor))
                .collect(),
        }
    }
}

/// The factor for LLᵀ, and whether axes had to be lengthened. Eigenvalues that are not positive count as
/// 0, unless all are.
fn limited(square: DMat3) -> Option<([f64; 6], bool)> {
    if !square.is_finite() {
        return None;
    }
    let (values, axes) = eigen(square);
    let radii = DVec3::from_array(values.to_array().map(|value| value.max(0.0).sqrt()));
    let longest = radii.max_element();
    if !(longest > 0.0 && longest.is_finite()) {
        return None;
    }
    let least = longest * LEAST_RATIO;
    let kept = radii.max(DVec3::splat(least));
    let inverse = kept.recip();
    let scaled = DMat3::from_cols(
        axes.x_axis * (inverse.x * inverse.x),
        axes.y_axis * (inverse.y * inverse.y),
        axes.z_axis * (inverse.z * inverse.z),
    );
    let factor = Ellipsoid::factor_of(scaled * axes.transpose()).ok()?;
    fits(factor).then_some((factor, radii.min_element() < least))
}

/// The image of the unit ball under the deformation gradients F in `column`.
pub(super) fn deformed(column: &Several<'_>, rows: &[u32]) -> Ellipsoids {
    Ellipsoids::limited(rows, |row| {
        // Row by row is column by column of the transposed.
        let f = DMat3::from_cols_array(&column.get(row)).transpose();
        let size = f
            .x_axis
            .length()
            .max(f.y_axis.length())
            .max(f.z_axis.length());
        if (1.0 / LARGEST_STRETCH..=LARGEST_STRETCH).contains(&size) {
            f * f.transpose()
        } else {
            DMat3::NAN
        }
    })
}

/// The ellipsoids xᵀU⁻¹x = `radius`² of the displacements U₁₁ U₂₂ U₃₃ U₁₂ U₁₃ U₂₃ in `column`.
pub(super) fn thermal(column: &Several<'_>, rows: &[u32], radius: f64) -> Ellipsoids {
    Ellipsoids::limited(rows, |row| {
        let [xx, yy, zz, xy, xz, yz] = column.get(row);
        DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]) * (radius * radius)
    })
}

impl Radii<'_> {
    /// The ellipsoids of `rows`, `scale` times as large.
    pub(super) fn ellipsoids(&self, rows: &[u32], scale: f64) -> Ellipsoids {
        let factors = rows.par_iter().with_min_len(PARALLEL).map(|&row| {
            let radii = self.conjugate_radii(row as usize)? * scale;
            let factor = Ellipsoid::factor_of_radii(radii).ok()?;
            fits(factor).then_some(factor)
        });
        Ellipsoids::exact(factors.collect())
    }

    /// The vectors from an ellipsoid's middle to the ends of its axes, as columns.
    fn conjugate_radii(&self, row: usize) -> Option<DMat3> {
        let directions = match &self.axes {
            Axes::Space => DMat3::IDENTITY,
            Axes::Vectors(vectors) => DMat3::from_cols_array(&vectors.get(row)),
            Axes::Turned(turns) => {
                let turn = DQuat::from_array(turns.get(row));
                let length = turn.length();
                if !(length > 0.0 && length.is_finite()) {
                    return None;
                }
                DMat3::from_quat(turn / length)
            }
        };
        let Some(radii) = &self.radii else {
            return Some(directions);
        };
        let radii: [f64; 3] = radii.get(row);
        if !radii.iter().all(|radius| *radius > 0.0) {
            return None;
        }
        let along = |axis: DVec3, radius: f64| Some(axis.try_normalize()? * radius);
        Some(DMat3::from_cols(
            along(directions.x_axis, radii[0])?,
            along(directions.y_axis, radii[1])?,
            along(directions.z_axis, radii[2])?,
        ))
    }
}

/// The radius within which a point that is spread normally in space, with variance 1 along each axis,
/// lies with this probability: that of ORTEP's ellipsoids, 1.5382 for one half.
pub(super) fn radius_of_probability(probability: f64) -> f64 {
    // Beyond it lies less than f64 can tell from nothing.
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if probability_within(middle) < probability {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// √(2/π) ∫ t² exp(−t²/2) dt from 0 to `radius`: exp(−r²/2) √(2/π) Σ r²ᵏ⁺³/(3·5···(2k+3)).
fn probability_within(radius: f64) -> f64 {
    let square = radius * radius;
    let (mut term, mut sum, mut odd) = (radius * square / 3.0, 0.0, 3.0);
    while term > sum * f64::EPSILON * 0.1 {
        sum += term;
        odd += 2.0;
        term *= square / odd;
    }
    (2.0 / std::f64::consts::PI).sqrt() * (-0.5 * square).exp() * sum
}
