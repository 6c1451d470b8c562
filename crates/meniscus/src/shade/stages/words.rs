//! Looks and lights in flat words that both sides read.
//!
//! What each word holds stands here, beside the code that writes it; the device's twin is
//! `shaders/frame/looks.wgsl` of `meniscus-gpu`. Numbers that count or choose are written as floats.

use super::surfaces::{all_surface_words, plane_words};
use super::varying::Varying;
use super::{Shader, Unstaged};
use crate::frame::BaseColor;
use crate::shade::bsdf::{self, AlbedoTable};
use crate::shade::light::{Emitter, Sky};
use crate::shade::world::Prepared;
use glam::{DVec3, Vec3};

/// Words whose numbers floats still tell apart.
const MOST_WORDS: u32 = 1 << 24;

/// Words per material.
pub const MATERIAL_WORDS: u32 = 11;
/// Words per light.
pub const EMITTER_WORDS: u32 = 5;
/// Entries along each side of a table of what rough surfaces reflect.
pub const ALBEDO_ENTRIES: u32 = bsdf::ALBEDO_ENTRIES as u32;
/// Words of the light from all around: a constant; a sky's polynomial (4); spherical harmonics (9); the
/// default sky's horizon, zenith, nadir.
pub const AMBIENT_WORDS: u32 = 17;

/// Everything that is packed.
pub(super) struct AllWords {
    pub(super) words: Vec<[f32; 4]>,
    /// As [`super::StagedShading::places`].
    pub(super) places: [u32; 5],
    /// The word of the first plane that cuts.
    pub(super) cuts: u32,
}

/// Words under way.
#[derive(Default)]
pub(super) struct Words(pub(super) Vec<[f32; 4]>);

impl Words {
    /// Where the next word goes.
    pub(super) fn here(&self) -> u32 {
        self.0.len() as u32
    }

    pub(super) fn push(&mut self, v: Vec3, w: f32) {
        self.0.push([v.x, v.y, v.z, w]);
    }

    /// Numbers, four to a word.
    fn numbers(&mut self, numbers: impl Iterator<Item = f64>) -> u32 {
        let here = self.here();
        for (i, number) in numbers.enumerate() {
            if i % 4 == 0 {
                self.0.push([0.0; 4]);
            }
            let last = self.0.len() - 1;
            self.0[last][i % 4] = number as f32;
        }
        here
    }

    /// A table's entries, then its means.
    fn albedo(&mut self, table: &AlbedoTable) -> u32 {
        let here = self.numbers(table.entries.iter().copied());
        self.numbers(table.means.iter().copied());
        here
    }

    fn sky(&mut self, sky: &Sky) {
        for color in [sky.horizon, sky.zenith, sky.nadir] {
            self.push(color, 0.0);
        }
    }
}

/// The leading digits of a vector, and the rest.
pub(super) fn halves(v: DVec3) -> [Vec3; 2] {
    let high = v.as_vec3();
    [high, (v - high.as_dvec3()).as_vec3()]
}

impl Shader<'_> {
    /// All words, and where they begin.
    pub(super) fn staged_words(&self, origin: DVec3) -> Result<AllWords, Unstaged> {
        let frame = self.world.frame;
        let mut words = Words::default();
        let images: Vec<u32> = (self.world.lights.emitters.iter())
            .map(|emitter| image_words(emitter, &mut words))
            .collect();
        let cuts = words.here();
        for plane in &frame.clips {
            plane_words(
                plane.normal,
                (origin - plane.point).dot(plane.normal),
                &mut words,
            );
        }
        let surfaces = all_surface_words(frame, self.settings.shutter_secs, origin, &mut words);
        let tables = self.material_tables(&mut words);
        let varying: Vec<Varying> = (0..frame.materials.len())
            .map(|index| self.varying(index, &mut words))
            .collect();
        let materials = words.here();
        for (index, varying) in varying.iter().enumerate() {
            self.material_words(index, tables[index], varying, &mut words);
        }
        let emitters = words.here();
        for (emitter, &image) in self.world.lights.emitters.iter().zip(&images) {
            emitter_words(emitter, origin, image, &mut words);
        }
        let ambient = words.here();
        if ambient > MOST_WORDS {
            return Err(Unstaged::Room);
        }
        self.ambient_words(&mut words);
        let full = words.albedo(AlbedoTable::full());
        let places = [surfaces, materials, emitters, ambient, full];
        Ok(AllWords {
            words: words.0,
            places,
            cuts,
        })
    }

    /// Tables of each material: of its coat, or of its boundary seen from the thin and the dense side.
    fn material_tables(&self, words: &mut Words) -> Vec<[u32; 2]> {
        let count = self.world.frame.materials.len();
        let mut tables = vec![[0; 2]; count];
        for (table, prepared) in tables.iter_mut().zip(&self.world.prepared) {
            match prepared {
                Prepared::Coated(coat) => table[0] = words.albedo(&coat.albedo),
                Prepared::Clear(Some(boundary)) => {
                    *table = [&boundary.from_thin, &boundary.from_dense].map(|t| words.albedo(t));
                }
                Prepared::Diffuse
                | Prepared::Conductor
                | Prepared::Clear(None)
                | Prepared::Sheet
                | Prepared::Foam => {}
            }
        }
        tables
    }

    /// (colour, translucency), (absorption coefficients, index of refraction), (coat of `shaded`: head on,
    /// grazing, width; all 0 without; what varies: 1 colour or roughness, 2 absorption, 3 both), (scattering:
    /// 0 diffuse, 1 metal, 2 coated, 3 clear, 4 sheet, 5 foam; roughness; strength of the coat; its index),
    /// (tables: coat or thin side, dense side or 0; priority; whether its inside is a medium), then
    /// [`Varying::push`].
    fn material_words(
        &self,
        index: usize,
        [first, second]: [u32; 2],
        varying: &Varying,
        words: &mut Words,
    ) {
        let material = &self.world.frame.materials[index];
        let color = Vec3::from_array(constant_of(&material.base));
        words.push(color, material.translucency);
        let absorption = material.absorption.constant().unwrap_or_default();
        words.push(Vec3::from_array(absorption), material.ior as f32);
        let gloss = self.gloss[index].map_or(Vec3::ZERO, |gloss| {
            Vec3::new(gloss.head_on, gloss.grazing, gloss.width)
        });
        words.push(gloss, f32::from(varying.what()));
        let (scattering, strength, ior) = match self.world.prepared.get(index) {
            None | Some(Prepared::Diffuse) => (0.0, 0.0, 1.0),
            Some(Prepared::Conductor) => (1.0, 0.0, 1.0),
            Some(Prepared::Coated(coat)) => (2.0, coat.strength as f32, coat.ior as f32),
            Some(Prepared::Clear(_)) => (3.0, 0.0, 1.0),
            Some(Prepared::Sheet) => (4.0, 0.0, 1.0),
            Some(Prepared::Foam) => (5.0, 0.0, 1.0),
        };
        words.push(Vec3::new(scattering, material.roughness, strength), ior);
        let tables = Vec3::new(first as f32, second as f32, material.priority as f32);
        words.push(tables, f32::from(u8::from(material.is_medium())));
        let left = constant_of(&material.absorption.left);
        varying.push((left, material.absorption.depth), words);
    }

    fn ambient_words(&self, words: &mut Words) {
        words.push(self.ambient.constant, 0.0);
        let polynomial = self.ambient.sky.map_or([Vec3::ZERO; 4], |sky| sky.diffuse);
        let harmonics = self.ambient.harmonics.unwrap_or([Vec3::ZERO; 9]);
        for color in polynomial.into_iter().chain(harmonics) {
            words.push(color, 0.0);
        }
        words.sky(&self.world.default_sky);
    }
}

/// A colour where it is the same everywhere, else 0.
fn constant_of(color: &BaseColor) -> [f32; 3] {
    match color {
        BaseColor::Constant(color) => *color,
        BaseColor::Attribute(_) | BaseColor::Direct(_) => [0.0; 3],
    }
}

/// An image: a word per texel (radiance; part of its row's light up to and including it), then the parts
/// of the rows' light up to and including each.
fn image_words(emitter: &Emitter, words: &mut Words) -> u32 {
    let here = words.here();
    if let Emitter::Environment(environment, _) = emitter {
        let (rows, columns) = environment.distributions();
        let [width, _] = environment.size();
        for (row, column) in environment.texels().chunks(width).zip(columns) {
            let total = column.total().max(f64::MIN_POSITIVE);
            for (&texel, sum) in row.iter().zip(column.sums()) {
                words.push(Vec3::from_array(texel), (sum / total) as f32);
            }
        }
        let total = rows.total().max(f64::MIN_POSITIVE);
        words.numbers(rows.sums().iter().map(|sum| sum / total));
    }
    here
}

/// (kind, numbers), (radiance, –), vectors: see each kind.
fn emitter_words(emitter: &Emitter, origin: DVec3, image: u32, words: &mut Words) {
    let numbers = |kind: f32, a: f64, b: f64| (Vec3::new(kind, a as f32, b as f32), 0.0);
    let nothing = [DVec3::ZERO; 3];
    let colors = |colors: [Vec3; 3]| colors.map(Vec3::as_dvec3);
    let ((head, last), (radiance, more), vectors) = match emitter {
        // 1 − cos of half its angle, 0 for a point.
        Emitter::Sun(sun) => {
            let height = if sun.is_point() { 0.0 } else { sun.height };
            let vectors = [sun.towards, DVec3::ZERO, DVec3::ZERO];
            (numbers(0.0, height, 0.0), (sun.radiance, 0.0), vectors)
        }
        Emitter::Point(position, radiance) => {
            let vectors = [*position - origin, DVec3::ZERO, DVec3::ZERO];
            (numbers(1.0, 0.0, 0.0), (*radiance, 0.0), vectors)
        }
        // Its radius.
        Emitter::Sphere(sphere) => {
            let vectors = [sphere.center - origin, DVec3::ZERO, DVec3::ZERO];
            (
                numbers(2.0, sphere.radius, 0.0),
                (sphere.radiance, 0.0),
                vectors,
            )
        }
        // Centre and edges.
        Emitter::Rectangle(rectangle) => {
            let [first, second] = rectangle.edges;
            let vectors = [rectangle.center - origin, first, second];
            (numbers(3.0, 0.0, 0.0), (rectangle.radiance, 0.0), vectors)
        }
        // Horizon, zenith, nadir.
        Emitter::Sky(sky) => {
            let vectors = colors([sky.horizon, sky.zenith, sky.nadir]);
            (numbers(4.0, 0.0, 0.0), (Vec3::ZERO, 0.0), vectors)
        }
        Emitter::Constant(radiance) => (numbers(5.0, 0.0, 0.0), (*radiance, 0.0), nothing),
        // Columns, rows, first texel; the scale, the luminance of its mean; right, zenith, middle.
        Emitter::Environment(environment, scale) => {
            let [width, height] = environment.size();
            let mean = crate::frame::environment::luminance(environment.mean() * *scale);
            let (head, _) = numbers(6.0, width as f64, height as f64);
            (
                (head, image as f32),
                (*scale, mean as f32),
                environment.axes(),
            )
        }
    };
    words.push(head, last);
    words.push(radiance, more);
    for vector in vectors {
        words.push(vector.as_vec3(), 0.0);
    }
}
