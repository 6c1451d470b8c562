//! Presets: a look and settings under one name, as `--preset` takes them. To add one, add a line to
//! [`Preset::ALL`].

use super::attribute::ELEMENT_COLOR;
use super::surface::BlobSettings;
use super::{Color, IntegratorKind, IntegratorSettings, Material, MaterialKind, Scene, Weights};
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
    /// Exposure in stops, where the scene states none.
    pub exposure: Option<f64>,
    /// Whether the material is nothing without light that goes on behind the first surface.
    pub is_path_traced: bool,
}

impl Preset {
    /// Every preset.
    pub const ALL: [Self; 7] = [
        Self {
            name: "water",
            about: "clear water",
            material: Material {
                absorption: Some(Color([0.13, 0.58, 0.72])),
                ..Material::of(MaterialKind::Water, None)
            },
            is_path_traced: true,
            ..Self::PLAIN
        },
        Self {
            name: "milk",
            about: "a white liquid with a soft shine",
            // Index of milk: Jääskeläinen et al., Journal of Dairy Science 84(1), 2001.
            material: Material {
                ior: Some(1.35),
                roughness: Some(0.1),
                ..Material::of(MaterialKind::Plastic, Some(Color([0.86, 0.83, 0.76])))
            },
            exposure: Some(-0.8),
            is_path_traced: true,
            ..Self::PLAIN
        },
        Self {
            name: "honey",
            about: "amber, clear where it is thin",
            // Index of honey with 17 % water: Codex Alimentarius 12-1981, refractometry.
            material: Material {
                ior: Some(1.494),
                absorption: Some(Color([0.55, 0.06, 0.0005])),
                ..Material::of(MaterialKind::Dielectric, Some(Color([0.55, 0.22, 0.02])))
            },
            is_path_traced: true,
            ..Self::PLAIN
        },
        Self {
            name: "mercury",
            about: "liquid metal",
            // Reflectance at 450 to 650 nm: Inagaki, Arakawa & Williams, Physical Review B 23, 1981.
            material: Material {
                roughness: Some(0.0),
                ..Material::of(MaterialKind::Metal, Some(Color([0.781, 0.780, 0.778])))
            },
            is_path_traced: true,
            ..Self::PLAIN
        },
        Self {
            name: "molecule",
            about: "unit weights, quartic kernel, T = 0.2, a satin surface in the colours of the elements",
            material: Material::glossy(Color([0.60, 0.66, 0.72]), 0.7, 0.4),
            field: Some((Kernel::Quartic, 0.2, Weights::Unit)),
            ..Self::PLAIN
        },
        Self {
            name: "clay",
            about: "matt terracotta that shows the shape alone",
            material: Material::diffuse(Color([0.50, 0.26, 0.17])),
            ..Self::PLAIN
        },
        Self {
            name: "preview",
            about: "one sample per pixel, neutral gray",
            material: Material::glossy(Color([0.62, 0.64, 0.66]), 1.0, 0.35),
            spp: Some(1),
            ..Self::PLAIN
        },
    ];

    const PLAIN: Self = Self {
        name: "",
        about: "",
        material: Material::of(MaterialKind::Glossy, None),
        field: None,
        spp: None,
        exposure: None,
        is_path_traced: false,
    };

    /// The preset of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name == name)
    }

    /// Applies the preset to what `scene` leaves open: surfaces without a material get the preset's
    /// (under the preset's name), unset kernels, thresholds and weights get its own. The samples per
    /// pixel are replaced, and where the preset's material is used and needs it, integrator `shaded`
    /// gives way to `path` without caustics.
    pub fn apply(&self, scene: &mut Scene) {
        let mut is_used = false;
        for surface in &mut scene.surfaces {
            if self.name == "molecule" {
                surface.color_by.get_or_insert(ELEMENT_COLOR.to_owned());
            }
            if surface.material.is_none() {
                surface.material = Some(self.name.to_owned());
                is_used = true;
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
        if let Some(exposure) = self.exposure
            && is_used
            && scene.film.exposure == 0.0
        {
            scene.film.exposure = exposure;
        }
        if self.is_path_traced && is_used && scene.integrator.kind == IntegratorKind::Shaded {
            scene.integrator = IntegratorSettings {
                kind: IntegratorKind::Path,
                depth: scene.integrator.depth.max(12),
                caustics: false,
                ..scene.integrator.clone()
            };
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
    fn every_preset_makes_a_sound_scene_and_is_found() {
        for preset in Preset::ALL {
            let mut scene = Scene {
                surfaces: vec![Surface::from_file("a")],
                ..Scene::default()
            };
            preset.apply(&mut scene);
            assert_eq!(scene.validate(), Ok(()), "{}", preset.name);
            let traced = scene.integrator.kind == IntegratorKind::Path;
            assert_eq!(traced, preset.is_path_traced);
            assert_eq!(Preset::from_name(preset.name).as_ref(), Some(&preset));
        }
        assert_eq!(Preset::from_name("lava"), None);
    }

    #[test]
    fn a_preset_that_colours_nothing_leaves_the_integrator() {
        let mut scene = Scene {
            surfaces: vec![Surface {
                material: Some("steel".to_owned()),
                ..Surface::from_file("a")
            }],
            ..Scene::default()
        };
        Preset::from_name("water").unwrap().apply(&mut scene);
        assert_eq!(scene.integrator, IntegratorSettings::default());
    }
}
