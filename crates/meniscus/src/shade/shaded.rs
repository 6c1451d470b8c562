//! Integrator `shaded`: direct sun with a hard shadow, soft sky light, a highlight and the sky's
//! reflection, one shadow ray per sun and hit.

use super::attributes::{AttributeLayout, SurfaceAttributes};
use super::gloss::Gloss;
use super::sky::Sky;
use crate::frame::{BaseColor, Frame, Geometry, Light};
use crate::intersect::{Hit, Scratch};
use crate::math::ray::{Ray, Side};
use crate::scene::{Background, Light as LightSettings};
use glam::{DVec3, Vec3};

/// How much of the light on its outer side a wall shows to an eye inside the fluid.
const WALL_TRANSMISSION: f32 = 0.6;

/// Rays traced, by purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayCounts {
    /// From the eye.
    pub primary: u64,
    /// Towards lights.
    pub shadow: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Refracted.
    pub refraction: u64,
    /// For ambient occlusion.
    pub ambient_occlusion: u64,
    /// Scattered diffusely.
    pub diffuse: u64,
}

impl std::ops::AddAssign for RayCounts {
    fn add_assign(&mut self, other: Self) {
        self.primary += other.primary;
        self.shadow += other.shadow;
        self.reflection += other.reflection;
        self.refraction += other.refraction;
        self.ambient_occlusion += other.ambient_occlusion;
        self.diffuse += other.diffuse;
    }
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary
            + self.shadow
            + self.reflection
            + self.refraction
            + self.ambient_occlusion
            + self.diffuse
    }
}

/// What a primary ray saw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Linear Rec. 709 radiance, premultiplied by coverage; with the sky if that is the background.
    pub radiance: [f32; 3],
    /// 1 on a surface, else 0.
    pub coverage: f32,
    /// Share of the background that shows: 1 beside surfaces, and more and more of it on the ground
    /// towards the horizon.
    pub backdrop: f32,
    /// Diffuse reflectance; 0 beside surfaces.
    pub albedo: [f32; 3],
    /// What was hit.
    pub hit: Option<Hit>,
    /// Row in its file of the strongest particle.
    pub row: Option<u32>,
}

/// Buffers that one thread reuses from ray to ray, and its counts.
#[derive(Debug, Default)]
pub struct ShadeScratch {
    /// Of the engines.
    pub trace: Scratch,
    /// Rays so far.
    pub rays: RayCounts,
    attributes: SurfaceAttributes,
}

impl ShadeScratch {
    /// All attributes of the frame at the last hit, in the order of [`super::frame_attributes`];
    /// empty after a miss or if the shader was made without them.
    pub fn attributes(&self) -> &[f32] {
        &self.attributes.all
    }
}

struct Sun {
    towards: DVec3,
    radiance: Vec3,
}

/// Shades the surfaces of one frame.
pub struct Shader<'a> {
    frame: &'a Frame,
    background: Background,
    suns: Vec<Sun>,
    /// Lights surfaces.
    sky: Option<Sky>,
    /// Stands behind them.
    backdrop: Sky,
    /// Coats, one per material.
    gloss: Vec<Option<Gloss>>,
    /// If all attributes are wanted at every hit.
    attributes: Option<AttributeLayout>,
}

impl<'a> Shader<'a> {
    /// A shader for `frame` in front of `background`; `with_attributes` evaluates every attribute at
    /// every hit.
    pub fn new(frame: &'a Frame, background: Background, with_attributes: bool) -> Self {
        let mut suns = Vec::new();
        let mut sky_light: Option<Vec3> = None;
        for light in &frame.lights {
            match *light {
                Light::Sun { towards, radiance } => suns.push(Sun {
                    towards,
                    radiance: Vec3::from_array(radiance),
                }),
                Light::Sky { radiance } => {
                    let more = Vec3::from_array(radiance);
                    sky_light = Some(sky_light.map_or(more, |sum| sum + more));
                }
            }
        }
        let sky = sky_light.map(|mean| Sky::new(mean.to_array()));
        Self {
            frame,
            background,
            suns,
            sky,
            backdrop: sky.unwrap_or_else(default_sky),
            gloss: frame
                .materials
                .iter()
                .map(|material| Gloss::new(material.specular, material.roughness))
                .collect(),
            attributes: with_attributes.then(|| AttributeLayout::new(frame)),
        }
    }

    /// What `ray` (from the eye, unit direction) sees.
    pub fn sample(&self, ray: &Ray, scratch: &mut ShadeScratch) -> Seen {
        scratch.rays.primary += 1;
        scratch.attributes.all.clear();
        match self.frame.closest_hit(ray, &mut scratch.trace) {
            Some(hit) => self.surface(ray, hit, scratch),
            None => Seen {
                radiance: self.behind(ray.direction).to_array(),
                coverage: 0.0,
                backdrop: 1.0,
                albedo: [0.0; 3],
                hit: None,
                row: None,
            },
        }
    }

    /// Light from where no surface is, as far as it belongs into the colour channels.
    fn behind(&self, direction: DVec3) -> Vec3 {
        match self.background {
            Background::Sky => self.backdrop.radiance(self.height(direction)),
            Background::Transparent | Background::Color(_) => Vec3::ZERO,
        }
    }

    fn surface(&self, ray: &Ray, hit: Hit, scratch: &mut ShadeScratch) -> Seen {
        let albedo = self.albedo(&hit, scratch);
        let lit = self.lit(ray, &hit, albedo, scratch);
        let opacity = match &self.frame.ground {
            Some(ground) if ground.surface == hit.surface => ground.opacity(hit.position),
            _ => 1.0,
        };
        let radiance = match self.background {
            // A file without background keeps the whole ground for whoever composes it.
            Background::Transparent => lit,
            _ => lit * opacity + self.behind(ray.direction) * (1.0 - opacity),
        };
        let instance = &self.frame.instances[hit.surface as usize];
        let row = match (&self.frame.geometries[instance.geometry as usize], hit.blob) {
            (Geometry::Blobs(blobs), Some(blob)) => blobs.field.rows.get(blob as usize).copied(),
            _ => None,
        };
        Seen {
            radiance: radiance.to_array(),
            coverage: 1.0,
            backdrop: 1.0 - opacity,
            albedo: albedo.to_array(),
            hit: Some(hit),
            row,
        }
    }

    /// The base colour at a hit; fills the attribute buffer where it is wanted.
    fn albedo(&self, hit: &Hit, scratch: &mut ShadeScratch) -> Vec3 {
        let material = self.frame.instances[hit.surface as usize].material as usize;
        let base = &self.frame.materials[material].base;
        if self.attributes.is_some() || !matches!(base, BaseColor::Constant(_)) {
            scratch.attributes.gather(self.frame, hit);
        }
        if let Some(layout) = &self.attributes {
            scratch.attributes.fill_all(self.frame, hit, layout);
        }
        match base {
            BaseColor::Constant(color) => Vec3::from_array(*color),
            BaseColor::Direct(attribute) => {
                match *scratch.attributes.value(self.frame, hit, *attribute) {
                    [r, g, b] => Vec3::new(r, g, b),
                    _ => Vec3::ZERO,
                }
            }
            BaseColor::Attribute(coloring) => {
                let value = scratch
                    .attributes
                    .value(self.frame, hit, coloring.attribute);
                Vec3::from_array(coloring.color(value))
            }
        }
    }

    /// Light from a hit towards the eye.
    ///
    /// Seen from inside the fluid, a wall shows part of the diffuse light on its outer side: so an
    /// eye in the fluid sees shapes and shadows, and nothing shines there that is lit from nowhere.
    fn lit(&self, ray: &Ray, hit: &Hit, albedo: Vec3, scratch: &mut ShadeScratch) -> Vec3 {
        let towards_eye = -ray.direction;
        let from_inside = hit.normal.dot(towards_eye) < 0.0;
        // A shading normal may turn away from the eye where the face does not.
        let normal = hit.shading_normal;
        let facing = normal.dot(towards_eye) as f32;
        let facing = if from_inside {
            facing
        } else {
            facing.max(1e-3)
        };
        let material = self.frame.instances[hit.surface as usize].material as usize;
        let gloss = self.gloss[material].filter(|_| !from_inside);
        let coat = gloss.map_or(0.0, |gloss| gloss.reflectance(facing));

        let mut diffuse = Vec3::ZERO;
        let mut specular = Vec3::ZERO;
        for sun in &self.suns {
            let nl = normal.dot(sun.towards) as f32;
            let is_behind_face = hit.normal.dot(sun.towards) <= 0.0;
            if nl <= 0.0 || is_behind_face || self.is_shadowed(ray, hit, sun.towards, scratch) {
                continue;
            }
            diffuse += sun.radiance * nl;
            if let Some(gloss) = gloss {
                let half = (sun.towards + towards_eye).normalize_or_zero();
                let nh = (normal.dot(half) as f32).max(0.0);
                let vh = (towards_eye.dot(half) as f32).max(0.0);
                specular += sun.radiance * gloss.highlight(nl, facing, nh, vh);
            }
        }
        if let Some(sky) = &self.sky {
            diffuse += sky.diffuse(self.height(normal));
            let mirrored = ray.direction - normal * (2.0 * normal.dot(ray.direction));
            specular += sky.radiance(self.height(mirrored)) * coat;
        }
        if from_inside {
            return albedo * diffuse * WALL_TRANSMISSION;
        }
        albedo * diffuse * (1.0 - coat) + specular
    }

    /// Whether something stands between a hit and a sun. The shadow ray starts at the hit itself, on
    /// the stated outer side; no offset is needed.
    fn is_shadowed(
        &self,
        ray: &Ray,
        hit: &Hit,
        towards: DVec3,
        scratch: &mut ShadeScratch,
    ) -> bool {
        scratch.rays.shadow += 1;
        let shadow_ray = Ray {
            time: ray.time,
            ..Ray::new(hit.position, towards).with_side(Side::Outside)
        };
        self.frame.any_hit(&shadow_ray, &mut scratch.trace)
    }

    fn height(&self, direction: DVec3) -> f32 {
        direction.dot(self.frame.up) as f32
    }
}

/// What stands behind the surfaces of a scene that has no sky of its own.
fn default_sky() -> Sky {
    let sky = LightSettings::sky();
    let color = sky.color.unwrap_or(crate::scene::Color::WHITE).0;
    Sky::new(color.map(|c| (c * sky.intensity) as f32))
}
