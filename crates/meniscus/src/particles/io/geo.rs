//! Classic Houdini geometry as text (`PGEOMETRY V5`): the points of a `.geo` file.

use super::bytes::{Scalar, assemble, empty_data};
use super::text::{float, lines, push, quote, unexpected, words};
use super::{ParseError, Parsed, Place};
use crate::particles::{Column, ColumnData};
use glam::DVec3;

/// Whether the content starts like classic GEO.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PGEOMETRY")
}

/// A point attribute; text attributes have no data.
struct Attribute {
    name: String,
    components: usize,
    data: Option<ColumnData>,
}

/// Reads the points.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let mut lines = lines(bytes, 1).filter(|(_, line)| words(line).next().is_some());
    let (first, version) = lines.next().unwrap_or((1, b""));
    if words(version).nth(1) != Some(b"V5") {
        return Err(unexpected(first, "PGEOMETRY V5", version));
    }
    let (points, attribute_count) = counts(&mut lines)?;
    let mut attributes = Vec::new();
    let mut table = lines.peekable();
    if attribute_count > 0 {
        match table.next() {
            Some((_, line)) if words(line).next() == Some(b"PointAttrib") => {}
            Some((number, line)) => return Err(unexpected(number, "PointAttrib", line)),
            None => return Err(ended("the point attributes")),
        }
    }
    for _ in 0..attribute_count {
        let (number, line) = table.next().ok_or_else(|| ended("the point attributes"))?;
        attributes.push(attribute(number, line)?);
    }
    let mut positions = Vec::with_capacity(points.min(bytes.len() / 8));
    for point in 0..points {
        let (number, line) = table
            .next()
            .ok_or_else(|| ended(&format!("point {} of {points}", point + 1)))?;
        positions.push(read_point(number, line, &mut attributes)?);
    }
    let mut warnings = Vec::new();
    let mut columns = Vec::new();
    for attribute in attributes {
        match attribute.data {
            Some(data) => columns.push(Column::new(attribute.name, attribute.components, data)),
            None => warnings.push(format!(
                "attribute \"{}\" holds text and was skipped",
                attribute.name
            )),
        }
    }
    Ok(Parsed {
        particles: assemble(positions, columns)?,
        frames: 1,
        warnings,
        left_out: 0,
    })
}

/// NPoints and NPointAttrib of the three lines of counts.
fn counts<'a>(
    lines: &mut impl Iterator<Item = (u64, &'a [u8])>,
) -> Result<(usize, usize), ParseError> {
    let (mut points, mut attributes) = (None, None);
    for _ in 0..3 {
        let (number, line) = lines.next().ok_or_else(|| ended("the counts"))?;
        let mut words = words(line);
        while let (Some(key), Some(value)) = (words.next(), words.next()) {
            let count = std::str::from_utf8(value)
                .ok()
                .and_then(|value| value.parse::<usize>().ok())
                .ok_or_else(|| {
                    unexpected(number, &format!("a count after {}", quote(key)), value)
                })?;
            match key {
                b"NPoints" => points = Some(count),
                b"NPointAttrib" => attributes = Some(count),
                _ => {}
            }
        }
    }
    points
        .zip(attributes)
        .ok_or_else(|| ParseError::new(Place::Line(2), "expected NPoints and NPointAttrib"))
}

fn attribute(number: u64, line: &[u8]) -> Result<Attribute, ParseError> {
    let mut words = words(line);
    let wrong = || unexpected(number, "an attribute's name, size and type", line);
    let name = String::from_utf8_lossy(words.next().ok_or_else(wrong)?).into_owned();
    let components = words
        .next()
        .and_then(|size| std::str::from_utf8(size).ok()?.parse::<u16>().ok())
        .filter(|&size| size > 0)
        .ok_or_else(wrong)?;
    let data = match words.next().ok_or_else(wrong)? {
        b"float" | b"vector" => Some(empty_data(Scalar::F32, 0)),
        b"int" => Some(empty_data(Scalar::I32, 0)),
        b"index" => None,
        other => return Err(unexpected(number, "float, int, vector or index", other)),
    };
    Ok(Attribute {
        name,
        components: components.into(),
        data,
    })
}

/// `x y z w (a b c<tab>d)`: the position, the attributes' numbers go to their columns.
fn read_point(number: u64, line: &[u8], attributes: &mut [Attribute]) -> Result<DVec3, ParseError> {
    let mut words = line
        .split(|byte| byte.is_ascii_whitespace() || *byte == b'(' || *byte == b')')
        .filter(|word| !word.is_empty());
    let mut next = |what: &str| {
        words.next().ok_or_else(|| {
            ParseError::new(Place::Line(number), format!("the point ends before {what}"))
        })
    };
    let mut homogeneous = [0.0; 4];
    for (axis, value) in ["x", "y", "z", "w"].iter().zip(&mut homogeneous) {
        let word = next(axis)?;
        *value = float(word).ok_or_else(|| unexpected(number, axis, word))?;
    }
    for attribute in attributes {
        for _ in 0..attribute.components {
            let word = next(&attribute.name)?;
            if let Some(data) = &mut attribute.data {
                push(data, word).ok_or_else(|| unexpected(number, &attribute.name, word))?;
            }
        }
    }
    let [x, y, z, w] = homogeneous;
    let scale = if w != 1.0 && w != 0.0 { w } else { 1.0 };
    Ok(DVec3::new(x, y, z) / scale)
}

fn ended(what: &str) -> ParseError {
    ParseError::new(Place::Whole, format!("the file ends before {what}"))
        .with_help("the file is cut short; write it again")
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "PGEOMETRY V5\nNPoints 2 NPrims 1\nNPointGroups 0 NPrimGroups 0\n\
        NPointAttrib 3 NVertexAttrib 0 NPrimAttrib 1 NAttrib 0\nPointAttrib\n\nlife 2 float 0 0\n\
        id 1 int 0\nname 1 index 1 papi\n0 0.5 -2 1 (-1.2 10\t0 0)\n2 4 6 2 (-0.2 10\t1 0)\nPrimitiveAttrib\n";

    #[test]
    fn points_and_attributes_are_read() {
        assert!(detect(FILE.as_bytes()));
        let parsed = read(FILE.as_bytes(), 0).unwrap();
        let positions = [DVec3::new(0.0, 0.5, -2.0), DVec3::new(1.0, 2.0, 3.0)];
        assert_eq!(parsed.particles.positions, positions);
        assert_eq!(
            parsed.particles.columns,
            [
                Column::new("life", 2, vec![-1.2_f32, 10.0, -0.2, 10.0]),
                Column::new("id", 1, vec![0, 1]),
            ]
        );
        assert!(parsed.warnings[0].contains("name"));
    }

    #[test]
    fn a_file_cut_before_its_last_point_is_an_error() {
        let end = FILE.find("PrimitiveAttrib").unwrap();
        for length in 0..end - " 0)\n".len() {
            assert!(
                read(&FILE.as_bytes()[..length], 0).is_err(),
                "cut at {length}"
            );
        }
    }

    #[test]
    fn errors_name_their_line() {
        let error = read(FILE.replace("4 6 2", "4 six 2").as_bytes(), 0).unwrap_err();
        assert_eq!(error.place, Place::Line(11));
        let error = read(FILE.replace("1 int", "1 quad").as_bytes(), 0).unwrap_err();
        assert!(error.problem.contains("quad"), "{error}");
        let error = read(
            FILE.replace("NPoints 2", "NPoints 999999999999").as_bytes(),
            0,
        )
        .unwrap_err();
        assert!(
            error.problem.contains("999999999999") || error.place == Place::Line(12),
            "{error}"
        );
    }
}
