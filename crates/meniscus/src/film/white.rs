//! White balance: light of a stated colour is shown as white.

use crate::scene::WhiteBalance;
use glam::{DMat3, DVec3};

/// XYZ of linear Rec. 709 (ITU-R BT.709, white D65), column by column.
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_8, 0.212_639, 0.019_330_8),
    DVec3::new(0.357_584_3, 0.715_168_7, 0.119_194_8),
    DVec3::new(0.180_480_8, 0.072_192_3, 0.950_532_2),
);
/// Cone responses of XYZ after Bradford (Lam 1985), column by column.
const CONES_FROM_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// The change of linear colours that shows a certain light as white: that of the screen without one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WhitePoint(Option<DMat3>);

impl WhitePoint {
    /// Shows light of this colour as white (Bradford's chromatic adaptation to D65).
    pub fn new(balance: WhiteBalance) -> Self {
        let light = match balance {
            WhiteBalance::Kelvin(kelvin) => {
                let [x, y] = chromaticity(kelvin);
                DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
            }
            WhiteBalance::Color(color) => {
                let xyz = XYZ_FROM_RGB * DVec3::from_array(color.0);
                xyz / xyz.y
            }
        };
        let cones_from_rgb = CONES_FROM_XYZ * XYZ_FROM_RGB;
        let gain = (cones_from_rgb * DVec3::ONE) / (CONES_FROM_XYZ * light);
        let adapted = cones_from_rgb.inverse() * DMat3::from_diagonal(gain) * cones_from_rgb;
        Self(adapted.is_finite().then_some(adapted))
    }

    /// A linear colour in that light.
    pub fn balanced(&self, light: [f32; 3]) -> [f32; 3] {
        match &self.0 {
            None => light,
            Some(adapted) => {
                let light = DVec3::from_array(light.map(f64::from));
                (*adapted * light).to_array().map(|c| c as f32)
            }
        }
    }
}

/// CIE 1931 chromaticity of a colour temperature: daylight from 5000 K up (CIE 15:2004, §3.1), a black
/// body to 4000 K (Kim et al., US patent 7024034, 2006), evenly from one to the other between.
fn chromaticity(kelvin: f64) -> [f64; 2] {
    let t = 1000.0 / kelvin;
    let body_x = ((-0.266_123_9 * t - 0.234_358_9) * t + 0.877_695_6) * t + 0.179_910;
    let body_y = if kelvin < 2222.0 {
        ((-1.106_381_4 * body_x - 1.348_110_20) * body_x + 2.185_558_32) * body_x - 0.202_196_83
    } else {
        ((-0.954_947_6 * body_x - 1.374_185_93) * body_x + 2.091_370_15) * body_x - 0.167_488_67
    };
    let day_x = if kelvin <= 7000.0 {
        ((-4.6070 * t + 2.9678) * t + 0.099_11) * t + 0.244_063
    } else {
        ((-2.0064 * t + 1.9018) * t + 0.247_48) * t + 0.237_040
    };
    let day_y = (-3.0 * day_x + 2.87) * day_x - 0.275;
    let day = ((kelvin - 4000.0) / 1000.0).clamp(0.0, 1.0);
    [
        body_x + (day_x - body_x) * day,
        body_y + (day_y - body_y) * day,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Color;

    #[test]
    fn known_illuminants_have_their_chromaticities() {
        // A (2856 K), D50 (5003 K), D65 (6504 K), D75 (7504 K).
        for (kelvin, x, y) in [
            (2856.0, 0.4476, 0.4074),
            (5003.0, 0.3457, 0.3585),
            (6504.0, 0.3127, 0.3290),
            (7504.0, 0.2990, 0.3149),
        ] {
            let found = chromaticity(kelvin);
            assert!(
                (found[0] - x).abs() < 1e-3 && (found[1] - y).abs() < 1e-3,
                "{kelvin}: {found:?}"
            );
        }
        for kelvin in 1667..25_000 {
            let [a, b] = [kelvin, kelvin + 1].map(|k| chromaticity(f64::from(k)));
            assert!(
                (a[0] - b[0]).abs() < 1e-3 && (a[1] - b[1]).abs() < 1e-3,
                "{kelvin}"
            );
        }
    }

    #[test]
    fn the_light_that_is_named_turns_white_and_keeps_its_brightness() {
        let tint = [1.3, 0.9, 0.5];
        let white = WhitePoint::new(WhiteBalance::Color(Color(tint.map(f64::from))));
        let [r, g, b] = white.balanced(tint);
        assert!((r - g).abs() < 1e-5 && (g - b).abs() < 1e-5, "{r} {g} {b}");
        let luminance = 0.2126 * tint[0] + 0.7152 * tint[1] + 0.0722 * tint[2];
        assert!((g - luminance).abs() < 1e-3, "{g} for {luminance}");
        // D65 changes nothing; lamp light as white makes daylight blue.
        let day = WhitePoint::new(WhiteBalance::Kelvin(6504.0)).balanced([1.0; 3]);
        assert!(day.iter().all(|c| (c - 1.0).abs() < 5e-3), "{day:?}");
        let [r, g, b] = WhitePoint::new(WhiteBalance::Kelvin(3000.0)).balanced([1.0; 3]);
        assert!(r < g && g < b, "{r} {g} {b}");
        assert_eq!(WhitePoint::default().balanced(tint), tint);
    }
}
