//! Golden pictures: comparison with a budget, and a difference picture where it is exceeded.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};

/// An 8-bit RGB picture, rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width · height` pixels.
    pub pixels: Vec<[u8; 3]>,
}

/// How far a picture may be from its golden one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// A channel that differs by more than this makes its pixel count as different.
    pub channel: u8,
    /// At most this fraction of the pixels may count as different.
    pub pixels: f64,
    /// Mean absolute difference of all channels, at most.
    pub mean: f64,
}

impl Default for Budget {
    /// SIMD levels and platforms differ in the last bits of f32, which moves a channel by one step, and
    /// the odd pixel on a silhouette by more.
    fn default() -> Self {
        Self {
            channel: 2,
            pixels: 1e-3,
            mean: 0.05,
        }
    }
}

/// How two pictures of the same size differ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Largest difference of a channel.
    pub largest: u8,
    /// Mean absolute difference of all channels.
    pub mean: f64,
    /// Fraction of pixels with a channel further off than [`Budget::channel`].
    pub pixels: f64,
}

impl Picture {
    /// Reads an 8-bit RGB or RGBA PNG (alpha is dropped).
    ///
    /// # Panics
    /// When the file is missing or something else.
    pub fn read(path: &Path) -> Self {
        let file = File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut reader = png::Decoder::new(BufReader::new(file))
            .read_info()
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let (color, depth) = reader.output_color_type();
        assert_eq!(depth, png::BitDepth::Eight, "{}", path.display());
        let size = reader
            .output_buffer_size()
            .expect("a picture that fits in memory");
        let mut bytes = vec![0; size];
        let info = reader
            .next_frame(&mut bytes)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let pixels = bytes[..info.buffer_size()]
            .chunks(color.samples())
            .map(|pixel| [pixel[0], pixel[1], pixel[2]])
            .collect();
        Self {
            width: info.width as usize,
            height: info.height as usize,
            pixels,
        }
    }

    /// Writes an 8-bit RGB PNG, and the folders above it.
    ///
    /// # Panics
    /// When that fails.
    pub fn write(&self, path: &Path) {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        }
        let file = File::create(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mut encoder =
            png::Encoder::new(BufWriter::new(file), self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder
            .write_header()
            .and_then(|mut writer| writer.write_image_data(self.pixels.as_flattened()))
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }

    /// Compares with a picture of the same size.
    pub fn difference(&self, other: &Self, channel: u8) -> Difference {
        let (mut largest, mut sum, mut over) = (0_u8, 0_u64, 0_usize);
        for (a, b) in self.pixels.iter().zip(&other.pixels) {
            let worst = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
            largest = largest.max(worst);
            over += usize::from(worst > channel);
            sum += (0..3).map(|c| u64::from(a[c].abs_diff(b[c]))).sum::<u64>();
        }
        let count = self.pixels.len().max(1) as f64;
        Difference {
            largest,
            mean: sum as f64 / (3.0 * count),
            pixels: over as f64 / count,
        }
    }

    /// Black where both agree, brighter with the difference (eightfold).
    fn difference_picture(&self, other: &Self) -> Self {
        let pixels = self
            .pixels
            .iter()
            .zip(&other.pixels)
            .map(|(a, b)| [0, 1, 2].map(|c| a[c].abs_diff(b[c]).saturating_mul(8)))
            .collect();
        Self {
            pixels,
            ..self.clone()
        }
    }
}

/// Compares `actual` with the golden picture in the file `golden`. Where the environment variable
/// `MENISCUS_UPDATE_GOLDEN` is set, `actual` becomes the golden picture instead.
///
/// # Panics
/// When the sizes differ or the budget is exceeded; `actual` and the difference are then in
/// `target/golden-failures`.
pub fn assert_golden(actual: &Picture, golden: &Path, budget: Budget) {
    if std::env::var_os("MENISCUS_UPDATE_GOLDEN").is_some() {
        actual.write(golden);
        return;
    }
    if let Some(complaint) = complaint(actual, golden, budget, &failures_folder()) {
        panic!("{complaint}");
    }
}

fn failures_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/golden-failures")
}

fn complaint(actual: &Picture, golden: &Path, budget: Budget, failures: &Path) -> Option<String> {
    let name = golden.file_stem().unwrap_or_default().to_string_lossy();
    let written = failures.join(format!("{name}.actual.png"));
    if !golden.is_file() {
        actual.write(&written);
        return Some(format!(
            "{} is missing; the picture is in {} (MENISCUS_UPDATE_GOLDEN=1 accepts it)",
            golden.display(),
            written.display()
        ));
    }
    let expected = Picture::read(golden);
    if (actual.width, actual.height) != (expected.width, expected.height) {
        actual.write(&written);
        return Some(format!(
            "{} is {} × {}, the picture {} × {}: {}",
            golden.display(),
            expected.width,
            expected.height,
            actual.width,
            actual.height,
            written.display()
        ));
    }
    let difference = actual.difference(&expected, budget.channel);
    if difference.pixels <= budget.pixels && difference.mean <= budget.mean {
        return None;
    }
    actual.write(&written);
    let shown = failures.join(format!("{name}.difference.png"));
    actual.difference_picture(&expected).write(&shown);
    Some(format!(
        "{}: {difference:?} exceeds {budget:?}; see {} and {}",
        golden.display(),
        written.display(),
        shown.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::{Budget, Picture, complaint};

    fn picture(value: u8) -> Picture {
        Picture {
            width: 20,
            height: 10,
            pixels: (0..200).map(|i| [value, i as u8, 7]).collect(),
        }
    }

    #[test]
    fn a_budget_is_kept_and_its_excess_shown() {
        let folder = tempfile::tempdir().unwrap();
        let golden = folder.path().join("scene.png");
        let judge = |actual: &Picture, pixels: f64| {
            let budget = Budget {
                pixels,
                ..Budget::default()
            };
            complaint(actual, &golden, budget, folder.path())
        };
        let missing = judge(&picture(100), 0.0).unwrap();
        assert!(missing.contains("missing"), "{missing}");
        picture(100).write(&golden);
        assert_eq!(Picture::read(&golden), picture(100));
        assert_eq!(judge(&picture(100), 0.0), None);
        let mut actual = picture(100);
        actual.pixels[17] = [103, 17, 7];
        assert_eq!(judge(&actual, 0.005), None);
        assert!(judge(&actual, 0.004).is_some());
        let shown = Picture::read(&folder.path().join("scene.difference.png"));
        assert_eq!(shown.pixels[17], [24, 0, 0]);
        assert_eq!(shown.pixels.iter().filter(|p| **p != [0; 3]).count(), 1);
        assert!(
            judge(&picture(102), 1.0).is_some(),
            "the mean is off by 0.67"
        );
        let mut smaller = picture(100);
        smaller.height = 5;
        smaller.pixels.truncate(100);
        assert!(judge(&smaller, 1.0).unwrap().contains("20 × 5"));
    }
}
