//! Specular antialiasing: highlights as wide as the normals differ within what one sample stands for,
//! in space (Kaplanyan et al., "Filtering Distributions of Normals for Shading Antialiasing", 2016;
//! Tokuyoshi & Kaplanyan, "Improved Geometric Specular Antialiasing", 2019) and in time (Tessari et al.,
//! "Distribution of normals over time", as used in Ray Tracing Gems II, §35.5).

use super::ShadeSettings;
use crate::math::level_set::HitChange;
use glam::DVec3;

/// Variance, in square pixels, of the pixel filter
/// ([`PixelFilter`](crate::math::sampling::PixelFilter)) along x or y: a highlight is as wide as the
/// filter makes it. Tokuyoshi & Kaplanyan (2019) take 1/2π, for a filter twice as broad.
pub(super) const PIXEL_VARIANCE: f64 = 0.0767;
/// Variance of a time within a shutter of length 1.
const SHUTTER_VARIANCE: f64 = 1.0 / 12.0;
/// Most that is added to a squared width: normals that differ more are no longer told apart by slopes
/// (κ of Tokuyoshi & Kaplanyan 2019).
const MOST_ADDED: f64 = 0.18;
/// Standard deviations that a sample's share of the pixel reaches. Where the surface turns edge-on within
/// them, its silhouette is near: beyond it nothing is seen, and on this side the surface bends away from
/// what the first order says, which makes normals of it that face lights behind the viewer. So the
/// spread fades with the square of the turn over the distance from the silhouette.
const REACH: f64 = 4.0;

/// What one sample stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpecularFilter {
    /// Variances of the film's x and y, in square pixels, and of time, in square seconds.
    variances: [f64; 3],
}

/// How the normals at a hit are spread within one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NormalSpread {
    /// Two tangents along which the spread is least and largest; with the normal a right-handed frame.
    pub(super) tangents: [DVec3; 2],
    /// What is added to the squares of GGX widths along them.
    pub(super) added: [f64; 2],
}

impl SpecularFilter {
    /// `None` where the settings do not ask for it. A pixel's samples share its area and the time that
    /// the shutter is open, so what the filter changes vanishes as they become more.
    pub(super) fn new(settings: &ShadeSettings) -> Option<Self> {
        let samples = f64::from(settings.spp.max(1));
        let [open, close] = settings.shutter_secs;
        let shutter = close - open;
        settings.integrator.specular_antialiasing.then(|| Self {
            variances: [
                PIXEL_VARIANCE / samples,
                PIXEL_VARIANCE / samples,
                SHUTTER_VARIANCE * shutter * shutter / samples,
            ],
        })
    }

    /// Variances of the film's x or y, in square pixels, and of time, in square seconds.
    pub(super) fn of_pixel_and_time(&self) -> [f64; 2] {
        let [pixel, _, time] = self.variances;
        [pixel, time]
    }

    /// The spread of normals around `normal`, seen along `direction`, for hits that change like this;
    /// `None` where they are alike. The slopes' covariance counts twice in squared widths (Kaplanyan et
    /// al. 2016, eq. 14).
    pub(super) fn spread(
        &self,
        normal: DVec3,
        [x, y]: [DVec3; 2],
        direction: DVec3,
        hits: &[HitChange; 3],
    ) -> Option<NormalSpread> {
        let facing = normal.dot(direction).abs();
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (variance, hit) in self.variances.iter().zip(hits) {
            let turn = hit.normal * variance.sqrt();
            let reach = REACH * turn.dot(direction) / facing;
            let turn = turn / (1.0 + reach * reach);
            let (a, b) = (turn.dot(x), turn.dot(y));
            xx += 2.0 * a * a;
            xy += 2.0 * a * b;
            yy += 2.0 * b * b;
        }
        let total = xx + yy;
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        // Half the difference of the eigenvalues, and the direction of the larger one.
        let half = (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt();
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = angle.sin_cos();
        let wide = x * cos + y * sin;
        Some(NormalSpread {
            tangents: [wide.cross(normal), wide],
            added: [0.5 * total - half, 0.5 * total + half].map(|a| a.clamp(0.0, MOST_ADDED)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sampling::tangents;
    use crate::scene::IntegratorSettings;

    fn filter(spp: u32, shutter_secs: f64) -> SpecularFilter {
        let settings = ShadeSettings {
            integrator: IntegratorSettings {
                specular_antialiasing: true,
                ..IntegratorSettings::default()
            },
            spp,
            shutter_secs: [0.0, shutter_secs],
            ..ShadeSettings::default()
        };
        SpecularFilter::new(&settings).unwrap()
    }

    fn turning(normals: [DVec3; 3]) -> [HitChange; 3] {
        normals.map(|normal| HitChange {
            position: DVec3::ZERO,
            normal,
        })
    }

    #[test]
    fn the_variance_is_that_of_the_pixel_filter() {
        let filter = crate::math::sampling::PixelFilter::default();
        let squares = (0..10_000).map(|i| {
            let [x, _] = filter.offset([(f64::from(i) + 0.5) / 1e4, 0.5]);
            x * x
        });
        let variance = squares.sum::<f64>() / 1e4;
        assert!((variance - PIXEL_VARIANCE).abs() < 3e-4, "{variance}");
    }

    #[test]
    fn spread_lies_along_the_turning_of_normals_and_shrinks_with_samples() {
        let normal = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        let frame = tangents(normal);
        let ahead = -normal;
        let along = (frame[0] * 0.6 + frame[1] * 0.8) * 0.2;
        let nothing = DVec3::ZERO;
        let spread =
            |spp: u32, shutter: f64, hits| filter(spp, shutter).spread(normal, frame, ahead, &hits);
        let space = spread(4, 0.0, turning([along, nothing, nothing])).unwrap();
        assert!(space.tangents[1].dot(along.normalize()).abs() > 1.0 - 1e-12);
        let [x, y] = space.tangents;
        assert!(x.cross(y).distance(normal) < 1e-12);
        let expected = 2.0 * PIXEL_VARIANCE / 4.0 * 0.04;
        assert!(space.added[0].abs() < 1e-15 && (space.added[1] - expected).abs() < 1e-15);
        // Time counts with the shutter, and alone.
        assert_eq!(spread(1, 0.0, turning([nothing, nothing, along])), None);
        let time = spread(1, 0.5, turning([nothing, nothing, along])).unwrap();
        assert!((time.added[1] - 2.0 * 0.25 / 12.0 * 0.04).abs() < 1e-15);
        let all = spread(1, 0.5, turning([along, x * 9.0, y * 900.0])).unwrap();
        assert!(all.added.iter().all(|&added| added <= MOST_ADDED));
        assert_eq!(SpecularFilter::new(&ShadeSettings::default()), None);
    }

    #[test]
    fn spread_fades_towards_silhouettes_and_not_along_them() {
        let frame = [DVec3::X, DVec3::Y];
        let filter = filter(1, 0.0);
        let sigma = PIXEL_VARIANCE.sqrt();
        let (cosine, turn) = (0.1_f64, 0.3);
        let direction = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, -cosine);
        let added = |along: DVec3| {
            let hits = turning([along * turn, DVec3::ZERO, DVec3::ZERO]);
            let spread = filter.spread(DVec3::Z, frame, direction, &hits);
            spread.unwrap().added[1]
        };
        let whole = 2.0 * (sigma * turn).powi(2);
        assert!((added(DVec3::Y) - whole).abs() < 1e-15);
        let reach = 4.0 * sigma * turn * direction.x / cosine;
        let left = (1.0 + reach * reach).recip();
        assert!(left < 0.1 && (added(DVec3::X) - whole * left * left).abs() < 1e-15);
        // Edge-on nothing is left.
        let hits = turning([DVec3::X, DVec3::ZERO, DVec3::ZERO]);
        assert_eq!(filter.spread(DVec3::Z, frame, DVec3::X, &hits), None);
    }
}
