//! Raw f32 positions without any header: little-endian x y z triples, as splashsurf's `.xyz`.

use super::bytes::{Endian, Scalar, assemble};
use super::{ParseError, Parsed, Place};
use crate::particles::ColumnData;
use glam::DVec3;

const TRIPLE: usize = 12;
/// Triples that detection looks at, spread over the file.
const SAMPLES: usize = 4096;

/// Whether the bytes make sense as f32 triples. Nothing but the values can tell, so this format is
/// asked last: the length is a multiple of 12, the content is no text and not all zero, magnitudes
/// lie between 1e-12 and 1e12 (or are 0), and at most every 64th value is NaN or infinite.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let triples = bytes.len() / TRIPLE;
    if triples == 0 || !bytes.len().is_multiple_of(TRIPLE) {
        return false;
    }
    let step = triples.div_ceil(SAMPLES);
    let (mut values, mut not_finite, mut text) = (0, 0, true);
    let mut all_zero = true;
    for triple in bytes.chunks_exact(TRIPLE).step_by(step) {
        text &= triple
            .iter()
            .all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
        for &number in triple.as_chunks::<4>().0 {
            let value = f32::from_le_bytes(number);
            let magnitude = value.abs();
            values += 1;
            all_zero &= magnitude == 0.0;
            if !value.is_finite() {
                not_finite += 1;
            } else if magnitude != 0.0 && !(1e-12..=1e12).contains(&magnitude) {
                return false;
            }
        }
    }
    !text && !all_zero && not_finite * 64 <= values
}

/// Reads all triples.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    if !bytes.len().is_multiple_of(TRIPLE) {
        return Err(ParseError::new(
            Place::Byte((bytes.len() / TRIPLE * TRIPLE) as u64),
            "the file ends inside a triple of 12 bytes",
        ));
    }
    let ColumnData::F32(values) = Scalar::F32.gather(bytes, TRIPLE, 0, 3, Endian::Little) else {
        unreachable!("a gather of f32 gives f32")
    };
    let positions = values
        .as_chunks::<3>()
        .0
        .iter()
        .map(|&[x, y, z]| DVec3::new(x.into(), y.into(), z.into()))
        .collect();
    Ok(Parsed {
        particles: assemble(positions, Vec::new())?,
        frames: 1,
        warnings: Vec::new(),
        left_out: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw(values: &[f32]) -> Vec<u8> {
        values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect()
    }

    #[test]
    fn triples_are_read_and_recognised() {
        let bytes = raw(&[0.5, -1.25, 3.0, 1e-3, 0.0, -7e5]);
        assert!(detect(&bytes));
        let parsed = read(&bytes, 0).unwrap();
        assert_eq!(
            parsed.particles.positions,
            [
                DVec3::new(0.5, -1.25, 3.0),
                DVec3::new(f64::from(1e-3_f32), 0.0, -7e5)
            ]
        );
        assert!(parsed.particles.columns.is_empty());
    }

    #[test]
    fn other_content_is_not_recognised() {
        assert!(!detect(b""));
        assert!(!detect(b"1.0 2.0 3.0\n"), "text of 12 bytes");
        assert!(!detect(&[0; 120]), "zeros");
        assert!(!detect(&raw(&[1.0, 2.0, 3.0, 4.0])), "not a multiple of 12");
        assert!(!detect(&raw(&[1.0, 2.0, 1e30])), "far too large");
        assert!(
            !detect(&raw(&[1.0, 2.0, f32::from_bits(3)])),
            "a small integer"
        );
        assert!(!detect(&raw(&[1.0, f32::NAN, 3.0])), "mostly not finite");
        let mut many = vec![1.0_f32; 3000];
        many[7] = f32::NAN;
        assert!(detect(&raw(&many)), "one NaN among many");
    }

    #[test]
    fn a_cut_file_is_an_error_with_its_place() {
        let error = read(&raw(&[1.0, 2.0, 3.0, 4.0]), 0).unwrap_err();
        assert_eq!(error.place, Place::Byte(12));
    }
}
