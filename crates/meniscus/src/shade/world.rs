//! What integrators share: looks of surfaces, media, lights in the way of nothing.

mod contact;
mod passage;

use super::ShadeSettings;
use super::antialias::SpecularFilter;
use super::attributes::AttributeLayout;
use super::bsdf::{Coat, RoughBoundary};
use super::light::{Lights, Sky};
use super::medium::MediumStack;
use super::rays::{RayCounts, ShadeScratch};
use crate::frame::{BaseColor, Frame, Geometry, Material, Scaling};
use crate::intersect::Hit;
use crate::math::ray::{Ray, Side};
use crate::scene::{Background, IntegratorKind, Light as LightSettings, MaterialKind};
use glam::{DVec3, Vec3};

/// What a material needs beside its numbers, made once.
#[derive(Debug)]
pub(super) enum Prepared {
    Diffuse,
    Conductor,
    Coated(Box<Coat>),
    Clear(Option<Box<RoughBoundary>>),
    Sheet,
    Foam,
}

impl Prepared {
    fn new(material: &Material) -> Self {
        match material.kind {
            MaterialKind::Glossy if material.specular > 0.0 => {
                // Index 1.5 reflects 0.04 head on.
                Self::Coated(Box::new(Coat::new(1.5, f64::from(material.specular))))
            }
            MaterialKind::Glossy | MaterialKind::Diffuse => Self::Diffuse,
            MaterialKind::Plastic => Self::Coated(Box::new(Coat::new(material.ior, 1.0))),
            MaterialKind::Metal | MaterialKind::Mirror => Self::Conductor,
            MaterialKind::Dielectric | MaterialKind::Glass | MaterialKind::Water
                if material.thin =>
            {
                Self::Sheet
            }
            MaterialKind::Dielectric | MaterialKind::Glass | MaterialKind::Water => {
                let is_rough = material.roughness > 0.0 || material.roughness_by.is_some();
                Self::Clear(is_rough.then(|| Box::new(RoughBoundary::new(material.ior))))
            }
            MaterialKind::Foam => Self::Foam,
        }
    }
}

/// A frame, ready to be shaded.
pub(super) struct World<'a> {
    pub(super) frame: &'a Frame,
    pub(super) lights: Lights,
    pub(super) background: Background,
    /// Stands behind everything in a scene that has nothing around it.
    pub(super) default_sky: Sky,
    pub(super) prepared: Vec<Prepared>,
    /// How many surfaces have clear media inside.
    pub(super) medium_count: usize,
    /// Whether there are thin sheets.
    pub(super) has_sheets: bool,
    /// If all attributes are wanted at every first hit.
    attributes: Option<AttributeLayout>,
    /// Widens highlights.
    pub(super) filter: Option<SpecularFilter>,
    /// Whether it widens perfect mirrors, too: only where scattered rays are drawn.
    widens_mirrors: bool,
}

impl<'a> World<'a> {
    /// Only for integrators that scatter rays is [`World::interaction`] prepared.
    pub(super) fn new(frame: &'a Frame, settings: &ShadeSettings) -> Self {
        let scatters = match settings.integrator.kind {
            IntegratorKind::Whitted | IntegratorKind::Path => true,
            IntegratorKind::Shaded | IntegratorKind::Ao => false,
        };
        let prepared = if scatters {
            frame.materials.iter().map(Prepared::new).collect()
        } else {
            Vec::new()
        };
        let materials = || {
            let instances = frame.instances.iter();
            instances.map(|instance| &frame.materials[instance.material as usize])
        };
        Self {
            frame,
            lights: Lights::new(frame),
            background: settings.background,
            default_sky: default_sky(),
            prepared,
            medium_count: materials().filter(|material| material.is_medium()).count(),
            has_sheets: materials().any(|material| material.thin),
            attributes: settings
                .with_attributes
                .then(|| AttributeLayout::new(frame)),
            filter: SpecularFilter::new(settings),
            widens_mirrors: settings.integrator.kind == IntegratorKind::Path,
        }
    }

    /// Material of a surface, and its index.
    pub(super) fn material(&self, surface: u32) -> (&'a Material, usize) {
        let index = self.frame.instances[surface as usize].material as usize;
        (&self.frame.materials[index], index)
    }

    /// Light from where no surface is, as far as the eye's own rays show it: without suns.
    pub(super) fn behind(&self, direction: DVec3) -> Vec3 {
        match self.background {
            Background::Sky => self.backdrop(direction),
            Background::Transparent | Background::Color(_) => Vec3::ZERO,
        }
    }

    /// What surrounds the scene, or a default sky.
    pub(super) fn backdrop(&self, direction: DVec3) -> Vec3 {
        if self.lights.has_surroundings() {
            self.lights.surroundings(direction)
        } else {
            self.default_sky
                .radiance(direction.dot(self.frame.up) as f32)
        }
    }

    /// What mirrors and clear surfaces show where a ray leaves everything behind.
    pub(super) fn surroundings_or_backdrop(&self, direction: DVec3) -> Vec3 {
        if self.background == Background::Sky {
            self.backdrop(direction)
        } else {
            self.lights.surroundings(direction)
        }
    }

    /// How much of a hit's own look is left; less than 1 only on the ground, far away.
    pub(super) fn opacity(&self, hit: &Hit) -> f32 {
        match &self.frame.ground {
            Some(ground) if ground.surface == hit.surface => ground.opacity(hit.position),
            _ => 1.0,
        }
    }

    /// Row in its file of the strongest particle at a hit.
    pub(super) fn row(&self, hit: &Hit) -> Option<u32> {
        let instance = &self.frame.instances[hit.surface as usize];
        match (&self.frame.geometries[instance.geometry as usize], hit.blob) {
            (Geometry::Blobs(blobs), Some(blob)) => blobs.field.rows.get(blob as usize).copied(),
            _ => None,
        }
    }

    /// Fills the attribute buffer at the eye's hit where all attributes are wanted.
    pub(super) fn fill_attributes(&self, hit: &Hit, scratch: &mut ShadeScratch) {
        if let Some(layout) = &self.attributes {
            scratch
                .attributes
                .gather(self.frame, hit.surface, hit.position);
            scratch.attributes.fill_all(self.frame, hit, layout);
        }
    }

    /// Base colour and roughness at a hit.
    pub(super) fn look(&self, hit: &Hit, scratch: &mut ShadeScratch) -> (Vec3, f64) {
        let (material, _) = self.material(hit.surface);
        let by_attribute =
            !matches!(material.base, BaseColor::Constant(_)) || material.roughness_by.is_some();
        if by_attribute {
            scratch
                .attributes
                .gather(self.frame, hit.surface, hit.position);
        }
        let color = self.color(&material.base, hit.surface, scratch);
        let roughness = match &material.roughness_by {
            None => material.roughness,
            Some(scaling) => self.number(scaling, hit.surface, scratch).clamp(0.0, 1.0),
        };
        (Vec3::from_array(color), f64::from(roughness))
    }

    /// A colour at the point that was gathered last.
    fn color(&self, base: &BaseColor, surface: u32, scratch: &mut ShadeScratch) -> [f32; 3] {
        match base {
            BaseColor::Constant(color) => *color,
            BaseColor::Direct(attribute) => {
                match *scratch.attributes.value(self.frame, surface, *attribute) {
                    [r, g, b] => [r, g, b],
                    _ => [0.0; 3],
                }
            }
            BaseColor::Attribute(coloring) => {
                let attribute = coloring.attribute;
                coloring.color(scratch.attributes.value(self.frame, surface, attribute))
            }
        }
    }

    /// A scaled attribute at the point that was gathered last.
    fn number(&self, scaling: &Scaling, surface: u32, scratch: &mut ShadeScratch) -> f32 {
        let attribute = scaling.attribute;
        scaling.number(scratch.attributes.value(self.frame, surface, attribute))
    }

    /// Radiance of a light over what it is transported as: a lamp in a medium of index n has the basic
    /// radiance L/n².
    pub(super) fn emission_scale(&self, media: &MediumStack) -> f32 {
        let ior = media.ior(self.frame);
        (1.0 / (ior * ior)) as f32
    }
}

/// A ray that starts at a hit on the viewer's side; its direction is still the viewer's.
pub(super) fn back_from(ray: &Ray, hit: &Hit) -> Ray {
    let behind = passed(ray, hit);
    behind.with_side(behind.side.flipped())
}

/// The ray behind a surface that does not turn it.
pub(super) fn passed(ray: &Ray, hit: &Hit) -> Ray {
    Ray {
        time: ray.time,
        side: if hit.entering {
            Side::Inside
        } else {
            Side::Outside
        },
        side_of: Some(hit.surface),
        differential: ray
            .differential
            .map(|differential| differential.advanced(hit.t)),
        ..Ray::new(hit.position, ray.direction)
    }
}

/// Counts a ray by what scattered it.
pub(super) fn count(rays: &mut RayCounts, scattering: super::bsdf::Scattering) {
    use super::bsdf::Scattering;
    match scattering {
        Scattering::Diffuse => rays.diffuse += 1,
        Scattering::Reflection => rays.reflection += 1,
        Scattering::Refraction => rays.refraction += 1,
    }
}

/// What stands behind the surfaces of a scene that has no sky of its own.
fn default_sky() -> Sky {
    let sky = LightSettings::sky();
    let color = sky.color.unwrap_or(crate::scene::Color::WHITE).0;
    Sky::new(color.map(|c| (c * sky.intensity) as f32))
}
