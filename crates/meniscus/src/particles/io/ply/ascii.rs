//! Ascii bodies: one row per line.

use super::header::{Element, Header};
use super::{Vertices, cut_short};
use crate::particles::io::bytes::{assemble, empty_data};
use crate::particles::io::text::{lines, push, unexpected, words};
use crate::particles::io::{ParseError, Place};
use crate::particles::{Column, ColumnData, Particles};
use glam::DVec3;

/// Reads the vertices of an ascii body.
pub(super) fn read(
    bytes: &[u8],
    header: &Header,
    vertices: &Vertices,
) -> Result<(Particles, Vec<String>), ParseError> {
    let body = &bytes[header.body..];
    let mut rows =
        lines(body, header.body_line).filter(|(_, line)| !line.iter().all(u8::is_ascii_whitespace));
    for element in &header.elements[..vertices.element] {
        let lines = if element.properties.is_empty() {
            0
        } else {
            element.count
        };
        for row in 0..lines {
            if rows.next().is_none() {
                return Err(cut_short(element, Place::Whole, row as usize));
            }
        }
    }

    let element = &header.elements[vertices.element];
    // A row takes at least a digit and a space per property, so more do not fit.
    let room = body.len() / (2 * element.properties.len()) + 1;
    let capacity = usize::try_from(element.count).unwrap_or(room).min(room);
    let mut table: Vec<ColumnData> = element
        .properties
        .iter()
        .map(|property| match property.list_count {
            None => empty_data(property.scalar, capacity),
            Some(_) => ColumnData::U8(Vec::new()),
        })
        .collect();
    let mut missing_lists = 0_usize;
    let mut last_line = header.body_line;
    for row in 0..element.count {
        let Some((number, line)) = rows.next() else {
            return Err(cut_short(element, Place::Line(last_line), row as usize));
        };
        last_line = number;
        missing_lists += usize::from(!read_row(element, number, line, &mut table)?);
    }

    let mut warnings = Vec::new();
    if missing_lists > 0 {
        warnings.push(format!(
            "{missing_lists} rows lack the lists that the header promises"
        ));
    }
    let [x, y, z] = vertices.axes.map(|axis| &table[axis]);
    let positions = (0..x.len())
        .map(|i| DVec3::new(x.get(i), y.get(i), z.get(i)))
        .collect();
    let columns = vertices
        .columns
        .iter()
        .map(|&index| {
            let data = std::mem::replace(&mut table[index], ColumnData::U8(Vec::new()));
            Column::new(&element.properties[index].name, 1, data)
        })
        .collect();
    Ok((assemble(positions, columns)?, warnings))
}

/// Appends one row to the table; false if the row ended where a list was due.
fn read_row(
    element: &Element,
    number: u64,
    line: &[u8],
    table: &mut [ColumnData],
) -> Result<bool, ParseError> {
    let mut words = words(line);
    let mut complete = true;
    for (property, data) in element.properties.iter().zip(table) {
        let Some(word) = words.next() else {
            if property.list_count.is_some() {
                complete = false;
                continue;
            }
            return Err(ParseError::new(
                Place::Line(number),
                format!("the row ends before property \"{}\"", property.name),
            ));
        };
        if property.list_count.is_none() {
            push(data, word).ok_or_else(|| {
                let expected = format!("{} as {}", property.name, data.type_name());
                unexpected(number, &expected, word)
            })?;
            continue;
        }
        let count: usize = std::str::from_utf8(word)
            .ok()
            .and_then(|count| count.parse().ok())
            .ok_or_else(|| unexpected(number, "the length of a list", word))?;
        if count > 0 && words.nth(count - 1).is_none() {
            return Err(ParseError::new(
                Place::Line(number),
                format!(
                    "the row ends within list \"{}\" of {count} items",
                    property.name
                ),
            ));
        }
    }
    match words.next() {
        Some(extra) => Err(unexpected(number, "the end of the row", extra)),
        None => Ok(complete),
    }
}
