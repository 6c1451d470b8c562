//! Dense marching with interval bounds: a slow second opinion on the oracle itself.
//!
//! It knows no polynomial and no event: a step is accepted only where bounds of every blob's
//! contribution over the step decide the sign of F − T, else it is halved.

use glam::DVec3;
use meniscus::field::BlobField;
use meniscus::math::ray::Ray;

/// A stretch of a ray, in its own parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// Whether F > T, where that is proven; `None` where the stretch was too short to decide.
    pub above: Option<bool>,
}

/// The signs of F − T along `[t_min, t_max]` of a ray (both finite); stretches shorter than `finest`
/// stay undecided. Neighbours with the same sign are joined.
pub fn signs(field: &BlobField, ray: &Ray, finest: f64) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    let mut open = vec![(ray.t_min, ray.t_max)];
    while let Some((from, to)) = open.pop() {
        let (least, most) = bounds(field, ray, from, to);
        let threshold = f64::from(field.threshold);
        let above = if most < threshold {
            Some(false)
        } else if least > threshold {
            Some(true)
        } else if to - from < finest {
            None
        } else {
            let middle = 0.5 * (from + to);
            open.extend([(middle, to), (from, middle)]);
            continue;
        };
        match found.last_mut() {
            Some(last) if last.above == above => last.to = to,
            _ => found.push(Stretch { from, to, above }),
        }
    }
    found
}

/// Bounds of F over a stretch: the unit-sphere distance of each blob changes by at most |A·Δx|.
fn bounds(field: &BlobField, ray: &Ray, from: f64, to: f64) -> (f64, f64) {
    let x = ray.at(0.5 * (from + to)) - field.origin;
    let reach: DVec3 = ray.direction * (0.5 * (to - from));
    let (mut least, mut most) = (0.0, 0.0);
    for i in 0..field.len() {
        let y = field
            .shapes
            .transform(i, x - field.center(i).as_dvec3())
            .length();
        let e = field.shapes.transform(i, reach).length();
        let near = field.kernel.value((y - e).max(0.0).powi(2));
        let far = field.kernel.value((y + e).powi(2));
        let w = f64::from(field.weights[i]);
        // `Kernel::value` keeps its constants in f32.
        let rounding = 1e-7 * w.abs() * near;
        least += w * if w > 0.0 { far } else { near } - rounding;
        most += w * if w > 0.0 { near } else { far } + rounding;
    }
    (least, most)
}
