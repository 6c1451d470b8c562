//! How much light a boundary reflects.

use glam::Vec3;

/// Reflectance of unpolarised light at the boundary of two dielectrics (Fresnel): `cosine` ≥ 0 on the
/// side of the light, `eta` the index on that side over that on the other. And the cosine on the
/// other side: `None` where all light is reflected.
pub(in crate::shade) fn dielectric(cosine: f64, eta: f64) -> (f64, Option<f64>) {
    let sine_squared = eta * eta * (1.0 - cosine * cosine);
    if sine_squared >= 1.0 && eta > 1.0 {
        return (1.0, None);
    }
    let other = (1.0 - sine_squared).max(0.0).sqrt();
    let parallel = (cosine - eta * other) / (cosine + eta * other);
    let perpendicular = (eta * cosine - other) / (eta * cosine + other);
    if !(parallel.is_finite() && perpendicular.is_finite()) {
        // Grazing light on a boundary of equal indices.
        return (0.0, Some(other));
    }
    let reflectance = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    (reflectance, Some(other))
}

/// Reflectance of a metal whose reflectance head on is `head_on` (Schlick 1994).
pub(super) fn schlick(head_on: Vec3, cosine: f64) -> Vec3 {
    let x = (1.0 - cosine).clamp(0.0, 1.0) as f32;
    let x2 = x * x;
    head_on + (Vec3::ONE - head_on) * (x2 * x2 * x)
}

/// The mean of [`schlick`] over all cosines, weighted by the cosine.
pub(super) fn schlick_mean(head_on: Vec3) -> Vec3 {
    (head_on * 20.0 + Vec3::ONE) / 21.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dielectrics_follow_known_values() {
        // Head on: ((n − 1)/(n + 1))².
        let (water, cosine) = dielectric(1.0, 1.0 / 1.333);
        assert!((water - (0.333_f64 / 2.333).powi(2)).abs() < 1e-12);
        assert!((cosine.unwrap() - 1.0).abs() < 1e-12);
        // Brewster's angle: no parallel part, half of ((n² − 1)/(n² + 1))² is left.
        let n: f64 = 1.5;
        let brewster = (1.0 / (1.0 + n * n)).sqrt();
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        assert!((dielectric(brewster, 1.0 / n).0 - expected).abs() < 1e-12);
        // Total reflection begins where sin θ = 1/n.
        let critical = (1.0 - 1.0 / (n * n)).sqrt();
        assert_eq!(dielectric(critical * 0.999, n), (1.0, None));
        assert!(dielectric(critical * 1.001, n).0 < 1.0);
        // The way back is the same.
        let (there, cosine) = dielectric(0.3, 1.0 / n);
        let (back, again) = dielectric(cosine.unwrap(), n);
        assert!((there - back).abs() < 1e-12 && (again.unwrap() - 0.3).abs() < 1e-12);
        assert!(dielectric(0.3, 1.0).0 < 1e-12);
        assert_eq!(dielectric(0.0, 1.0).0, 0.0);
    }

    #[test]
    fn the_mean_of_schlick_is_its_integral() {
        let head_on = Vec3::new(0.0, 0.5, 1.0);
        let steps = 10_000;
        let sum: Vec3 = (0..steps)
            .map(|i| {
                let cosine = (f64::from(i) + 0.5) / f64::from(steps);
                schlick(head_on, cosine) * (2.0 * cosine) as f32
            })
            .sum();
        assert!((sum / steps as f32 - schlick_mean(head_on)).length() < 1e-3);
    }
}
