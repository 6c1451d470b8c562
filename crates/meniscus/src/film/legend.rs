//! The legend of a picture coloured by an attribute: a colour bar as PNG, its numbers as JSON.

use super::image::{Image, Pixels};
use super::{FilmError, write_aside};
use crate::scene::ColorMap;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

const WIDTH: usize = 720;
const HEIGHT: usize = 112;
const MARGIN: usize = 56;
const TITLE_TOP: usize = 10;
const BAR_TOP: usize = 40;
const BAR_BOTTOM: usize = 72;
const LABEL_TOP: usize = 82;
const TICK_LENGTH: usize = 6;
const TICKS: usize = 5;
const INK: [u8; 3] = [32, 34, 38];

/// What the colours of a picture mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Legend {
    /// The attribute as the user wrote it.
    pub name: String,
    /// Its unit, where one is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The colour map.
    pub map: ColorMap,
    /// Values at the two ends of the map; values beyond have the colours of the ends.
    pub range: [f64; 2],
}

impl Legend {
    /// Where the legend of a picture goes: `picture.legend.png` and `picture.legend.json` beside
    /// `picture.png`.
    pub fn paths(picture: &Path) -> [PathBuf; 2] {
        ["legend.png", "legend.json"].map(|ending| picture.with_extension(ending))
    }

    /// Writes both files of [`Legend::paths`], each aside first.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_beside(&self, picture: &Path) -> Result<(), FilmError> {
        let [png, json] = Self::paths(picture);
        self.image().write_png(&png)?;
        write_aside(&json, |writer| {
            let failed = |source: std::io::Error| FilmError::Write {
                path: json.clone(),
                source,
            };
            serde_json::to_writer_pretty(&mut *writer, self).map_err(|e| failed(e.into()))?;
            writeln!(writer).map_err(failed)
        })
    }

    /// The colour bar with its name and five labelled ticks on white.
    pub fn image(&self) -> Image {
        let mut canvas = Canvas {
            pixels: vec![255; WIDTH * HEIGHT * 3],
        };
        let title = match &self.unit {
            Some(unit) => format!("{} [{unit}]", self.name),
            None => self.name.clone(),
        };
        canvas.text(&title, WIDTH / 2, TITLE_TOP, RasterHeight::Size20);

        let last = WIDTH - MARGIN - 1;
        for y in BAR_TOP..=BAR_BOTTOM {
            for x in MARGIN..=last {
                let t = (x - MARGIN) as f64 / (last - MARGIN) as f64;
                let on_frame = y == BAR_TOP || y == BAR_BOTTOM || x == MARGIN || x == last;
                canvas.set(x, y, if on_frame { INK } else { self.map.srgb(t) });
            }
        }
        let values = (0..TICKS).map(|i| {
            let t = i as f64 / (TICKS - 1) as f64;
            self.range[0] * (1.0 - t) + self.range[1] * t
        });
        let labels = labels(&values.collect::<Vec<_>>());
        for (i, label) in labels.iter().enumerate() {
            let x = MARGIN + i * (last - MARGIN) / (TICKS - 1);
            for y in BAR_BOTTOM..BAR_BOTTOM + TICK_LENGTH {
                canvas.set(x, y, INK);
            }
            canvas.text(label, x, LABEL_TOP, RasterHeight::Size16);
        }
        Image {
            width: WIDTH as u32,
            height: HEIGHT as u32,
            components: 3,
            pixels: Pixels::Eight(canvas.pixels),
        }
    }
}

/// The values as text, all with the same number of decimals: as many as tell them apart with three
/// digits, or in exponent form where they are very large or very small.
fn labels(values: &[f64]) -> Vec<String> {
    let largest = values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    if largest > 0.0 && !(1e-3..1e5).contains(&largest) {
        return values.iter().map(|v| format!("{v:.2e}")).collect();
    }
    let span = values.last().copied().unwrap_or(0.0) - values.first().copied().unwrap_or(0.0);
    let decimals = if span > 0.0 {
        (2.0 - span.log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        3
    };
    values.iter().map(|v| format!("{v:.decimals$}")).collect()
}

struct Canvas {
    pixels: Vec<u8>,
}

impl Canvas {
    fn set(&mut self, x: usize, y: usize, color: [u8; 3]) {
        if x < WIDTH && y < HEIGHT {
            self.pixels[(y * WIDTH + x) * 3..][..3].copy_from_slice(&color);
        }
    }

    /// One line of text around the column `center`, kept within the picture.
    fn text(&mut self, text: &str, center: usize, top: usize, height: RasterHeight) {
        let advance = get_raster_width(FontWeight::Regular, height);
        let fitting: Vec<char> = text.chars().take(WIDTH / advance).collect();
        let width = fitting.len() * advance;
        let left = center.saturating_sub(width / 2).min(WIDTH - width);
        for (i, character) in fitting.into_iter().enumerate() {
            let glyph = get_raster(character, FontWeight::Regular, height)
                .or_else(|| get_raster('?', FontWeight::Regular, height));
            for (row, line) in glyph.iter().flat_map(|g| g.rows().enumerate()) {
                for (column, &cover) in line.iter().enumerate().filter(|(_, cover)| **cover > 0) {
                    let shade = INK
                        .map(|ink| (255 - (255 - u32::from(ink)) * u32::from(cover) / 255) as u8);
                    self.set(left + i * advance + column, top + row, shade);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn legend() -> Legend {
        Legend {
            name: "velocity".into(),
            unit: Some("m/s".into()),
            map: ColorMap::Viridis,
            range: [0.0, 3.27],
        }
    }

    #[test]
    fn the_bar_runs_through_the_map() {
        let image = legend().image();
        let Pixels::Eight(pixels) = &image.pixels else {
            panic!("a legend has 8 bits");
        };
        let at = |x: usize| {
            let start = ((BAR_TOP + 10) * WIDTH + x) * 3;
            [pixels[start], pixels[start + 1], pixels[start + 2]]
        };
        assert_eq!(at(MARGIN), INK);
        let close = |a: [u8; 3], b: [u8; 3]| (0..3).all(|c| a[c].abs_diff(b[c]) <= 2);
        assert!(close(at(MARGIN + 1), ColorMap::Viridis.srgb(0.0)));
        assert!(close(at(WIDTH - MARGIN - 2), ColorMap::Viridis.srgb(1.0)));
        let inked = |rows: std::ops::Range<usize>| {
            let dark = |p: &[u8]| p.iter().all(|&c| c < 128);
            pixels[rows.start * WIDTH * 3..rows.end * WIDTH * 3]
                .chunks(3)
                .filter(|p| dark(p))
                .count()
        };
        assert!(inked(TITLE_TOP..BAR_TOP) > 100, "the title is drawn");
        assert!(inked(LABEL_TOP..HEIGHT) > 200, "the labels are drawn");
    }

    #[test]
    fn labels_tell_their_values_apart() {
        assert_eq!(labels(&[0.0, 1.635, 3.27]), ["0.00", "1.64", "3.27"]);
        assert_eq!(
            labels(&[998.0, 999.0, 1000.0]),
            ["998.00", "999.00", "1000.00"]
        );
        assert_eq!(labels(&[-2e7, 0.0, 2e7]), ["-2.00e7", "0.00e0", "2.00e7"]);
        assert_eq!(labels(&[5.0, 5.0]), ["5.000", "5.000"]);
        assert_eq!(labels(&[0.0, 46843.0]), ["0", "46843"]);
    }

    #[test]
    fn both_files_are_written_beside_the_picture() {
        let folder = tempfile::tempdir().unwrap();
        let picture = folder.path().join("frame_7.png");
        legend().write_beside(&picture).unwrap();
        assert!(folder.path().join("frame_7.legend.png").is_file());
        let json = std::fs::read_to_string(folder.path().join("frame_7.legend.json")).unwrap();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(value["map"], "viridis");
        assert_eq!(value["range"], serde_json::json!([0.0, 3.27]));
    }
}
