//! Display-referred pictures, and PNG files of them.

use super::tone::{Tone, srgb_from_linear};
use super::{Film, FilmError, write_aside};
use crate::scene::Background;
use rayon::prelude::*;
use std::path::Path;

/// Bits per component of a PNG file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BitDepth {
    /// 8, with ordered dithering so that smooth gradients show no bands.
    #[default]
    Eight,
    /// 16.
    Sixteen,
}

/// The numbers of an [`Image`], row by row, components interleaved, sRGB-encoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Pixels {
    /// 0–255.
    Eight(Vec<u8>),
    /// 0–65535.
    Sixteen(Vec<u16>),
}

/// A picture as a screen shows it: sRGB with 3 components (RGB) or 4 (RGB and straight alpha).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 3 or 4.
    pub components: usize,
    /// The numbers.
    pub pixels: Pixels,
}

impl Film {
    /// Develops the film's region: tone curve, background, sRGB encoding. A transparent background
    /// gives an alpha channel; a colour appears exactly as it was named.
    pub fn develop(&self, tone: Tone, depth: BitDepth) -> Image {
        let region = self.region();
        let transparent = self.background() == Background::Transparent;
        let components = if transparent { 4 } else { 3 };
        let rows = (0..region.height as usize).into_par_iter();
        let pixels = match depth {
            BitDepth::Sixteen => Pixels::Sixteen(
                rows.flat_map_iter(|row| {
                    let encoded = self.encoded_row(tone, row).into_iter();
                    encoded.map(|x| (x * 65535.0).round() as u16)
                })
                .collect(),
            ),
            BitDepth::Eight => Pixels::Eight(
                rows.flat_map_iter(|row| {
                    let y = region.y as usize + row;
                    let encoded = self.encoded_row(tone, row).into_iter().enumerate();
                    encoded.map(move |(i, value)| {
                        let threshold = bayer(region.x as usize + i / components, y);
                        (value * 255.0 + threshold).floor().min(255.0) as u8
                    })
                })
                .collect(),
            ),
        };
        Image {
            width: region.width,
            height: region.height,
            components,
            pixels,
        }
    }

    /// One row of the region, encoded, components interleaved.
    fn encoded_row(&self, tone: Tone, row: usize) -> Vec<f32> {
        let width = self.region().width as usize;
        let mut encoded = Vec::with_capacity(width * 4);
        for pixel in row * width..(row + 1) * width {
            let [r, g, b, alpha] = self.rgba(pixel);
            match self.background() {
                Background::Sky => {
                    encoded.extend(tone.display([r, g, b]).map(srgb_from_linear));
                }
                Background::Transparent => {
                    let straight = straight([r, g, b], alpha);
                    encoded.extend(tone.display(straight).map(srgb_from_linear));
                    encoded.push(1.0 - self.backdrop(pixel));
                }
                Background::Color(color) => {
                    // Mixed as display light, behind the tone curve, which would change the colour.
                    let share = self.backdrop(pixel);
                    let front = tone.display(straight([r, g, b], 1.0 - share));
                    let back = color.to_f32();
                    let mixed = |c: usize| front[c] * (1.0 - share) + back[c] * share;
                    encoded.extend((0..3).map(|c| srgb_from_linear(mixed(c))));
                }
            }
        }
        encoded
    }
}

fn straight(premultiplied: [f32; 3], alpha: f32) -> [f32; 3] {
    if alpha > 0.0 {
        premultiplied.map(|x| x / alpha)
    } else {
        [0.0; 3]
    }
}

/// Threshold of Bayer's 8×8 ordered dither, in (0, 1) around 1/2: a number that is whole already
/// stays what it is.
fn bayer(x: usize, y: usize) -> f32 {
    let mut rank = 0;
    for bit in 0..3 {
        let (xb, yb) = (x >> bit & 1, y >> bit & 1);
        rank |= (2 * (xb ^ yb) + yb) << (2 * (2 - bit));
    }
    (rank as f32 + 0.5) / 64.0
}

impl Image {
    /// Writes a PNG file with an sRGB chunk, aside first.
    ///
    /// # Errors
    /// When the file cannot be written; nothing is left behind then.
    pub fn write_png(&self, path: &Path) -> Result<(), FilmError> {
        let failed = |error: png::EncodingError| match error {
            png::EncodingError::IoError(source) => FilmError::Write {
                path: path.to_owned(),
                source,
            },
            other => FilmError::Encode {
                path: path.to_owned(),
                message: other.to_string(),
            },
        };
        write_aside(path, |writer| {
            let mut encoder = png::Encoder::new(writer, self.width, self.height);
            encoder.set_color(if self.components == 4 {
                png::ColorType::Rgba
            } else {
                png::ColorType::Rgb
            });
            encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
            encoder.set_compression(png::Compression::Fast);
            let bytes: std::borrow::Cow<'_, [u8]> = match &self.pixels {
                Pixels::Eight(values) => {
                    encoder.set_depth(png::BitDepth::Eight);
                    values.into()
                }
                Pixels::Sixteen(values) => {
                    encoder.set_depth(png::BitDepth::Sixteen);
                    let big_endian = values.iter().flat_map(|v| v.to_be_bytes());
                    big_endian.collect::<Vec<u8>>().into()
                }
            };
            let mut png = encoder.write_header().map_err(failed)?;
            png.write_image_data(&bytes).map_err(failed)?;
            png.finish().map_err(failed)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{ChannelSet, Curve, PixelSample, Region};
    use crate::scene::Color;
    use std::sync::Arc;

    /// A ramp of light over a picture whose right half is half covered.
    fn ramp(background: Background) -> Film {
        let channels = Arc::new(ChannelSet::default());
        let mut film = Film::new([16, 4], Region::full(16, 4), channels, background).unwrap();
        for y in 0..4 {
            for x in 0..16 {
                let coverage = if x < 8 { 1.0 } else { 0.5 };
                let light = x as f32 / 15.0 * coverage;
                let seen = PixelSample {
                    radiance: [light, 0.5 * light, 0.0],
                    coverage,
                    backdrop: 1.0 - coverage,
                    albedo: [0.0; 3],
                    denoising_albedo: [0.0; 3],
                    surface: None,
                    attributes: &[],
                };
                film.add(x, y, 0, [0.0, 0.0], &seen);
            }
        }
        film
    }

    fn read_back(path: &Path) -> (png::OutputInfo, Vec<u8>, bool) {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let has_srgb = reader.info().srgb.is_some();
        (info, bytes, has_srgb)
    }

    #[test]
    fn png_reads_back_in_both_depths() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        for depth in [BitDepth::Eight, BitDepth::Sixteen] {
            let image = ramp(Background::Transparent).develop(Tone::default(), depth);
            image.write_png(&path).unwrap();
            let (info, bytes, has_srgb) = read_back(&path);
            assert!(has_srgb);
            assert_eq!((info.width, info.height), (16, 4));
            assert_eq!(info.color_type, png::ColorType::Rgba);
            let expected: Vec<u8> = match &image.pixels {
                Pixels::Eight(values) => values.clone(),
                Pixels::Sixteen(values) => values.iter().flat_map(|v| v.to_be_bytes()).collect(),
            };
            assert_eq!(bytes, expected);
        }
    }

    #[test]
    fn alpha_is_straight_in_png() {
        let linear = Tone {
            curve: Curve::Linear,
            ..Tone::default()
        };
        let image = ramp(Background::Transparent).develop(linear, BitDepth::Sixteen);
        let Pixels::Sixteen(values) = image.pixels else {
            panic!("16 bits were asked for");
        };
        let expected = srgb_from_linear(12.0 / 15.0) * 65535.0;
        assert!((f32::from(values[12 * 4]) - expected).abs() < 2.0);
        assert_eq!(values[12 * 4 + 3], 32768);
        assert_eq!(values[3], 65535);
    }

    #[test]
    fn a_background_colour_is_exact_and_dither_stays_within_one_step() {
        let color = Background::Color(Color::from_srgb8([17, 130, 254]));
        let channels = Arc::new(ChannelSet::default());
        let film = Film::new([8, 8], Region::full(8, 8), channels, color).unwrap();
        let Pixels::Eight(values) = film.develop(Tone::default(), BitDepth::Eight).pixels else {
            panic!("8 bits were asked for");
        };
        assert!(values.chunks(3).all(|rgb| rgb == [17, 130, 254]));

        let film = ramp(Background::Sky);
        let Pixels::Eight(eight) = film.develop(Tone::default(), BitDepth::Eight).pixels else {
            panic!("8 bits were asked for");
        };
        let Pixels::Sixteen(sixteen) = film.develop(Tone::default(), BitDepth::Sixteen).pixels
        else {
            panic!("16 bits were asked for");
        };
        for (&coarse, &fine) in eight.iter().zip(&sixteen) {
            assert!((f32::from(coarse) - f32::from(fine) / 257.0).abs() <= 1.0);
        }
    }

    #[test]
    fn the_dither_is_a_permutation_of_64_thresholds() {
        let mut ranks: Vec<u32> = (0..64)
            .map(|i| (bayer(i % 8, i / 8) * 64.0) as u32)
            .collect();
        ranks.sort_unstable();
        assert_eq!(ranks, (0..64).collect::<Vec<_>>());
    }
}
