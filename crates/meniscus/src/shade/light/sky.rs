//! The sky: a smooth gradient that lights surfaces, is reflected in them and stands behind them.

use glam::Vec3;

/// Zenith over the mean of the upper half, per component: the sky deepens towards blue.
const ZENITH: Vec3 = Vec3::new(0.74, 0.84, 0.96);
/// Nadir over the mean of the upper half: light that a pale ground throws back.
const NADIR: Vec3 = Vec3::new(0.50, 0.49, 0.48);

/// Sky radiance as a function of the height h = cos of the angle to the zenith.
///
/// From the horizon upwards and downwards it runs to zenith and nadir with weight 1 − (1 − |h|)².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    pub(in crate::shade) horizon: Vec3,
    pub(in crate::shade) zenith: Vec3,
    pub(in crate::shade) nadir: Vec3,
    /// Radiance of a white diffuse surface as a polynomial in h: coefficients of 1, h, h² and h⁴.
    pub(in crate::shade) diffuse: [Vec3; 4],
}

impl Sky {
    /// A sky whose upper half has the mean radiance `mean` (linear Rec. 709).
    pub fn new(mean: [f32; 3]) -> Self {
        let mean = Vec3::from_array(mean);
        // ∫₀¹ 1 − (1 − h)² dh = 2/3 is the zenith's share of the mean.
        let horizon = 3.0 - 2.0 * ZENITH;
        let mut sky = Self {
            horizon: mean * horizon,
            zenith: mean * ZENITH,
            nadir: mean * NADIR,
            diffuse: [Vec3::ZERO; 4],
        };
        sky.diffuse = sky.diffuse_polynomial();
        sky
    }

    /// Radiance from a direction at height `h` in [−1, 1].
    pub fn radiance(&self, h: f32) -> Vec3 {
        let rest = 1.0 - h.abs().min(1.0);
        let end = if h >= 0.0 { self.zenith } else { self.nadir };
        self.horizon.lerp(end, 1.0 - rest * rest)
    }

    /// Radiance of a white diffuse surface (irradiance over π) whose normal has height `h`, if
    /// nothing blocks the sky.
    pub fn diffuse(&self, h: f32) -> Vec3 {
        let [a, b, c, d] = self.diffuse;
        (a + (b + (c + d * (h * h)) * h) * h).max(Vec3::ZERO)
    }

    /// The zonal harmonics 0, 1, 2 and 4 of the sky, convolved with the cosine (Ramamoorthi and
    /// Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001, eq. 8): factors
    /// 1, 2/3, 1/4 and −1/24, all other odd ones zero; as a polynomial in h.
    fn diffuse_polynomial(&self) -> [Vec3; 4] {
        const STEPS: u32 = 2000;
        let mut moments = [Vec3::ZERO; 4];
        for step in 0..STEPS {
            let h = (step as f32 + 0.5) * 2.0 / STEPS as f32 - 1.0;
            let light = self.radiance(h) * (2.0 / STEPS as f32);
            moments[0] += light * 0.5;
            moments[1] += light * (1.5 * h);
            let square = h * h;
            moments[2] += light * (2.5 * (1.5 * square - 0.5));
            moments[3] += light * (4.5 / 8.0 * ((35.0 * square - 30.0) * square + 3.0));
        }
        let [l0, l1, l2, l4] = [
            moments[0],
            moments[1] * (2.0 / 3.0),
            moments[2] * 0.25,
            moments[3] * (-1.0 / 24.0 / 8.0),
        ];
        [
            l0 - l2 * 0.5 + l4 * 3.0,
            l1,
            l2 * 1.5 - l4 * 30.0,
            l4 * 35.0,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_half_has_the_mean_asked_for() {
        let mean = Vec3::new(0.6, 0.7, 0.8);
        let sky = Sky::new(mean.to_array());
        let sum: Vec3 = (0..1000)
            .map(|i| sky.radiance((i as f32 + 0.5) / 1000.0))
            .sum();
        assert!((sum / 1000.0 - mean).abs().max_element() < 1e-3);
    }

    #[test]
    fn diffuse_light_is_the_cosine_integral_of_the_sky() {
        let sky = Sky::new([0.6, 0.7, 0.8]);
        for normal_height in [-1.0_f32, -0.6, 0.0, 0.3, 0.8, 1.0] {
            let tilt = (1.0 - normal_height * normal_height).sqrt();
            let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
            for i in 0..400 {
                for j in 0..400 {
                    let h = (i as f32 + 0.5) / 200.0 - 1.0;
                    let angle = (j as f32 + 0.5) / 400.0 * std::f32::consts::TAU;
                    let cosine = h * normal_height + (1.0 - h * h).sqrt() * tilt * angle.cos();
                    if cosine > 0.0 {
                        sum += sky.radiance(h) * cosine;
                        weight += cosine;
                    }
                }
            }
            let exact = sum / weight;
            let fitted = sky.diffuse(normal_height);
            assert!(
                ((fitted - exact) / exact).abs().max_element() < 0.02,
                "{normal_height}: {fitted} for {exact}"
            );
        }
    }
}
