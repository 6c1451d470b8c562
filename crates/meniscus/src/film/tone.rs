//! From linear light to what a screen shows.

use super::white::WhitePoint;

/// How light becomes the colours of a PNG picture; EXR files stay linear and untouched.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tone {
    /// The curve of each component.
    pub curve: Curve,
    /// Exposure in stops: light is multiplied by 2^exposure first.
    pub exposure: f32,
    /// What counts as white.
    pub white: WhitePoint,
}

/// A tone curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Curve {
    /// [`filmic`].
    #[default]
    Filmic,
    /// Clipping at 1.
    Linear,
}

impl Tone {
    /// Display light in 0–1 of scene-linear light.
    pub fn display(self, light: [f32; 3]) -> [f32; 3] {
        let exposed = self.white.balanced(light).map(|x| x * self.exposure.exp2());
        match self.curve {
            Curve::Filmic => exposed.map(filmic),
            Curve::Linear => exposed.map(|x| x.clamp(0.0, 1.0)),
        }
    }
}

/// The filmic curve of H. Uchimura, "HDR Theory and Practice", CEDEC 2017: a toe, a linear middle
/// of slope 1 that leaves the colours of materials and colour maps as they are, and a shoulder that
/// rolls highlights off to white. Peak 1, contrast 1, linear part from 0.22 over 0.4 of the rest,
/// toe exponent 1.33, no pedestal.
///
/// Takes any light, NaN and negative light become 0; the answer lies in 0–1 and never falls.
pub fn filmic(light: f32) -> f32 {
    const START: f32 = 0.22;
    const LENGTH: f32 = (1.0 - START) * 0.4;
    const SHOULDER: f32 = START + LENGTH;
    const TOE: f32 = 1.33;
    let x = light.max(0.0);
    let toe = START * (x / START).powf(TOE);
    let shoulder = 1.0 - (1.0 - SHOULDER) * (-(x - SHOULDER) / (1.0 - SHOULDER)).exp();
    let smooth = (x / START).min(1.0);
    let toe_share = 1.0 - smooth * smooth * (3.0 - 2.0 * smooth);
    if x < SHOULDER {
        toe * toe_share + x * (1.0 - toe_share)
    } else {
        shoulder
    }
}

/// The sRGB transfer function (IEC 61966-2-1): encoded 0–1 of linear 0–1; clips.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::color::linear_from_srgb;

    #[test]
    fn the_filmic_curve_rises_without_steps() {
        let mut last = filmic(0.0);
        assert_eq!(last, 0.0);
        for i in 1..40_000 {
            let x = i as f32 * 1e-3;
            let y = filmic(x);
            assert!(y >= last && y <= 1.0, "falls at {x}");
            assert!(y - last < 2.1e-3, "steps at {x}: {last} to {y}");
            last = y;
        }
        // The middle is linear light, unchanged.
        assert!((filmic(0.4) - 0.4).abs() < 1e-6);
        assert_eq!(filmic(f32::INFINITY), 1.0);
        assert_eq!(filmic(f32::NAN), 0.0);
        assert_eq!(filmic(-3.0), 0.0);
    }

    #[test]
    fn srgb_follows_the_standard_and_turns_back() {
        // IEC 61966-2-1: linear 0.214 is the encoded middle.
        assert!((srgb_from_linear(0.214_041_1) - 0.5).abs() < 1e-5);
        for i in 0..=255 {
            let encoded = f64::from(i) / 255.0;
            let back = srgb_from_linear(linear_from_srgb(encoded) as f32);
            assert!((f64::from(back) - encoded).abs() < 1e-5);
        }
    }
}
