//! PLY (Turk 1994): ascii and binary in both byte orders, any property names and types.
//!
//! Particles are element `vertex`, else the first element that has x, y and z. Every other scalar
//! property becomes a column under its own name; list properties and other elements are skipped.

mod ascii;
mod binary;
mod header;

use super::{ParseError, Parsed, Place};
use header::{Element, Encoding, Header};

/// Whether the content starts like a PLY file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply") && bytes.get(3).is_some_and(u8::is_ascii_whitespace)
}

/// Reads the vertices.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let header = Header::parse(bytes)?;
    let vertices = choose(&header.elements)?;
    let (particles, mut body_warnings) = match header.encoding {
        Encoding::Ascii => ascii::read(bytes, &header, &vertices)?,
        Encoding::Binary(endian) => binary::read(bytes, &header, &vertices, endian)?,
    };
    let mut warnings = header.warnings;
    warnings.append(&mut body_warnings);
    Ok(Parsed {
        particles,
        frames: 1,
        warnings,
        left_out: 0,
    })
}

/// Which element holds the particles, and which of its properties are the position.
struct Vertices {
    element: usize,
    /// Indices of properties x, y and z.
    axes: [usize; 3],
    /// Indices of the other scalar properties that become columns.
    columns: Vec<usize>,
}

fn choose(elements: &[Element]) -> Result<Vertices, ParseError> {
    let named = elements.iter().position(|element| element.name == "vertex");
    let first = elements.iter().position(|element| axes(element).is_ok());
    let Some(element) = named
        .filter(|&index| axes(&elements[index]).is_ok())
        .or(first)
        .or(named)
    else {
        let names: Vec<&str> = elements
            .iter()
            .map(|element| element.name.as_str())
            .collect();
        return Err(ParseError::new(
            Place::Whole,
            format!(
                "no element \"vertex\" and none with properties x, y, z; elements: {}",
                if names.is_empty() {
                    "none".to_owned()
                } else {
                    names.join(", ")
                }
            ),
        )
        .with_help("particles need scalar properties x, y and z"));
    };
    let axes = axes(&elements[element])?;
    let properties = &elements[element].properties;
    let columns = (0..properties.len())
        .filter(|index| !axes.contains(index) && properties[*index].list_count.is_none())
        .collect();
    Ok(Vertices {
        element,
        axes,
        columns,
    })
}

fn axes(element: &Element) -> Result<[usize; 3], ParseError> {
    let find = |axis: &str| {
        let scalars = || {
            element
                .properties
                .iter()
                .enumerate()
                .filter(|(_, property)| property.list_count.is_none())
        };
        scalars()
            .find(|(_, property)| property.name == axis)
            .or_else(|| scalars().find(|(_, property)| property.name.eq_ignore_ascii_case(axis)))
            .map(|(index, _)| index)
            .ok_or_else(|| {
                let names: Vec<&str> = element
                    .properties
                    .iter()
                    .map(|property| property.name.as_str())
                    .collect();
                ParseError::new(
                    Place::Line(element.line),
                    format!(
                        "element \"{}\" has no property {axis}; it has {}",
                        element.name,
                        names.join(", ")
                    ),
                )
                .with_help("particles need scalar properties x, y and z")
            })
    };
    Ok([find("x")?, find("y")?, find("z")?])
}

/// The error for a body that ends too early.
fn cut_short(element: &Element, place: Place, whole_rows: usize) -> ParseError {
    ParseError::new(
        place,
        format!(
            "the header promises {} rows of element \"{}\", the file holds {whole_rows} whole ones",
            element.count, element.name
        ),
    )
    .with_help("the file is cut short or its header is wrong; write it again")
}

#[cfg(test)]
mod tests;
