//! What a device is told whose own stages shade: a frame's looks and lights, and what they leave here.

mod restored;
mod surfaces;
mod unstaged;
mod varying;
mod words;

pub use surfaces::SURFACE_WORDS;
pub use unstaged::{MOST_SURFACES, Unstaged};
pub use varying::{MAP_ENTRIES, MOST_COLUMNS, NO_NUMBER, StagedColumns};
pub use words::{ALBEDO_ENTRIES, AMBIENT_WORDS, EMITTER_WORDS, MATERIAL_WORDS};

use super::Shader;
use super::antialias::SpecularFilter;
use super::integrator::Gathered;
use super::rays::{Seen, ShadeScratch};
use crate::frame::Light;
use crate::intersect::Hit;
use crate::scene::{Background, IntegratorKind, IntegratorSettings};
use glam::{DVec3, Vec3};
use words::AllWords;

/// A blob surface of the frame.
#[derive(Debug, Clone, PartialEq)]
pub struct StagedField {
    /// Its instance.
    pub surface: u32,
    /// Its geometry.
    pub geometry: u32,
    /// Where the field's origin lies at the frame's time, relative to [`StagedShading::origin`].
    pub offset: DVec3,
    /// What its looks follow.
    pub columns: StagedColumns,
}

/// A frame's looks and lights, as stages read them.
#[derive(Debug, Clone, PartialEq)]
pub struct StagedShading {
    /// World point that all positions are relative to.
    pub origin: DVec3,
    /// Meshes, ways, surfaces, materials, lights, tables.
    pub words: Vec<[f32; 4]>,
    /// Word of the first surface, material, light, of the light from all around, and of the table of what
    /// rough metals keep.
    pub places: [u32; 5],
    /// Surfaces and lights.
    pub counts: [u32; 2],
    /// Word of the first plane that cuts, and how many there are: (normal, height of the origin over it),
    /// (–, –, –, low part of the height).
    pub cuts: [u32; 2],
    /// Lights that cast hard shadows.
    pub hard_lights: u32,
    /// Blob surfaces.
    pub fields: Vec<StagedField>,
    /// Up.
    pub up: Vec3,
    /// The ground's surface, the middle of what it shows relative to [`StagedShading::origin`], and
    /// [`crate::frame::GroundLook::radius`].
    pub ground: Option<(u32, DVec3, f64)>,
    /// What stands behind the surfaces.
    pub background: Background,
    /// Whether anything surrounds the scene.
    pub has_surroundings: bool,
    /// Clear media around the eye, in the order of entering: surface + 1, four bits each, the first lowest.
    pub media: u32,
    /// How many surfaces have clear media inside.
    pub medium_count: u32,
    /// Whether light may go straight through clear surfaces on its way to others.
    pub light_walks: bool,
    /// Where highlights are widened: the variances of what one sample stands for, of the film's x or y in
    /// square pixels, and of time in square seconds.
    pub specular_variances: Option<[f64; 2]>,
    /// How light is gathered.
    pub integrator: IntegratorSettings,
    /// Rays of `ao` per sample.
    pub ao_samples: u32,
}

impl Shader<'_> {
    /// What stages need to shade as this shader does.
    ///
    /// # Errors
    /// Where they cannot.
    pub fn staged(&self) -> Result<StagedShading, Unstaged> {
        let frame = self.world.frame;
        self.check_stages()?;
        let mut fields: Vec<StagedField> = Vec::new();
        for (surface, instance) in (0..).zip(&frame.instances) {
            let Some(blobs) = frame.geometries[instance.geometry as usize].blobs() else {
                continue;
            };
            fields.push(StagedField {
                surface,
                geometry: instance.geometry,
                offset: (instance.world_from_object).transform_point3(blobs.field.origin),
                columns: self.columns(surface)?,
            });
        }
        let origin = fields.first().ok_or(Unstaged::NoBlobs)?.offset;
        for field in &mut fields {
            field.offset -= origin;
        }
        let AllWords {
            words,
            places,
            cuts,
        } = self.staged_words(origin)?;
        let hard_lights = frame.lights.iter().filter(|light| is_hard(light)).count();
        let media = self
            .media
            .as_ref()
            .map_or(&[][..], |media| media.surfaces());
        Ok(StagedShading {
            origin,
            words,
            places,
            cuts: [cuts, frame.clips.len() as u32],
            counts: [frame.instances.len() as u32, frame.lights.len() as u32],
            hard_lights: hard_lights as u32,
            fields,
            up: frame.up.as_vec3(),
            ground: (frame.ground.as_ref())
                .map(|ground| (ground.surface, ground.center - origin, ground.radius)),
            background: self.settings.background,
            has_surroundings: self.world.lights.has_surroundings(),
            media: media
                .iter()
                .rev()
                .fold(0, |stack, &surface| stack << 4 | (surface + 1)),
            medium_count: self.world.medium_count as u32,
            light_walks: self.light_walks(),
            specular_variances: (self.world.filter.as_ref())
                .filter(|_| self.settings.integrator.kind != IntegratorKind::Ao)
                .map(SpecularFilter::of_pixel_and_time),
            integrator: self.settings.integrator.clone(),
            ao_samples: self.settings.integrator.ao_samples(self.settings.spp),
        })
    }

    /// What a sample saw that stages shaded: with everything that they leave to the processor. `hit` is
    /// what it met first, at `time_secs`.
    pub fn seen_by_stages(
        &self,
        radiance: Vec3,
        is_covered: bool,
        hit: Option<Hit>,
        time_secs: f64,
        scratch: &mut ShadeScratch,
    ) -> Seen {
        let hit = hit.map(|hit| self.restored(hit, time_secs));
        scratch.attributes.time_secs = time_secs;
        let first = hit.map(|hit| (hit, self.world.look(&hit, scratch).0));
        let gathered = Gathered {
            radiance,
            first,
            is_covered,
        };
        self.seen_with_backdrop(&gathered, scratch)
    }

    /// Whether light may go straight through clear surfaces on its way to others.
    fn light_walks(&self) -> bool {
        let integrator = &self.settings.integrator;
        let media = self.world.medium_count;
        let goes_straight = match integrator.kind {
            IntegratorKind::Shaded | IntegratorKind::Ao => return false,
            IntegratorKind::Whitted => true,
            IntegratorKind::Path => !integrator.caustics,
        };
        self.world.has_sheets || media > 1 || goes_straight && media > 0
    }
}

fn is_hard(light: &Light) -> bool {
    match light {
        Light::Sun { .. }
        | Light::Point { .. }
        | Light::Sphere { .. }
        | Light::Rectangle { .. } => true,
        Light::Sky { .. } | Light::Constant { .. } | Light::Environment { .. } => false,
    }
}
