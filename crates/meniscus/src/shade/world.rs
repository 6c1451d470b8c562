//! What integrators share: looks of surfaces, media, lights in the way of nothing.

mod passage;

use super::ShadeSettings;
use super::antialias::{NormalSpread, SpecularFilter};
use super::attributes::AttributeLayout;
use super::bsdf::{Bsdf, Coat, Conductor, Dielectric, Diffuse, Foam, Plastic, RoughBoundary};
use super::interaction::Interaction;
use super::light::{Lights, Sky};
use super::medium::MediumStack;
use super::rays::{RayCounts, ShadeScratch};
use crate::frame::{BaseColor, Frame, Geometry, Material, Scaling};
use crate::intersect::Hit;
use crate::math::level_set::HitChange;
use crate::math::ray::{Ray, Side};
use crate::math::sampling::tangents;
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

/// What a ray meets where it hits a surface.
struct Contact {
    /// The surface that counts.
    hit: Hit,
    /// Media behind it; those in front of it if it is opaque.
    beyond: MediumStack,
    /// Whether anything changes there.
    is_boundary: bool,
    /// How far apart rounding can bring crossings of one place, in the ray's parameter.
    margin: f64,
}

/// How a ray goes on that nothing turned.
pub(super) struct Onward {
    /// The ray.
    pub(super) ray: Ray,
    /// Media that it is in.
    pub(super) media: MediumStack,
    /// How far its origin was moved along.
    walked: f64,
}

impl Contact {
    /// Behind what was no boundary. A ray that only met its own start again keeps what it states about
    /// it and leaves the place, or it would meet the faces that coincide there in turn for ever.
    fn onward(&self, ray: &Ray) -> Onward {
        let is_start = self.hit.t - ray.t_min <= self.margin;
        Onward {
            ray: match is_start {
                true => ray.with_range(self.hit.t + self.margin, ray.t_max),
                false => passed(ray, &self.hit),
            },
            media: self.beyond,
            walked: if is_start { 0.0 } else { self.hit.t },
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

    /// What a ray in `media` meets at `hit`. Where faces coincide all are crossed at once; an opaque one
    /// stands behind what touches it.
    fn contact(
        &self,
        ray: &Ray,
        hit: Hit,
        media: &MediumStack,
        scratch: &mut ShadeScratch,
    ) -> Contact {
        let (material, _) = self.material(hit.surface);
        // Nothing is seen from within opaque solids but by rays that begin on one and on what stands there.
        let may_be_left = !material.kind.is_clear() && !hit.entering && self.medium_count > 0;
        let mut contact = Contact {
            hit,
            beyond: *media,
            is_boundary: true,
            margin: 0.0,
        };
        if !material.is_medium() && !may_be_left {
            return contact;
        }
        let mut others = std::mem::take(&mut scratch.coinciding);
        others.clear();
        contact.margin = self
            .frame
            .coinciding(ray, &hit, &mut scratch.trace, &mut others);
        if may_be_left {
            contact.is_boundary = hit.t - ray.t_min > contact.margin;
        } else {
            contact.beyond = media.crossed(hit.surface, hit.entering);
            for other in &others {
                let (material, _) = self.material(other.surface);
                if material.is_medium() {
                    contact.beyond = contact.beyond.crossed(other.surface, other.entering);
                } else if !material.kind.is_clear() && other.entering && !hit.entering {
                    contact.hit = *other;
                }
            }
            if contact.hit.surface == hit.surface {
                let [filled, filled_beyond] =
                    [media, &contact.beyond].map(|m| m.filling(self.frame));
                contact.is_boundary = filled != filled_beyond;
            } else {
                contact.beyond = *media;
            }
        }
        scratch.coinciding = others;
        contact
    }

    /// How a ray in `media` goes on behind `hit` where [`World::interaction`] finds no boundary.
    pub(super) fn onward(
        &self,
        ray: &Ray,
        hit: Hit,
        media: &MediumStack,
        scratch: &mut ShadeScratch,
    ) -> Onward {
        self.contact(ray, hit, media, scratch).onward(ray)
    }

    /// The surface point that a ray in `media` hits; `None` where the boundary is none, because one
    /// medium fills the place on both sides. Opaque surfaces have at least the roughness
    /// `least_roughness`.
    pub(super) fn interaction(
        &self,
        ray: &Ray,
        hit: Hit,
        media: &MediumStack,
        least_roughness: f64,
        scratch: &mut ShadeScratch,
    ) -> Option<Interaction<'_>> {
        let contact = self.contact(ray, hit, media, scratch);
        if !contact.is_boundary {
            return None;
        }
        let Contact { hit, beyond, .. } = contact;
        let (material, index) = self.material(hit.surface);
        let (color, roughness) = self.look(&hit, scratch);
        let blurred = roughness.max(least_roughness);
        let bsdf = match &self.prepared[index] {
            Prepared::Diffuse => Bsdf::Diffuse(Diffuse { color }),
            Prepared::Conductor => Bsdf::Conductor(Conductor::new(color, blurred)),
            Prepared::Coated(coat) => Bsdf::Plastic(Plastic::new(coat, color, blurred)),
            Prepared::Clear(boundary) => {
                let indices = [media.ior(self.frame), beyond.ior(self.frame)];
                Bsdf::Dielectric(Dielectric::new(indices, roughness, boundary.as_deref()))
            }
            Prepared::Sheet => Bsdf::Sheet(self.sheet(ray, &hit, media, scratch)),
            Prepared::Foam => Bsdf::Foam(Foam {
                color,
                translucency: f64::from(material.translucency),
            }),
        };
        // Bodies refract by the face, so that what goes in comes out.
        let normal = viewed_normal(ray, &hit, material.is_medium());
        let changes = self.changes(ray, &hit);
        let spread = self.spread(ray, normal, changes.as_ref());
        let [x, y] = spread.map_or_else(|| tangents(normal), |spread| spread.tangents);
        let bsdf = spread.map_or(bsdf, |spread| self.widened(bsdf, spread.added));
        let axes = [x, y, normal];
        let mut view = DVec3::from_array(axes.map(|axis| -axis.dot(ray.direction)));
        // Where a ray grazes the surface, the rounded normal may look away from it.
        view.z = view.z.max(1e-5);
        Some(Interaction {
            hit,
            color,
            bsdf,
            view: view.normalize(),
            axes,
            beyond,
            changes,
        })
    }

    /// How a hit changes by the film's x and y and by time, the normals on the viewer's side; `None` for
    /// rays without differentials.
    fn changes(&self, ray: &Ray, hit: &Hit) -> Option<[HitChange; 3]> {
        let differential = ray.differential.as_ref()?;
        let surface = self.frame.level_set(hit, ray.time);
        let towards = if hit.entering { 1.0 } else { -1.0 };
        let changes = differential.at_hit(ray.direction, hit.t, &surface);
        Some(changes.map(|change| HitChange {
            normal: change.normal * towards,
            ..change
        }))
    }

    fn spread(
        &self,
        ray: &Ray,
        normal: DVec3,
        changes: Option<&[HitChange; 3]>,
    ) -> Option<NormalSpread> {
        let filter = self.filter.as_ref()?;
        filter.spread(normal, tangents(normal), ray.direction, changes?)
    }

    /// The spread of normals around `normal` at a hit, where highlights are to be widened by it.
    pub(super) fn spread_at(&self, ray: &Ray, hit: &Hit, normal: DVec3) -> Option<NormalSpread> {
        self.spread(ray, normal, self.changes(ray, hit).as_ref())
    }

    /// The highlight of a coat or metal, wider by `added`; others stay as they are.
    fn widened<'b>(&self, bsdf: Bsdf<'b>, added: [f64; 2]) -> Bsdf<'b> {
        match bsdf {
            Bsdf::Conductor(model) if self.widens_mirrors || !model.is_smooth() => {
                Bsdf::Conductor(model.widened(added))
            }
            Bsdf::Plastic(model) if self.widens_mirrors || !model.is_smooth() => {
                Bsdf::Plastic(model.widened(added))
            }
            Bsdf::Diffuse(_)
            | Bsdf::Conductor(_)
            | Bsdf::Plastic(_)
            | Bsdf::Dielectric(_)
            | Bsdf::Foam(_)
            | Bsdf::Sheet(_) => bsdf,
        }
    }

    /// Radiance of a light over what it is transported as: a lamp in a medium of index n has the basic
    /// radiance L/n².
    pub(super) fn emission_scale(&self, media: &MediumStack) -> f32 {
        let ior = media.ior(self.frame);
        (1.0 / (ior * ior)) as f32
    }
}

/// The normal at a hit on the viewer's side: that for shading, unless `of_face` or it turns away from
/// the viewer.
fn viewed_normal(ray: &Ray, hit: &Hit, of_face: bool) -> DVec3 {
    let towards = if hit.entering { 1.0 } else { -1.0 };
    let shading = hit.shading_normal * towards;
    if !of_face && shading.dot(ray.direction) < 0.0 {
        shading
    } else {
        hit.normal * towards
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
