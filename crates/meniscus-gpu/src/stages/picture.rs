//! A picture as the stages read it: `Picture` in `shaders/frame/looks.wgsl`.

use super::sources::FILTER_STEPS;
use glam::{DVec3, Vec3};
use meniscus::math::cubics::Piece;
use meniscus::math::ray::Side;
use meniscus::render::{SampleBlock, StagedPicture};
use meniscus::scene::Background;

/// What stands for infinity in shaders.
const FAR: f32 = 3e38;
/// No surface.
const NONE: u32 = u32::MAX;
/// Bytes of a record.
pub(crate) const PICTURE_BYTES: u64 = 304;
/// Places in the record, in words of 32 bits, of what differs from block to block.
const REGION: usize = 44;
const FIRST_SAMPLE: usize = 48;

/// The record, and the words that go with it.
pub(crate) struct PictureRecord {
    pub(crate) words: Vec<[f32; 4]>,
    record: Vec<u32>,
}

/// A record on its way.
#[derive(Default)]
struct Record(Vec<u32>);

impl Record {
    fn row(&mut self, v: Vec3, w: u32) {
        self.0.extend(v.to_array().map(f32::to_bits));
        self.0.push(w);
    }

    /// A vector as a sum of two, a number beside each.
    fn halves(&mut self, v: DVec3, [first, second]: [u32; 2]) {
        let high = v.as_vec3();
        self.row(high, first);
        self.row((v - high.as_dvec3()).as_vec3(), second);
    }
}

impl PictureRecord {
    pub(crate) fn new(picture: &StagedPicture) -> Self {
        let StagedPicture {
            shading,
            camera,
            shutter_secs: [open, close],
            ..
        } = picture;
        let bits = |number: f64| (number as f32).to_bits();
        let way = camera.way([*open, *close], shading.origin);
        let camera = &camera.at(*open);
        let [width, height] = camera.size.map(f64::from);
        let pixel_side = 2.0 * (0.5 * camera.fov).tan() / height;
        let side = pixel_side as f32;
        let integrator = &shading.integrator;
        let limit = |limit: Option<u32>| limit.unwrap_or(NONE);
        let mut record = Record::default();
        let sides = [side.to_bits(), bits(pixel_side - f64::from(side))];
        record.halves(camera.eye - shading.origin, sides);
        record.halves(camera.forward, [bits(0.5 * width), bits(0.5 * height)]);
        record.halves(camera.right, [bits(*open), bits(close - open)]);
        let reach = integrator.distance.map_or(FAR, |reach| reach as f32);
        let clamp = integrator.clamp.map_or(-1.0, |clamp| clamp as f32);
        record.halves(camera.up, [reach.min(FAR).to_bits(), clamp.to_bits()]);
        record.row(shading.up, u32::from(shading.has_surroundings));
        let (ground, center, radius) = shading.ground.unwrap_or((NONE, DVec3::ZERO, 1.0));
        record.row(center.as_vec3(), bits(radius));
        let background = match shading.background {
            Background::Sky => 0,
            Background::Transparent => 1,
            Background::Color(_) => 2,
        };
        let eye_side = match picture.eye_side {
            Side::Unknown => 0,
            Side::Outside => 1,
            Side::Inside => 2,
        };
        let caustics = u32::from(integrator.caustics);
        record.0.extend([ground, background, eye_side, caustics]);
        record.0.extend([0; 4]);
        record.0.extend([0, 0, 0, picture.spp]);
        // Strata of the shutter's time.
        let strata = (1_u32 << picture.spp.max(1).ilog2()) as f32;
        let seeds = [picture.seed, strata.to_bits()];
        record.0.extend(seeds);
        record.0.extend([shading.media, shading.medium_count]);
        let [surfaces_at, materials_at, emitters_at, ambient_at, full_at] = shading.places;
        record
            .0
            .extend([surfaces_at, materials_at, emitters_at, ambient_at]);
        let [surfaces, emitters] = shading.counts;
        let mut words = shading.words.clone();
        record
            .0
            .extend([full_at, words.len() as u32, surfaces, emitters]);
        let steps = picture.filter.steps();
        debug_assert_eq!(steps.len(), FILTER_STEPS as usize, "the shaders' table");
        words.extend(steps.chunks(4).map(|chunk| {
            let mut word = [0.0; 4];
            for (number, &step) in word.iter_mut().zip(chunk) {
                *number = step as f32;
            }
            word
        }));
        let depths = [
            limit(integrator.diffuse_depth),
            limit(integrator.glossy_depth),
            limit(integrator.transmission_depth),
        ];
        record.0.extend([shading.ao_samples, integrator.depth]);
        record.0.extend(depths);
        record.0.push(u32::from(shading.light_walks));
        let way = way.unwrap_or_default();
        record.0.extend([words.len() as u32, way.len() as u32]);
        words.extend(way.iter().flat_map(Piece::words));
        record.0.extend(shading.cuts);
        let variances = shading.specular_variances.unwrap_or_default();
        record.0.extend(variances.map(bits));
        debug_assert_eq!(
            record.0.len(),
            PICTURE_BYTES as usize / 4,
            "the shaders' record"
        );
        Self {
            words,
            record: record.0,
        }
    }

    /// The record for `count` samples of a block, from number `first` on.
    pub(crate) fn of(&self, block: &SampleBlock, first: u64, count: u32) -> Vec<u32> {
        let mut record = self.record.clone();
        let region = block.region;
        let pixels = region.pixels();
        record[REGION..REGION + 4].copy_from_slice(&[
            region.x,
            region.y,
            region.width,
            region.height,
        ]);
        record[FIRST_SAMPLE] = block.samples.start + (first / pixels) as u32;
        record[FIRST_SAMPLE + 1] = (first % pixels) as u32;
        record[FIRST_SAMPLE + 2] = count;
        record
    }
}
