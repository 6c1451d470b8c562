//! OpenEXR files: linear, all channels, full display window.

use super::channel::{AovStyle, Storage};
use super::picture::PlaneData;
use super::{Film, FilmError, write_aside};
use crate::scene::Background;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, LineOrder, Text, Vec2, WritableImage, f16,
};
use std::path::Path;

/// Largest finite half.
const HALF_MAX: f32 = 65504.0;

impl Film {
    /// Writes an OpenEXR file of all channels, aside first: scan lines, ZIP in blocks of 16, the
    /// region as data window and the whole picture as display window.
    ///
    /// # Errors
    /// When the file cannot be written or a channel's name cannot be stored; nothing is left behind
    /// then.
    pub fn write_exr(&self, path: &Path, style: AovStyle) -> Result<(), FilmError> {
        let planes = self.channels().planes(style);
        let encode_error = |message: String| FilmError::Encode {
            path: path.to_owned(),
            message,
        };
        let mut list = Vec::with_capacity(planes.len());
        for (index, plane) in planes.iter().enumerate() {
            let name = Text::new_or_none(&plane.name)
                .filter(|_| plane.name.len() < 256)
                .ok_or_else(|| {
                    encode_error(format!(
                        "the channel name '{}' must be 1 to 255 ASCII characters",
                        plane.name
                    ))
                })?;
            let samples = match (self.plane_over_background(index), plane.storage) {
                (PlaneData::F32(values), Storage::Half) => {
                    FlatSamples::F16(values.into_iter().map(half).collect())
                }
                (PlaneData::F32(values), _) => FlatSamples::F32(values),
                (PlaneData::U32(values), _) => FlatSamples::U32(values),
            };
            list.push(AnyChannel {
                name,
                // The hint for lossy compression; ours is lossless.
                quantize_linearly: plane.storage != Storage::Half,
                sampling: Vec2(1, 1),
                sample_data: samples,
            });
        }
        let region = self.region();
        let mut layer = Layer::new(
            (region.width as usize, region.height as usize),
            LayerAttributes {
                layer_position: Vec2(region.x as i32, region.y as i32),
                software_name: Some(Text::from("Meniscus")),
                ..LayerAttributes::default()
            },
            Encoding {
                compression: Compression::ZIP16,
                blocks: Blocks::ScanLines,
                line_order: LineOrder::Increasing,
            },
            AnyChannels::sort(list.into()),
        );
        layer.attributes.layer_name = None;
        let display =
            IntegerBounds::from_dimensions((self.size()[0] as usize, self.size()[1] as usize));
        let image = Image {
            attributes: ImageAttributes::new(display),
            layer_data: layer,
        };
        write_aside(path, |writer| {
            image
                .write()
                .to_buffered(writer)
                .map_err(|error| match error {
                    exr::error::Error::Io(source) => FilmError::Write {
                        path: path.to_owned(),
                        source,
                    },
                    other => encode_error(other.to_string()),
                })
        })
    }

    /// A plane with the background colour, if there is one, behind red, green and blue.
    fn plane_over_background(&self, plane: usize) -> PlaneData {
        match (self.background(), self.plane(plane)) {
            (Background::Color(color), PlaneData::F32(mut values)) if plane < 3 => {
                let color = color.to_f32()[plane];
                for (pixel, value) in values.iter_mut().enumerate() {
                    *value += color * self.backdrop(pixel);
                }
                PlaneData::F32(values)
            }
            (_, data) => data,
        }
    }
}

fn half(value: f32) -> f16 {
    f16::from_f32(value.clamp(-HALF_MAX, HALF_MAX))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{ChannelSet, PixelSample, Region, SurfaceSample};
    use crate::scene::Color;
    use std::sync::Arc;

    fn film(background: Background, region: Region) -> Film {
        let attributes = [("density".to_owned(), 1), ("velocity".to_owned(), 3)];
        let channels = Arc::new(ChannelSet::new(&["all"], &attributes).unwrap());
        let mut film = Film::new([40, 30], region, channels, background).unwrap();
        for y in 0..30 {
            for x in 0..40 {
                let hit = (x + y) % 3 != 0;
                let seen = PixelSample {
                    radiance: if hit { [0.25, 1e6, 0.0] } else { [0.0; 3] },
                    coverage: f32::from(hit),
                    backdrop: f32::from(!hit),
                    albedo: if hit { [0.5, 0.25, 0.125] } else { [0.0; 3] },
                    denoising_albedo: [0.0; 3],
                    surface: hit.then_some(SurfaceSample {
                        depth: 1.0 + x as f32,
                        position: [x as f32, y as f32, 1.0 / 3.0],
                        normal: [0.0, 0.6, 0.8],
                        motion: [0.25, -3.0],
                        curvature: [2.0, 4.0],
                        id: 16_777_217 + x,
                        surface: 2,
                    }),
                    attributes: if hit { &[998.7, 1.0, 2.0, 3.0] } else { &[] },
                };
                film.add(x, y, 0, [0.0, 0.0], &seen);
            }
        }
        film
    }

    fn read_back(path: &Path) -> exr::prelude::FlatImage {
        exr::prelude::read_all_flat_layers_from_file(path).unwrap()
    }

    fn channel<'a>(image: &'a exr::prelude::FlatImage, name: &str) -> &'a FlatSamples {
        let channels = &image.layer_data[0].channel_data.list;
        let found = channels.iter().find(|c| c.name.eq(name));
        &found
            .unwrap_or_else(|| panic!("no channel {name}"))
            .sample_data
    }

    #[test]
    fn all_channels_read_back_with_their_types() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        let film = film(Background::Transparent, Region::full(40, 30));
        film.write_exr(&path, AovStyle::Plain).unwrap();
        let image = read_back(&path);
        // Pixel 1 hits, pixel 0 does not.
        for (name, hit, miss) in [
            ("R", 0.25, 0.0),
            ("G", HALF_MAX, 0.0),
            ("A", 1.0, 0.0),
            ("albedo.G", 0.25, 0.0),
        ] {
            let FlatSamples::F16(values) = channel(&image, name) else {
                panic!("{name} should be half");
            };
            assert_eq!(
                (values[1].to_f32(), values[0].to_f32()),
                (hit, miss),
                "{name}"
            );
        }
        for (name, hit, miss) in [
            ("Z", 2.0, f32::INFINITY),
            ("P.Z", 1.0 / 3.0, 0.0),
            ("N.Y", 0.6, 0.0),
            ("samples", 1.0, 1.0),
            ("density", 998.7, 0.0),
            ("velocity.Y", 2.0, 0.0),
        ] {
            let FlatSamples::F32(values) = channel(&image, name) else {
                panic!("{name} should be float");
            };
            assert_eq!((values[1], values[0]), (hit, miss), "{name}");
        }
        for (name, hit) in [("id", 16_777_218), ("surface", 2)] {
            let FlatSamples::U32(values) = channel(&image, name) else {
                panic!("{name} should be an integer");
            };
            assert_eq!((values[1], values[0]), (hit, u32::MAX), "{name}");
        }
        assert_eq!(image.layer_data[0].encoding.compression, Compression::ZIP16);
    }

    #[test]
    fn a_region_keeps_the_whole_display_window() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("region.exr");
        let region = Region {
            x: 7,
            y: 11,
            width: 9,
            height: 5,
        };
        film(Background::Sky, region)
            .write_exr(&path, AovStyle::Blender)
            .unwrap();
        let image = read_back(&path);
        assert_eq!(image.attributes.display_window.size, Vec2(40, 30));
        assert_eq!(image.attributes.display_window.position, Vec2(0, 0));
        let layer = &image.layer_data[0];
        assert_eq!(layer.attributes.layer_position, Vec2(7, 11));
        assert_eq!(layer.size, Vec2(9, 5));
        let FlatSamples::F32(x) = channel(&image, "ViewLayer.Position.X") else {
            panic!("position should be float");
        };
        assert_eq!(x[..4], [0.0, 8.0, 9.0, 0.0]);
    }

    #[test]
    fn a_background_colour_lies_behind_in_linear_light() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("colour.exr");
        let color = Color([0.5, 0.25, 0.125]);
        film(Background::Color(color), Region::full(40, 30))
            .write_exr(&path, AovStyle::Plain)
            .unwrap();
        let image = read_back(&path);
        let FlatSamples::F16(red) = channel(&image, "R") else {
            panic!("R should be half");
        };
        assert_eq!((red[0].to_f32(), red[1].to_f32()), (0.5, 0.25));
    }

    #[test]
    fn an_unwritable_target_is_named() {
        let film = film(Background::Sky, Region::full(40, 30));
        let path = Path::new("/nonexistent-folder/picture.exr");
        let message = film
            .write_exr(path, AovStyle::Plain)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("/nonexistent-folder/picture.exr"),
            "{message}"
        );
    }
}
