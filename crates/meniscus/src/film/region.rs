//! Pixel rectangles.

use super::FilmError;

/// Largest width or height of a picture, in pixels.
pub(super) const MAX_SIDE: u32 = 1 << 16;
/// Most pixels that one film holds.
pub(super) const MAX_PIXELS: u64 = 1 << 28;

/// A pixel rectangle; (0, 0) is the top left pixel of the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Region {
    /// Left column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Region {
    /// The whole of a picture of this size.
    pub fn full(width: u32, height: u32) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Index of pixel (x, y) of the picture within the rectangle, row by row.
    pub fn index(&self, x: u32, y: u32) -> Option<usize> {
        let column = x.checked_sub(self.x).filter(|&c| c < self.width)?;
        let row = y.checked_sub(self.y).filter(|&r| r < self.height)?;
        Some(row as usize * self.width as usize + column as usize)
    }

    /// Whether `other` lies within this rectangle.
    pub fn contains(&self, other: &Self) -> bool {
        let end = |start: u32, length: u32| u64::from(start) + u64::from(length);
        other.x >= self.x
            && other.y >= self.y
            && end(other.x, other.width) <= end(self.x, self.width)
            && end(other.y, other.height) <= end(self.y, self.height)
    }

    /// The rectangle cut along the lines of the picture's grid of `side`×`side` tiles, row by row:
    /// whatever the rectangle, its tiles are parts of those of the whole picture.
    pub fn tiles(&self, side: u32) -> Vec<Self> {
        let cuts = |from: u32, length: u32| {
            let end = from + length;
            let side = side.max(1);
            let starts = std::iter::successors(Some(from), move |at| Some((at / side + 1) * side));
            starts
                .take_while(move |&at| at < end)
                .map(move |at| (at, end.min((at / side + 1) * side) - at))
        };
        cuts(self.y, self.height)
            .flat_map(|(y, height)| {
                cuts(self.x, self.width).map(move |(x, width)| Self {
                    x,
                    y,
                    width,
                    height,
                })
            })
            .collect()
    }

    /// Checks that a picture of `size` can be made and that the rectangle lies within it.
    pub(super) fn check(&self, size: [u32; 2]) -> Result<(), FilmError> {
        let [width, height] = size;
        let side_is_fine = |side: u32| (1..=MAX_SIDE).contains(&side);
        if !side_is_fine(width) || !side_is_fine(height) || self.pixels() > MAX_PIXELS {
            return Err(FilmError::Size {
                width,
                height,
                max_side: MAX_SIDE,
                max_pixels: MAX_PIXELS,
            });
        }
        if self.pixels() == 0 || !Self::full(width, height).contains(self) {
            return Err(FilmError::Region {
                x: self.x,
                y: self.y,
                width: self.width,
                height: self.height,
                film_width: width,
                film_height: height,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_region_once() {
        let region = Region {
            x: 3,
            y: 5,
            width: 70,
            height: 33,
        };
        let mut seen = vec![0; region.pixels() as usize];
        for tile in region.tiles(16) {
            assert!(region.contains(&tile));
            for y in tile.y..tile.y + tile.height {
                for x in tile.x..tile.x + tile.width {
                    seen[region.index(x, y).unwrap()] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        assert_eq!(region.index(2, 5), None);
        assert_eq!(region.index(73, 5), None);
        assert_eq!(region.index(72, 37), Some(70 * 33 - 1));
    }

    #[test]
    fn impossible_sizes_and_regions_are_errors() {
        assert!(Region::full(4, 3).check([4, 3]).is_ok());
        for (region, size) in [
            (Region::full(0, 3), [0, 3]),
            (Region::full(4, 3), [3, 4]),
            (Region::full(1, 1), [MAX_SIDE + 1, 1]),
            (Region::full(65_536, 65_536), [65_536, 65_536]),
            (
                Region {
                    x: u32::MAX,
                    y: 0,
                    width: 1,
                    height: 1,
                },
                [4, 4],
            ),
            (
                Region {
                    x: 1,
                    y: 1,
                    width: 0,
                    height: 1,
                },
                [4, 4],
            ),
        ] {
            assert!(region.check(size).is_err(), "{region:?} of {size:?}");
        }
    }
}
