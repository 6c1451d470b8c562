//! Presets: a look and settings under one name, as `--preset` takes them. To add one, add a line to
//! [`Preset::ALL`].

use super::attribute::ELEMENT_COLOR;
use super::surface::BlobSettings;
use super::{Color, Material, MaterialKind, Scene, Weights};
use crate::kernel::Kernel;

/// A look and settings under one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset {
    /// The name in flags.
    pub name: &'static str,
    /// What it is for, one line.
    pub about: &'static str,
    /// Material of every surface that names none.
    pub material: Material,
    /// Kernel, threshold and weights of every surface that leaves them unset.
    pub field: Option<(Kernel, f64, Weights)>,
    /// Samples per pixel, where the preset is about speed.
    pub spp: Option<u32>,
}

impl Preset {
    /// Every preset.
    ///
    /// `water` is an opaque glossy blue: the integrator `shaded` does not follow light through a
    /// surface.
    pub const ALL: [Self; 4] = [
        Self {
            name: "water",
            about: "a glossy blue liquid",
            material: glossy([0.045, 0.23, 0.42], 1.0, 0.12),
            field: None,
            spp: None,
        },
        Self {
            name: "molecule",
            about: "unit weights, quartic kernel, T = 0.2, a satin surface in the colours of the elements",
            material: glossy([0.60, 0.66, 0.72], 0.7, 0.4),
            field: Some((Kernel::Quartic, 0.2, Weights::Unit)),
            spp: None,
        },
        Self {
            name: "clay",
            about: "matt terracotta that shows the shape alone",
            material: Material {
                kind: MaterialKind::Diffuse,
                color: Color([0.50, 0.26, 0.17]),
                specular: None,
                roughness: None,
            },
            field: None,
            spp: None,
        },
        Self {
            name: "preview",
            about: "one sample per pixel, neutral gray",
            material: glossy([0.62, 0.64, 0.66], 1.0, 0.35),
            field: None,
            spp: Some(1),
        },
    ];

    /// The preset of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// Applies the preset to what `scene` leaves open: surfaces without a material get the preset's
    /// (under the preset's name), unset kernels, thresholds and weights get its own. The samples per
    /// pixel are replaced.
    pub fn apply(&self, scene: &mut Scene) {
        for surface in &mut scene.surfaces {
            if self.name == "molecule" {
                surface.color_by.get_or_insert(ELEMENT_COLOR.to_owned());
            }
            if surface.material.is_none() {
                surface.material = Some(self.name.to_owned());
                scene
                    .materials
                    .entry(self.name.to_owned())
                    .or_insert_with(|| self.material.clone());
            }
            if let Some((kernel, threshold, weights)) = &self.field {
                surface.kernel.get_or_insert(*kernel);
                surface.threshold.get_or_insert(*threshold);
                surface.weights.get_or_insert_with(|| weights.clone());
            }
        }
        if let Some(spp) = self.spp {
            scene.film.spp = spp;
        }
    }

    /// The settings that a surface of this preset has where it sets nothing itself.
    pub fn settings(&self) -> BlobSettings {
        let mut settings = BlobSettings::default();
        if let Some((kernel, threshold, weights)) = &self.field {
            settings.kernel = *kernel;
            settings.threshold = *threshold;
            settings.weights = weights.clone();
        }
        settings
    }
}

const fn glossy(color: [f64; 3], specular: f64, roughness: f64) -> Material {
    Material {
        kind: MaterialKind::Glossy,
        color: Color(color),
        specular: Some(specular),
        roughness: Some(roughness),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Surface;
    use super::*;

    #[test]
    fn presets_fill_only_what_is_open() {
        let mut scene = Scene {
            surfaces: vec![
                Surface {
                    threshold: Some(0.4),
                    material: Some("steel".to_owned()),
                    ..Surface::default()
                },
                Surface::default(),
            ],
            ..Scene::default()
        };
        let molecule = Preset::from_name("molecule").unwrap();
        molecule.apply(&mut scene);
        let [first, second] = &scene.surfaces[..] else {
            panic!("two surfaces");
        };
        assert_eq!(first.threshold, Some(0.4));
        assert_eq!(first.kernel, Some(Kernel::Quartic));
        assert_eq!(first.material.as_deref(), Some("steel"));
        assert_eq!(second.material.as_deref(), Some("molecule"));
        assert_eq!(scene.materials["molecule"], molecule.material);
        let defaults = BlobSettings::default();
        assert_eq!(second.settings(&defaults), BlobSettings::molecule());
        assert_eq!(molecule.settings(), BlobSettings::molecule());
        assert_eq!(scene.film.spp, 16);
        Preset::from_name("preview").unwrap().apply(&mut scene);
        assert_eq!(scene.film.spp, 1);
    }

    #[test]
    fn every_preset_can_be_rendered_and_found() {
        for preset in Preset::ALL {
            assert!(preset.material.kind.is_supported(), "{}", preset.name);
            assert_eq!(Preset::from_name(preset.name).as_ref(), Some(&preset));
        }
        assert_eq!(Preset::from_name("lava"), None);
    }
}
