//! Classic Houdini geometry, binary (`Bgeo` V 5, big endian), as SPlisHSPlasH, splashsurf and partio
//! write it: point positions and point attributes; primitives are skipped.

use super::bytes::{Endian, Scalar, assemble, gather_positions};
use super::{ParseError, Parsed, Place};
use crate::particles::Column;
use rayon::prelude::*;

const MAGIC: &[u8] = b"BgeoV";

/// Attribute types of the format.
pub(super) mod kind {
    pub(in super::super) const FLOAT: i32 = 0;
    pub(in super::super) const INT: i32 = 1;
    pub(in super::super) const INDEX: i32 = 4;
    pub(in super::super) const VECTOR: i32 = 5;
}

/// Whether the content starts like classic BGEO.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Numbers from the front of a file.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, size: usize) -> Result<&'a [u8], ParseError> {
        let rest = &self.bytes[self.at..];
        let taken = rest.get(..size).ok_or_else(|| {
            ParseError::new(
                Place::Byte(self.at as u64),
                format!(
                    "expected {size} more bytes, the file ends after {}",
                    rest.len()
                ),
            )
            .with_help("the file is cut short; write it again")
        })?;
        self.at += size;
        Ok(taken)
    }

    fn u16(&mut self) -> Result<usize, ParseError> {
        let bytes = self.take(2)?;
        Ok(usize::from(u16::from_be_bytes([bytes[0], bytes[1]])))
    }

    fn i32(&mut self) -> Result<i32, ParseError> {
        let bytes = self.take(4)?;
        Ok(i32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn count(&mut self, what: &str) -> Result<usize, ParseError> {
        let place = Place::Byte(self.at as u64);
        let count = self.i32()?;
        usize::try_from(count)
            .map_err(|_| ParseError::new(place, format!("a negative number of {what}: {count}")))
    }
}

/// A point attribute: where its numbers are in a point's record.
struct Attribute {
    name: String,
    kind: i32,
    components: usize,
    offset: usize,
}

/// Reads the points.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    if !detect(bytes) {
        return Err(ParseError::new(Place::Byte(0), "expected \"BgeoV\""));
    }
    let mut cursor = Cursor {
        bytes,
        at: MAGIC.len(),
    };
    let version = cursor.i32()?;
    if version != 5 {
        return Err(ParseError::new(
            Place::Byte(MAGIC.len() as u64),
            format!("version {version} of classic BGEO, expected 5"),
        ));
    }
    let points = cursor.count("points")?;
    for what in ["primitives", "point groups", "primitive groups"] {
        cursor.count(what)?;
    }
    let attribute_count = cursor.count("point attributes")?;
    for what in [
        "vertex attributes",
        "primitive attributes",
        "detail attributes",
    ] {
        cursor.count(what)?;
    }

    let mut attributes = Vec::new();
    let mut stride = 4 * size_of::<f32>();
    for _ in 0..attribute_count {
        let (attribute, size) = attribute(&mut cursor, stride)?;
        stride += size;
        attributes.push(attribute);
    }

    let room = bytes.len() - cursor.at;
    if points > room / stride {
        return Err(ParseError::new(
            Place::Byte(bytes.len() as u64),
            format!(
                "the header promises {points} points of {stride} bytes, the file holds {} whole ones",
                room / stride
            ),
        )
        .with_help("the file is cut short or its header is wrong; write it again"));
    }
    let records = cursor.take(points * stride)?;
    let axis = |index: usize| (Scalar::F32, index * size_of::<f32>());
    let mut positions = gather_positions(records, stride, [axis(0), axis(1), axis(2)], Endian::Big);
    for (position, record) in positions.iter_mut().zip(records.chunks_exact(stride)) {
        let w = Scalar::F32
            .decode(&record[12..], Endian::Big)
            .unwrap_or(1.0);
        if w != 1.0 && w != 0.0 {
            *position /= w;
        }
    }
    let (numbers, strings): (Vec<_>, Vec<_>) = attributes
        .into_iter()
        .partition(|attribute| attribute.kind != kind::INDEX);
    let columns = numbers
        .par_iter()
        .filter(|attribute| attribute.components > 0)
        .map(|attribute| {
            let scalar = if attribute.kind == kind::INT {
                Scalar::I32
            } else {
                Scalar::F32
            };
            let components = attribute.components;
            let data = scalar.gather(records, stride, attribute.offset, components, Endian::Big);
            Column::new(&attribute.name, components, data)
        })
        .collect();
    let warnings = strings
        .iter()
        .map(|attribute| {
            format!(
                "attribute \"{}\" holds text and was skipped",
                attribute.name
            )
        })
        .collect();
    Ok(Parsed {
        particles: assemble(positions, columns)?,
        frames: 1,
        warnings,
        left_out: 0,
    })
}

/// Reads an attribute's declaration; also gives its bytes per point.
fn attribute(cursor: &mut Cursor, offset: usize) -> Result<(Attribute, usize), ParseError> {
    let length = cursor.u16()?;
    let name = String::from_utf8_lossy(cursor.take(length)?).into_owned();
    let components = cursor.u16()?;
    let place = Place::Byte(cursor.at as u64);
    let kind = cursor.i32()?;
    match kind {
        kind::FLOAT | kind::INT | kind::VECTOR => {
            cursor.take(components * size_of::<f32>())?; // default values
        }
        kind::INDEX => {
            for _ in 0..cursor.count("strings")? {
                let length = cursor.u16()?;
                cursor.take(length)?;
            }
        }
        other => {
            return Err(ParseError::new(
                place,
                format!(
                    "point attribute \"{name}\" has type {other}, expected 0 (float), 1 (int), 4 (index) or 5 (vector)"
                ),
            ));
        }
    }
    let attribute = Attribute {
        name,
        kind,
        components,
        offset,
    };
    Ok((attribute, components * size_of::<f32>()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::ColumnData;
    use glam::DVec3;

    /// Two points with w = 1 and w = 2, a float, an index, an int pair and a vector attribute.
    fn file() -> Vec<u8> {
        let mut file = b"BgeoV".to_vec();
        let mut put = |numbers: &[i32]| {
            numbers
                .iter()
                .for_each(|number| file.extend(number.to_be_bytes()));
        };
        put(&[5, 2, 0, 0, 0, 4, 0, 0, 0]);
        let mut declare = |name: &str, size: u16, kind: i32, rest: &[u8]| {
            file.extend((name.len() as u16).to_be_bytes());
            file.extend(name.as_bytes());
            file.extend(size.to_be_bytes());
            file.extend(kind.to_be_bytes());
            file.extend(rest);
        };
        declare("density", 1, kind::FLOAT, &[0; 4]);
        declare("label", 1, kind::INDEX, b"\0\0\0\x01\0\x03abc");
        declare("pair", 2, kind::INT, &[0; 8]);
        declare("velocity", 3, kind::VECTOR, &[0; 12]);
        for w in [1.0_f32, 2.0] {
            for x in [1.0, -2.0, 4.0, w, 0.5] {
                file.extend(x.to_be_bytes());
            }
            for k in [0_i32, 7, -8] {
                file.extend(k.to_be_bytes());
            }
            for v in [w, 0.0, -1.0] {
                file.extend(v.to_be_bytes());
            }
        }
        file
    }

    #[test]
    fn points_and_attributes_are_read() {
        assert!(detect(&file()));
        let parsed = read(&file(), 0).unwrap();
        let positions = [DVec3::new(1.0, -2.0, 4.0), DVec3::new(0.5, -1.0, 2.0)];
        assert_eq!(parsed.particles.positions, positions);
        let columns = &parsed.particles.columns;
        assert_eq!(columns.len(), 3);
        assert_eq!(columns[0], Column::new("density", 1, vec![0.5_f32; 2]));
        assert_eq!(columns[1], Column::new("pair", 2, vec![7, -8, 7, -8]));
        assert_eq!(
            columns[2].data,
            ColumnData::F32(vec![1.0, 0.0, -1.0, 2.0, 0.0, -1.0])
        );
        assert!(
            parsed.warnings[0].contains("label"),
            "{:?}",
            parsed.warnings
        );
    }

    #[test]
    fn a_file_cut_anywhere_is_an_error() {
        let file = file();
        for length in MAGIC.len()..file.len() {
            let error = read(&file[..length], 0).unwrap_err();
            assert!(error.help.is_some(), "cut at {length}: {error}");
        }
    }

    #[test]
    fn wrong_headers_are_errors() {
        let with = |at: usize, number: i32| {
            let mut file = file();
            file[at..at + 4].copy_from_slice(&number.to_be_bytes());
            read(&file, 0).unwrap_err()
        };
        assert!(read(b"Bge", 0).is_err());
        assert!(with(5, 4).problem.contains("version 4"));
        assert!(with(9, -1).problem.contains("negative number of points"));
        assert!(with(9, i32::MAX).problem.contains("promises 2147483647"));
        assert!(with(25, i32::MAX).problem.contains("expected"));
        assert!(with(41 + 2 + 7 + 2, 2).problem.contains("has type 2"));
    }
}
