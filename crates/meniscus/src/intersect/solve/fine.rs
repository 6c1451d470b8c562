//! Blobs too small for f32 in their leaf.

use super::local::LocalRay;
use crate::field::BlobField;

/// By how much f32 may see a blob at the limit of what it resolves wider than it is, in its support.
const ROUNDING: f64 = 2e-5;

/// Whether the ray meets blob `i` (as f32 may see it), and it is so small that its steepness along the
/// ray (β, 1/length²) is at least `fine_beta`.
pub(in crate::intersect) fn meets_fine_blob(
    field: &BlobField,
    i: usize,
    fine_beta: f32,
    ray: &LocalRay,
) -> bool {
    let at = field.at(ray.time_secs);
    let v = at.transform(i, ray.direction);
    let beta = v.length_squared();
    let steepness = (beta / f64::from(fine_beta)).sqrt();
    if steepness < 1.0 {
        return false;
    }
    let y = at.transform(i, ray.origin - at.center(i));
    let nearest = (-y.dot(v) / beta).max(0.0);
    (y + v * nearest).length() < 1.0 + ROUNDING * steepness
}
