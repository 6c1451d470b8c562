//! A thin clear sheet with parallel faces, as a window or the wall of a bubble: light goes straight on
//! through it. What is thrown back and forth between its faces is summed (Stokes, "On the intensity of
//! the light reflected from or transmitted through a pile of plates", Proc. R. Soc. 11, 1862). Thin
//! against what surrounds it and thick against the wavelength: no shift and no colours of interference.

use super::fresnel::dielectric;
use super::{BsdfSample, Scattering, luminance, mirrored};
use glam::{DVec3, Vec3};

/// A sheet under one angle.
#[derive(Debug, Clone, Copy)]
pub(in crate::shade) struct Sheet {
    reflected: Vec3,
    transmitted: Vec3,
}

impl Sheet {
    /// `cosine` is that of the light's angle, `eta` the index around the sheet over its own, `depth`
    /// the optical depth of its thickness, by colour.
    pub(in crate::shade) fn new(cosine: f64, eta: f64, depth: Vec3) -> Self {
        let (face, other) = dielectric(cosine.clamp(0.0, 1.0), eta);
        let Some(other) = other.filter(|&other| face < 1.0 && other > 0.0) else {
            return Self {
                reflected: Vec3::ONE,
                transmitted: Vec3::ZERO,
            };
        };
        let of_color = |depth: f32| {
            let once = (-f64::from(depth) / other).exp();
            let transmitted = (1.0 - face).powi(2) * once / (1.0 - (face * once).powi(2));
            (face * (1.0 + once * transmitted), transmitted)
        };
        let [red, green, blue] = depth.to_array().map(of_color);
        let vector = |colors: [f64; 3]| Vec3::from_array(colors.map(|c| c as f32));
        Self {
            reflected: vector([red.0, green.0, blue.0]),
            transmitted: vector([red.1, green.1, blue.1]),
        }
    }

    /// Part of the light that is mirrored.
    pub(in crate::shade) fn reflected(&self) -> Vec3 {
        self.reflected
    }

    /// Part of the light that goes through.
    pub(in crate::shade) fn transmitted(&self) -> Vec3 {
        self.transmitted
    }

    /// The way straight through, taken for certain.
    pub(in crate::shade) fn through(&self, view: DVec3) -> BsdfSample {
        BsdfSample::only(-view, self.transmitted, Scattering::Refraction)
    }

    /// One of both ways.
    pub(in crate::shade) fn sample(&self, view: DVec3, choice: f64) -> BsdfSample {
        let [reflected, transmitted] = [self.reflected, self.transmitted].map(luminance);
        let part = reflected / (reflected + transmitted);
        if choice < part {
            let weight = self.reflected / part as f32;
            return BsdfSample::only(mirrored(view), weight, Scattering::Reflection);
        }
        let through = self.through(view);
        BsdfSample {
            weight: through.weight / (1.0 - part) as f32,
            ..through
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_sum_what_their_faces_throw_back_and_forth() {
        let (ior, depth) = (1.517_f64, 0.3_f32);
        for cosine in [1.0, 0.7, 0.2] {
            let sheet = Sheet::new(cosine, 1.0 / ior, Vec3::new(0.0, depth, 40.0));
            let (face, other) = dielectric(cosine, 1.0 / ior);
            let once = (-f64::from(depth) / other.unwrap()).exp();
            // Term by term.
            let (mut reflected, mut transmitted) = (face, 0.0);
            let mut inside = 1.0 - face;
            for bounce in 0..200 {
                inside *= once;
                let out = inside * (1.0 - face);
                if bounce % 2 == 0 {
                    transmitted += out;
                } else {
                    reflected += out;
                }
                inside *= face;
            }
            assert!((f64::from(sheet.reflected.y) - reflected).abs() < 1e-6);
            assert!((f64::from(sheet.transmitted.y) - transmitted).abs() < 1e-6);
            // What is not absorbed is not lost; what is black inside reflects by its first face.
            assert!((sheet.reflected.x + sheet.transmitted.x - 1.0).abs() < 1e-6);
            assert!((f64::from(sheet.reflected.z) - face).abs() < 1e-6);
            assert!(sheet.transmitted.z < 1e-6);
        }
    }

    #[test]
    fn a_sheet_of_air_in_glass_reflects_everything_beyond_the_critical_angle() {
        let total = Sheet::new(0.3, 1.5, Vec3::ZERO);
        assert_eq!(
            (total.reflected, total.transmitted),
            (Vec3::ONE, Vec3::ZERO)
        );
        let sample = total.sample(DVec3::Z, 0.999_999);
        assert_eq!(sample.scattering, Scattering::Reflection);
        let grazing = Sheet::new(0.0, 1.0 / 1.5, Vec3::ZERO);
        assert_eq!(grazing.transmitted, Vec3::ZERO);
        let none = Sheet::new(0.5, 1.0, Vec3::ZERO);
        assert!((none.transmitted - Vec3::ONE).length() < 1e-6);
    }
}
