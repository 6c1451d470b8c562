//! The accumulated picture: sums and nearest samples per pixel.

use super::channel::{ChannelSet, NO_INDEX, PixelSample, Source};
use super::{FilmError, Region};
use crate::scene::Background;
use std::sync::Arc;

/// Sums are integers of 2⁻³²: addition is exact, hence the same in any order. One sample counts up
/// to 2³¹, the sum saturates there.
const FIXED_ONE: f64 = 4_294_967_296.0;

fn fixed(value: f32) -> i64 {
    (f64::from(value) * FIXED_ONE) as i64
}

/// The numbers of one plane, row by row over the film's region.
#[derive(Debug, Clone, PartialEq)]
pub enum PlaneData {
    /// Real numbers.
    F32(Vec<f32>),
    /// Indices.
    U32(Vec<u32>),
}

/// Which sample the unfiltered channels of a pixel come from: the least key wins.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct NearestKey {
    distance_squared: f32,
    sample: u32,
}

const NO_SAMPLE: NearestKey = NearestKey {
    distance_squared: f32::INFINITY,
    sample: u32::MAX,
};

/// A picture, or a tile or sample range of one: named channels over a pixel rectangle.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    size: [u32; 2],
    region: Region,
    channels: Arc<ChannelSet>,
    background: Background,
    /// Samples per pixel so far.
    counts: Vec<u32>,
    nearest: Vec<NearestKey>,
    /// Sums of the backdrop's share, which developing needs and no file holds.
    backdrop: Vec<i64>,
    /// Planes of `Source::Mean`, then of floats and of indices from the nearest sample; each list
    /// in file order.
    sums: Vec<Vec<i64>>,
    floats: Vec<Vec<f32>>,
    indices: Vec<Vec<u32>>,
}

impl Film {
    /// An empty film over `region` of a picture of `size` (width, height) pixels.
    ///
    /// # Errors
    /// An impossible size or region, or too little memory.
    pub fn new(
        size: [u32; 2],
        region: Region,
        channels: Arc<ChannelSet>,
        background: Background,
    ) -> Result<Self, FilmError> {
        region.check(size)?;
        let pixels = region.pixels() as usize;
        let plane_count = channels.planes(super::AovStyle::Plain).len();
        let out_of_memory = |_| FilmError::Memory {
            pixels: region.pixels(),
            planes: plane_count,
        };
        fn filled<T: Clone>(
            length: usize,
            value: T,
        ) -> Result<Vec<T>, std::collections::TryReserveError> {
            let mut plane = Vec::new();
            plane.try_reserve_exact(length)?;
            plane.resize(length, value);
            Ok(plane)
        }
        let mut film = Self {
            size,
            region,
            background,
            counts: filled(pixels, 0).map_err(out_of_memory)?,
            nearest: filled(pixels, NO_SAMPLE).map_err(out_of_memory)?,
            backdrop: filled(pixels, 0).map_err(out_of_memory)?,
            sums: Vec::new(),
            floats: Vec::new(),
            indices: Vec::new(),
            channels: channels.clone(),
        };
        for channel in channels.channels() {
            for _ in channel.planes {
                match channel.source {
                    Source::Mean(_) => film.sums.push(filled(pixels, 0).map_err(out_of_memory)?),
                    Source::Nearest(_) => {
                        film.floats
                            .push(filled(pixels, 0.0).map_err(out_of_memory)?);
                    }
                    Source::NearestOrInfinite(_) => film
                        .floats
                        .push(filled(pixels, f32::INFINITY).map_err(out_of_memory)?),
                    Source::NearestIndex(_) => film
                        .indices
                        .push(filled(pixels, NO_INDEX).map_err(out_of_memory)?),
                    Source::SampleCount => {}
                }
            }
        }
        for _ in 0..channels.attributes().iter().map(|a| a.components).sum() {
            film.floats
                .push(filled(pixels, 0.0).map_err(out_of_memory)?);
        }
        Ok(film)
    }

    /// Width and height of the whole picture.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The rectangle that this film holds.
    pub fn region(&self) -> Region {
        self.region
    }

    /// The channels it holds.
    pub fn channels(&self) -> &ChannelSet {
        &self.channels
    }

    /// What its empty pixels mean.
    pub fn background(&self) -> Background {
        self.background
    }

    /// Adds sample number `sample` of pixel (x, y), taken at `offset` (in pixels) from its centre.
    /// Samples outside the region are ignored.
    pub fn add(&mut self, x: u32, y: u32, sample: u32, offset: [f64; 2], seen: &PixelSample<'_>) {
        let Some(pixel) = self.region.index(x, y) else {
            return;
        };
        self.counts[pixel] += 1;
        self.backdrop[pixel] = self.backdrop[pixel].saturating_add(fixed(seen.backdrop));
        let key = NearestKey {
            distance_squared: (offset[0] * offset[0] + offset[1] * offset[1]) as f32,
            sample,
        };
        let is_nearest = key < self.nearest[pixel];
        if is_nearest {
            self.nearest[pixel] = key;
        }
        let (mut sum, mut float, mut index) = (0, 0, 0);
        let Self {
            channels,
            sums,
            floats,
            indices,
            ..
        } = self;
        for channel in channels.channels() {
            let planes = channel.planes.len();
            match channel.source {
                Source::Mean(value) => {
                    for &component in &value(seen)[..planes] {
                        let plane = &mut sums[sum];
                        plane[pixel] = plane[pixel].saturating_add(fixed(component));
                        sum += 1;
                    }
                }
                Source::Nearest(value) => {
                    if is_nearest {
                        let values = seen.surface.as_ref().map_or([0.0; 3], value);
                        for (k, &component) in values[..planes].iter().enumerate() {
                            floats[float + k][pixel] = component;
                        }
                    }
                    float += planes;
                }
                Source::NearestOrInfinite(value) => {
                    if is_nearest {
                        floats[float][pixel] = seen.surface.as_ref().map_or(f32::INFINITY, value);
                    }
                    float += 1;
                }
                Source::NearestIndex(value) => {
                    if is_nearest {
                        indices[index][pixel] = seen.surface.as_ref().map_or(NO_INDEX, value);
                    }
                    index += 1;
                }
                Source::SampleCount => {}
            }
        }
        if is_nearest {
            for attribute in channels.attributes() {
                for component in 0..attribute.components {
                    let value = seen.attributes.get(attribute.offset + component);
                    floats[float][pixel] = value.copied().unwrap_or(0.0);
                    float += 1;
                }
            }
        }
    }

    /// Adds a tile or a sample range of the same picture. Any order gives the same film, bit for
    /// bit; a sample must not be added twice.
    ///
    /// # Errors
    /// When the films differ in size, channels or background, or `other` reaches beyond this one.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        let differ = |what| Err(FilmError::Merge { what });
        if self.size != other.size {
            return differ("size");
        }
        if self.channels != other.channels {
            return differ("channels");
        }
        if self.background != other.background {
            return differ("background");
        }
        if !self.region.contains(&other.region) {
            return differ("region");
        }
        let width = other.region.width as usize;
        for row in 0..other.region.height {
            let Some(start) = self.region.index(other.region.x, other.region.y + row) else {
                return differ("region");
            };
            let from = row as usize * width;
            for k in 0..width {
                self.merge_pixel(start + k, other, from + k);
            }
        }
        Ok(())
    }

    fn merge_pixel(&mut self, to: usize, other: &Self, from: usize) {
        self.counts[to] += other.counts[from];
        self.backdrop[to] = self.backdrop[to].saturating_add(other.backdrop[from]);
        for (sum, added) in self.sums.iter_mut().zip(&other.sums) {
            sum[to] = sum[to].saturating_add(added[from]);
        }
        if other.nearest[from] < self.nearest[to] {
            self.nearest[to] = other.nearest[from];
            for (plane, theirs) in self.floats.iter_mut().zip(&other.floats) {
                plane[to] = theirs[from];
            }
            for (plane, theirs) in self.indices.iter_mut().zip(&other.indices) {
                plane[to] = theirs[from];
            }
        }
    }

    /// Plane `plane` of [`ChannelSet::planes`], resolved.
    ///
    /// # Panics
    /// If there is no such plane.
    pub fn plane(&self, plane: usize) -> PlaneData {
        let (mut at, mut sum, mut float, mut index) = (0, 0, 0, 0);
        for channel in self.channels.channels() {
            for _ in channel.planes {
                let found = at == plane;
                at += 1;
                match channel.source {
                    Source::Mean(_) if found => return PlaneData::F32(self.means(sum)),
                    Source::Nearest(_) | Source::NearestOrInfinite(_) if found => {
                        return PlaneData::F32(self.floats[float].clone());
                    }
                    Source::NearestIndex(_) if found => {
                        return PlaneData::U32(self.indices[index].clone());
                    }
                    Source::SampleCount if found => {
                        return PlaneData::F32(self.counts.iter().map(|&n| n as f32).collect());
                    }
                    Source::Mean(_) => sum += 1,
                    Source::Nearest(_) | Source::NearestOrInfinite(_) => float += 1,
                    Source::NearestIndex(_) => index += 1,
                    Source::SampleCount => {}
                }
            }
        }
        PlaneData::F32(self.floats[float + plane - at].clone())
    }

    /// The plane of that plain name.
    pub fn plane_named(&self, name: &str) -> Option<PlaneData> {
        let planes = self.channels.planes(super::AovStyle::Plain);
        let at = planes.iter().position(|plane| plane.name == name)?;
        Some(self.plane(at))
    }

    /// R, G, B and A of pixel `pixel` of the region, row by row: linear, premultiplied.
    pub(super) fn rgba(&self, pixel: usize) -> [f32; 4] {
        let mut value = [0.0; 4];
        for (component, sum) in value.iter_mut().zip(&self.sums) {
            *component = mean(sum[pixel], self.counts[pixel]);
        }
        value
    }

    /// Multiplies R, G and B of pixel `pixel` of the region, of all samples so far.
    pub(super) fn scale_color(&mut self, pixel: usize, factor: f32) {
        for plane in self.sums.iter_mut().take(3) {
            plane[pixel] = (plane[pixel] as f64 * f64::from(factor)) as i64;
        }
    }

    /// Sets R, G and B of pixel `pixel` of the region.
    pub(super) fn set_color(&mut self, pixel: usize, color: [f32; 3]) {
        let count = f64::from(self.counts[pixel]);
        for (plane, value) in self.sums.iter_mut().zip(color) {
            plane[pixel] = (f64::from(value) * count * FIXED_ONE) as i64;
        }
    }

    /// Share of the background that shows at pixel `pixel` of the region; 1 without samples.
    pub(super) fn backdrop(&self, pixel: usize) -> f32 {
        match self.counts[pixel] {
            0 => 1.0,
            count => mean(self.backdrop[pixel], count),
        }
    }

    fn means(&self, sum: usize) -> Vec<f32> {
        self.sums[sum]
            .iter()
            .zip(&self.counts)
            .map(|(&sum, &count)| mean(sum, count))
            .collect()
    }
}

fn mean(sum: i64, count: u32) -> f32 {
    (sum as f64 / (FIXED_ONE * f64::from(count.max(1)))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(seed: u32) -> ([f32; 3], f32) {
        let value = |k: u32| {
            let hash = (seed * 7 + k).wrapping_mul(2_654_435_761);
            (hash >> 8) as f32 / 1e6
        };
        (
            [value(0), value(1), value(2)],
            f32::from(!seed.is_multiple_of(3)),
        )
    }

    fn add_sample(film: &mut Film, x: u32, y: u32, s: u32) {
        let (radiance, coverage) = sample(x * 131 + y * 17 + s);
        let surface = (coverage > 0.0).then_some(crate::film::SurfaceSample {
            depth: radiance[0],
            position: radiance,
            normal: [0.0, 1.0, 0.0],
            motion: [0.0; 2],
            curvature: [0.0; 2],
            id: x + s,
            surface: 0,
        });
        let offset = [f64::from(s % 4) * 0.2 - 0.3, f64::from(s / 4) * 0.2 - 0.3];
        film.add(
            x,
            y,
            s,
            offset,
            &PixelSample {
                radiance,
                coverage,
                backdrop: 1.0 - coverage,
                albedo: radiance,
                denoising_albedo: [0.0; 3],
                surface,
                attributes: &[radiance[1], radiance[2]],
            },
        );
    }

    fn channels() -> Arc<ChannelSet> {
        let attributes = [("density".to_owned(), 1), ("age".to_owned(), 1)];
        Arc::new(ChannelSet::new(&["all"], &attributes).unwrap())
    }

    fn film(region: Region) -> Film {
        Film::new([8, 6], region, channels(), Background::Transparent).unwrap()
    }

    #[test]
    fn tiles_and_sample_ranges_merge_to_the_same_bits_in_any_order() {
        let full = Region::full(8, 6);
        let mut whole = film(full);
        let mut parts = Vec::new();
        for tile in full.tiles(3) {
            for samples in [8..16_u32, 0..5, 5..8] {
                let mut part = film(tile);
                for s in samples {
                    for y in tile.y..tile.y + tile.height {
                        for x in tile.x..tile.x + tile.width {
                            add_sample(&mut part, x, y, s);
                        }
                    }
                }
                parts.push(part);
            }
        }
        for y in 0..6 {
            for x in 0..8 {
                for s in 0..16 {
                    add_sample(&mut whole, x, y, s);
                }
            }
        }
        let mut forward = film(full);
        let mut backward = film(full);
        for part in &parts {
            forward.merge(part).unwrap();
        }
        for part in parts.iter().rev() {
            backward.merge(part).unwrap();
        }
        assert_eq!(whole, forward);
        assert_eq!(whole, backward);
        assert_eq!(
            whole.plane_named("samples"),
            Some(PlaneData::F32(vec![16.0; 48]))
        );
    }

    #[test]
    fn means_and_nearest_are_what_they_say() {
        let mut film = film(Region::full(8, 6));
        for s in 0..4 {
            add_sample(&mut film, 2, 1, s);
        }
        let pixel = film.region().index(2, 1).unwrap();
        let expected: f64 = (0..4)
            .map(|s| f64::from(sample(2 * 131 + 17 + s).0[1]) / 4.0)
            .sum();
        assert!((f64::from(film.rgba(pixel)[1]) - expected).abs() < 1e-6 * expected);
        // Sample 1 and 2 lie 0.1 pixel from the centre column; sample 1 is the first of them.
        let (radiance, coverage) = sample(2 * 131 + 17 + 1);
        assert_eq!(coverage, 1.0, "the test's own sample should hit");
        let PlaneData::F32(z) = film.plane_named("Z").unwrap() else {
            panic!("Z is real");
        };
        assert_eq!(z[pixel], radiance[0]);
        assert_eq!(z[0], f32::INFINITY);
        let PlaneData::F32(age) = film.plane_named("age").unwrap() else {
            panic!("age is real");
        };
        assert_eq!(age[pixel], radiance[2]);
        let PlaneData::U32(id) = film.plane_named("id").unwrap() else {
            panic!("id is an index");
        };
        assert_eq!((id[pixel], id[0]), (3, NO_INDEX));
    }

    #[test]
    fn not_a_number_and_huge_light_do_not_spoil_a_pixel() {
        let mut film = film(Region::full(8, 6));
        for (s, light) in [f32::NAN, f32::INFINITY, 1.0].into_iter().enumerate() {
            let seen = PixelSample {
                radiance: [light; 3],
                coverage: 1.0,
                backdrop: 0.0,
                albedo: [0.5; 3],
                denoising_albedo: [0.0; 3],
                surface: None,
                attributes: &[],
            };
            film.add(0, 0, s as u32, [0.0, 0.0], &seen);
        }
        assert!(film.rgba(0).iter().all(|x| x.is_finite()));
        assert_eq!(film.rgba(0)[3], 1.0);
    }

    #[test]
    fn films_of_different_pictures_do_not_merge() {
        let mut whole = film(Region::full(8, 6));
        let plain = Film::new(
            [8, 6],
            Region::full(8, 6),
            Arc::new(ChannelSet::default()),
            Background::Transparent,
        )
        .unwrap();
        assert!(matches!(
            whole.merge(&plain),
            Err(FilmError::Merge { what: "channels" })
        ));
    }
}
