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
mod tests;
