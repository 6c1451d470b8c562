//! Environment images from files: Radiance HDR and OpenEXR.

use super::Environment;
use exr::prelude::{ReadChannels, ReadLayers};
use glam::DVec3;
use image::{ColorType, ImageDecoder};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Most texels of an environment: 16384 × 8192.
pub const MAX_TEXELS: u64 = 1 << 27;

/// Texels per byte that a Radiance file can have at most: a run of 127 takes two bytes in each of four
/// channels.
const TEXELS_PER_BYTE: u64 = 127 / 8 + 1;

/// Bytes of pixels per byte that an EXR file can have at most: deflate reaches 1032, no other of its
/// compressions comes near twice that.
const PIXEL_BYTES_PER_BYTE: u64 = 2048;

/// An environment image that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("environment {}: {message}", path.display())]
pub struct EnvironmentError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong.
    pub message: String,
}

impl Environment {
    /// Reads a Radiance HDR or OpenEXR file, told by content; `axes` and `rotation` as for
    /// [`Environment::new`].
    ///
    /// # Errors
    /// When the file cannot be read, is neither, or holds no colour image of sensible size.
    pub fn read(path: &Path, axes: [DVec3; 3], rotation: f64) -> Result<Self, EnvironmentError> {
        let failed = |message: String| EnvironmentError {
            path: path.to_owned(),
            message,
        };
        let (width, texels) = texels(path).map_err(failed)?;
        Ok(Self::new(width, texels, axes, rotation))
    }
}

fn texels(path: &Path) -> Result<(usize, Vec<[f32; 3]>), String> {
    let mut file = File::open(path).map_err(|error| format!("cannot be read: {error}"))?;
    let mut magic = [0; 4];
    file.read_exact(&mut magic)
        .and_then(|()| file.rewind())
        .map_err(|error| format!("cannot be read: {error}"))?;
    let length = file.metadata().map_or(u64::MAX, |data| data.len());
    match &magic {
        [0x76, 0x2f, 0x31, 0x01] => read_exr(path, length),
        b"#?RA" | b"#?RG" => read_hdr(file, length),
        _ => Err("is neither a Radiance (.hdr) nor an OpenEXR (.exr) image".to_owned()),
    }
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    if width == 0 || height == 0 || width.saturating_mul(height) > MAX_TEXELS {
        return Err(format!(
            "an image of {width} x {height} is not 1 to {MAX_TEXELS} pixels"
        ));
    }
    Ok(())
}

fn read_hdr(file: File, length: u64) -> Result<(usize, Vec<[f32; 3]>), String> {
    let wrong = |error: image::ImageError| format!("is damaged: {error}");
    let decoder = image::codecs::hdr::HdrDecoder::new(BufReader::new(file)).map_err(wrong)?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    if u64::from(width) * u64::from(height) > length.saturating_mul(TEXELS_PER_BYTE) {
        return Err(format!(
            "is damaged: {length} bytes cannot hold {width} x {height} pixels"
        ));
    }
    if decoder.color_type() != ColorType::Rgb32F {
        return Err("holds no colours".to_owned());
    }
    let mut bytes = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut bytes).map_err(wrong)?;
    let number = |bytes: &[u8]| f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let texels = bytes
        .chunks_exact(12)
        .map(|texel| [0, 4, 8].map(|at| number(&texel[at..])))
        .collect();
    Ok((width as usize, texels))
}

fn read_exr(path: &Path, length: u64) -> Result<(usize, Vec<[f32; 3]>), String> {
    let wrong = |error: exr::error::Error| format!("is damaged or holds no colours: {error}");
    let meta = exr::meta::MetaData::read_from_file(path, false).map_err(wrong)?;
    for header in &meta.headers {
        check_size(
            header.layer_size.width() as u64,
            header.layer_size.height() as u64,
        )?;
        if header.deep {
            continue;
        }
        // exr divides by these unasked.
        let channels = &header.channels.list;
        if channels.iter().any(|channel| channel.sampling.area() == 0) {
            return Err("is damaged: a channel has a sample every 0 pixels".to_owned());
        }
        let bytes = header.total_pixel_bytes() as u64;
        if bytes > length.saturating_mul(PIXEL_BYTES_PER_BYTE) {
            return Err(format!(
                "is damaged: {length} bytes cannot hold {} x {} pixels",
                header.layer_size.width(),
                header.layer_size.height()
            ));
        }
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.width(), vec![[0.0_f32; 3]; size.area()]),
            |(width, texels), at, (r, g, b, _): (f32, f32, f32, f32)| {
                texels[at.y() * *width + at.x()] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(wrong)?;
    Ok(image.layer_data.channel_data.pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    #[test]
    fn both_formats_read_back_what_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let texel = |x: usize, y: usize| [0.25 * x as f32, 0.5, 2.0 * y as f32];
        let [width, height] = [8, 4];
        let hdr = folder.path().join("sky.hdr");
        // Flat RGBE: mantissa/256 · 2^(exponent − 128).
        let mut bytes =
            format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
        for y in 0..height {
            for x in 0..width {
                bytes.extend(texel(x, y).map(|c| (c * 16.0) as u8));
                bytes.push(132);
            }
        }
        std::fs::write(&hdr, bytes).unwrap();
        let exr = folder.path().join("sky.exr");
        exr::prelude::write_rgb_file(&exr, width, height, |x, y| {
            let [r, g, b] = texel(x, y);
            (r, g, b)
        })
        .unwrap();
        for path in [hdr, exr] {
            let (found_width, texels) = texels(&path).unwrap();
            assert_eq!((found_width, texels.len()), (width, width * height));
            for (i, found) in texels.iter().enumerate() {
                let expected = texel(i % width, i / width);
                for c in 0..3 {
                    assert!(
                        (found[c] - expected[c]).abs() <= 0.04,
                        "{found:?} {expected:?}"
                    );
                }
            }
            assert!(Environment::read(&path, AXES, 0.0).is_ok());
        }
    }

    #[test]
    fn files_that_are_no_images_are_answered() {
        let folder = tempfile::tempdir().unwrap();
        let cases: [(&str, &[u8], &str); 5] = [
            ("empty.hdr", b"", "cannot be read"),
            ("text.exr", b"hello, world", "neither"),
            ("head.hdr", b"#?RADIANCE\n\n", "damaged"),
            (
                "huge.hdr",
                b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8000 +X 16000\n\x02\x02",
                "cannot hold",
            ),
            ("cut.exr", b"\x76\x2f\x31\x01\x02\0\0\0", "damaged"),
        ];
        for (name, bytes, what) in cases {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            let error = Environment::read(&path, AXES, 0.0).unwrap_err().to_string();
            assert!(error.contains(what) && error.contains(name), "{error}");
        }
        // A small image whose header is then made to promise 16384 x 8192 pixels.
        let promised = folder.path().join("promised.exr");
        exr::prelude::write_rgb_file(&promised, 8, 4, |_, _| (1.0_f32, 1.0_f32, 1.0_f32)).unwrap();
        let mut bytes = std::fs::read(&promised).unwrap();
        let key = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = bytes.windows(key.len()).position(|w| w == key).unwrap() + key.len() + 8;
        bytes[at..at + 4].copy_from_slice(&16_383_u32.to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&8191_u32.to_le_bytes());
        std::fs::write(&promised, bytes).unwrap();
        let error = Environment::read(&promised, AXES, 0.0).unwrap_err();
        assert!(error.to_string().contains("cannot hold"), "{error}");
        // One whose first channel then states a sample every 0 columns.
        let sampled = folder.path().join("sampled.exr");
        exr::prelude::write_rgb_file(&sampled, 8, 4, |_, _| (1.0_f32, 1.0_f32, 1.0_f32)).unwrap();
        let mut bytes = std::fs::read(&sampled).unwrap();
        let key = b"channels\0chlist\0";
        let list = bytes.windows(key.len()).position(|w| w == key).unwrap() + key.len() + 4;
        // Its name, a letter and its end; its type; whether it is linear, with three reserved bytes.
        let at = list + 2 + 4 + 4;
        assert_eq!(bytes[at..at + 4], 1_u32.to_le_bytes());
        bytes[at..at + 4].fill(0);
        std::fs::write(&sampled, bytes).unwrap();
        let error = Environment::read(&sampled, AXES, 0.0).unwrap_err();
        assert!(error.to_string().contains("every 0 pixels"), "{error}");
        let gone = Environment::read(Path::new("gone.hdr"), AXES, 0.0);
        assert!(gone.unwrap_err().to_string().contains("cannot be read"));
    }
}
