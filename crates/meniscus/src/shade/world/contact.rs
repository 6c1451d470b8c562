//! What a ray meets at a hit: the surface that counts, the media behind it, and how light is scattered
//! there.

use super::{Prepared, World, passed};
use crate::intersect::Hit;
use crate::math::level_set::HitChange;
use crate::math::ray::Ray;
use crate::math::sampling::tangents;
use crate::shade::antialias::NormalSpread;
use crate::shade::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Foam, Plastic};
use crate::shade::interaction::Interaction;
use crate::shade::medium::MediumStack;
use crate::shade::rays::ShadeScratch;
use glam::DVec3;

/// What a ray meets where it hits a surface.
pub(super) struct Contact {
    /// The surface that counts.
    pub(super) hit: Hit,
    /// Media behind it; those in front of it if it is opaque.
    pub(super) beyond: MediumStack,
    /// Whether anything changes there.
    pub(super) is_boundary: bool,
    /// How far apart rounding can bring crossings of one place, in the ray's parameter.
    pub(super) margin: f64,
}

/// How a ray goes on that nothing turned.
pub(in crate::shade) struct Onward {
    /// The ray.
    pub(in crate::shade) ray: Ray,
    /// Media that it is in.
    pub(in crate::shade) media: MediumStack,
    /// How far its origin was moved along.
    pub(super) walked: f64,
}

impl Contact {
    /// Behind what was no boundary. A ray that only met its own start again keeps what it states about
    /// it and leaves the place, or it would meet the faces that coincide there in turn for ever.
    pub(super) fn onward(&self, ray: &Ray) -> Onward {
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

impl World<'_> {
    /// What a ray in `media` meets at `hit`. Where faces coincide all are crossed at once; an opaque one
    /// stands behind what touches it.
    pub(super) fn contact(
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
    pub(in crate::shade) fn onward(
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
    pub(in crate::shade) fn interaction(
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
    pub(in crate::shade) fn spread_at(
        &self,
        ray: &Ray,
        hit: &Hit,
        normal: DVec3,
    ) -> Option<NormalSpread> {
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
}

/// The normal at a hit on the viewer's side: that for shading, unless `of_face` or it turns away from
/// the viewer.
pub(super) fn viewed_normal(ray: &Ray, hit: &Hit, of_face: bool) -> DVec3 {
    let towards = if hit.entering { 1.0 } else { -1.0 };
    let shading = hit.shading_normal * towards;
    if !of_face && shading.dot(ray.direction) < 0.0 {
        shading
    } else {
        hit.normal * towards
    }
}
