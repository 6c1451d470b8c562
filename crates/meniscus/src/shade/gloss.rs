//! The coat on a diffuse base: a dielectric microfacet highlight and its Fresnel reflectance.

use glam::Vec3;
use std::f32::consts::PI;

/// Reflectance of a dielectric of index 1.5 seen head on.
const HEAD_ON: f32 = 0.04;

/// A coat of a certain strength and roughness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gloss {
    /// Reflectance head on.
    pub(super) head_on: f32,
    /// Reflectance at grazing angles: rough coats reflect less there.
    pub(super) grazing: f32,
    /// GGX width, roughness².
    pub(super) width: f32,
}

impl Gloss {
    /// `specular` in [0, 1] scales the reflectance of index 1.5; `None` where that is nothing.
    pub(super) fn new(specular: f32, roughness: f32) -> Option<Self> {
        let specular = specular.clamp(0.0, 1.0);
        let roughness = roughness.clamp(0.0, 1.0);
        (specular > 0.0).then(|| Self {
            head_on: HEAD_ON * specular,
            grazing: (1.0 - roughness).powi(3).max(HEAD_ON) * specular,
            width: (roughness * roughness).max(1e-3),
        })
    }

    /// Fresnel reflectance at the cosine of the angle between view and facet (Schlick 1994).
    pub(super) fn reflectance(&self, cosine: f32) -> f32 {
        let x = (1.0 - cosine).clamp(0.0, 1.0);
        let x2 = x * x;
        self.head_on + (self.grazing - self.head_on) * x2 * x2 * x
    }

    /// BRDF times π·cos: what a light of unit "white diffuse radiance" adds (GGX distribution and
    /// height-correlated shadowing: Walter et al. 2007; Heitz 2014, eq. 99). All cosines positive:
    /// normal·light, normal·view, normal·half, view·half.
    pub(super) fn highlight(&self, nl: f32, nv: f32, nh: f32, vh: f32) -> f32 {
        let a2 = self.width * self.width;
        let d = nh * nh * (a2 - 1.0) + 1.0;
        self.reflected(a2 / (PI * d * d), [a2; 2], [nl, nv, vh])
    }

    /// [`Gloss::highlight`] with `added` to the squares of the widths along x and y of the frame of the
    /// directions, whose z is the normal.
    pub(super) fn widened_highlight(
        &self,
        added: [f32; 2],
        [light, view, half]: [Vec3; 3],
        vh: f32,
    ) -> f32 {
        let [x2, y2] = added.map(|added| (self.width * self.width + added).min(1.0));
        let d = half.x * half.x / x2 + half.y * half.y / y2 + half.z * half.z;
        // The squared width that a direction sees.
        let seen = |direction: Vec3| {
            let [x, y] = [direction.x * direction.x, direction.y * direction.y];
            (x2 * x + y2 * y) / (x + y).max(f32::MIN_POSITIVE)
        };
        let distribution = 1.0 / (PI * (x2 * y2).sqrt() * d * d);
        let widths = [seen(light), seen(view)];
        self.reflected(distribution, widths, [light.z, view.z, vh])
    }

    /// D·F·G/(4 nl nv) times π·nl, with G/(4 nl nv) = 0.5/masking.
    fn reflected(&self, distribution: f32, [l2, v2]: [f32; 2], [nl, nv, vh]: [f32; 3]) -> f32 {
        let masking =
            nl * (nv * nv * (1.0 - v2) + v2).sqrt() + nv * (nl * nl * (1.0 - l2) + l2).sqrt();
        PI * nl * distribution * self.reflectance(vh) * 0.5 / masking.max(1e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_coat_without_strength() {
        assert_eq!(Gloss::new(0.0, 0.3), None);
        assert_eq!(Gloss::new(f32::NAN, 0.3), None);
    }

    #[test]
    fn the_coat_never_reflects_more_than_it_gets() {
        // Hemispherical reflectance for a view along the normal: about the head-on reflectance for a
        // smooth coat; at roughness 1 single scattering keeps 1 − ln 2 of it, in closed form.
        for roughness in [0.2_f32, 0.35, 0.7, 1.0] {
            let gloss = Gloss::new(1.0, roughness).unwrap();
            let steps = 20_000;
            let sum: f32 = (0..steps)
                .map(|i| {
                    let theta = (i as f32 + 0.5) / steps as f32 * PI * 0.5;
                    let half = theta * 0.5;
                    let brdf_cos_pi = gloss.highlight(theta.cos(), 1.0, half.cos(), half.cos());
                    2.0 * theta.sin() * brdf_cos_pi * (PI * 0.5 / steps as f32)
                })
                .sum();
            assert!(sum < 0.06, "roughness {roughness}: {sum}");
            if roughness == 1.0 {
                let closed_form = 0.04 * (1.0 - std::f32::consts::LN_2);
                assert!((sum - closed_form).abs() < 1e-4, "{sum} for {closed_form}");
            } else {
                assert!(sum > 0.02, "roughness {roughness}: {sum}");
            }
        }
    }

    #[test]
    fn a_highlight_widened_by_nothing_or_evenly_is_the_round_one() {
        let gloss = Gloss::new(1.0, 0.4).unwrap();
        let wider = Gloss::new(1.0, (0.16_f32 * 0.16 + 0.05).powf(0.25)).unwrap();
        let light = Vec3::new(0.3, 0.2, 0.9).normalize();
        let view = Vec3::new(-0.5, 0.1, 0.6).normalize();
        let half = (light + view).normalize();
        let vh = view.dot(half);
        for (added, round) in [([0.0; 2], gloss), ([0.05; 2], wider)] {
            // Grazing reflectance depends on the roughness; compare what does not.
            let expected = round.highlight(light.z, view.z, half.z, vh) / round.reflectance(vh)
                * gloss.reflectance(vh);
            let found = gloss.widened_highlight(added, [light, view, half], vh);
            assert!(
                (found / expected - 1.0).abs() < 2e-3,
                "{found} for {expected}"
            );
        }
        let stretched = gloss.widened_highlight([0.2, 0.0], [light, view, half], vh);
        let turned = |v: Vec3| Vec3::new(-v.y, v.x, v.z);
        let other = gloss.widened_highlight([0.0, 0.2], [light, view, half].map(turned), vh);
        assert!(
            (stretched / other - 1.0).abs() < 1e-4,
            "{stretched} and {other}"
        );
    }

    #[test]
    fn fresnel_runs_from_head_on_to_grazing() {
        let gloss = Gloss::new(1.0, 0.0).unwrap();
        assert!((gloss.reflectance(1.0) - 0.04).abs() < 1e-6);
        assert!((gloss.reflectance(0.0) - 1.0).abs() < 1e-6);
    }
}
