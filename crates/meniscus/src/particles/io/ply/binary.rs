//! Binary bodies.

use super::header::{Element, Header, Property};
use super::{Vertices, cut_short};
use crate::particles::io::bytes::{Endian, assemble, gather_positions};
use crate::particles::io::{ParseError, Place};
use crate::particles::{Column, Particles};
use rayon::prelude::*;

/// Reads the vertices of a binary body; also says what is odd behind them.
pub(super) fn read(
    bytes: &[u8],
    header: &Header,
    vertices: &Vertices,
    endian: Endian,
) -> Result<(Particles, Vec<String>), ParseError> {
    let mut at = header.body;
    for element in &header.elements[..vertices.element] {
        at = skip(bytes, at, element, endian)?;
    }
    let element = &header.elements[vertices.element];
    let end = skip(bytes, at, element, endian)?;

    let packed;
    let (records, stride, offsets): (&[u8], usize, Vec<usize>) = match element.stride() {
        Some(stride) => {
            let offsets = (0..element.properties.len())
                .map(|property| element.offset(property))
                .collect();
            (&bytes[at..end], stride, offsets)
        }
        None => {
            let (offsets, stride) = packed_offsets(element);
            packed = without_lists(&bytes[at..end], element, endian, stride);
            (&packed, stride, offsets)
        }
    };
    let properties = &element.properties;
    let positions = gather_positions(
        records,
        stride,
        vertices
            .axes
            .map(|axis| (properties[axis].scalar, offsets[axis])),
        endian,
    );
    let columns = vertices
        .columns
        .par_iter()
        .map(|&index| {
            let Property { name, scalar, .. } = &properties[index];
            let data = scalar.gather(records, stride, offsets[index], 1, endian);
            Column::new(name, 1, data)
        })
        .collect();

    let mut warnings = Vec::new();
    let mut rest = Ok(end);
    for element in &header.elements[vertices.element + 1..] {
        rest = rest.and_then(|at| skip(bytes, at, element, endian));
    }
    match rest {
        Err(error) => warnings.push(format!("the particles are complete, but {}", error.problem)),
        Ok(rest) if bytes[rest..].iter().any(|byte| !byte.is_ascii_whitespace()) => {
            warnings.push(format!(
                "{} bytes behind the last element were ignored",
                bytes.len() - rest
            ));
        }
        Ok(_) => {}
    }
    Ok((assemble(positions, columns)?, warnings))
}

/// Where an element that starts at `at` ends.
fn skip(bytes: &[u8], at: usize, element: &Element, endian: Endian) -> Result<usize, ParseError> {
    let room = bytes.len() - at;
    if let Some(stride) = element.stride() {
        let size = usize::try_from(element.count)
            .ok()
            .and_then(|count| count.checked_mul(stride));
        return match size {
            Some(size) if size <= room => Ok(at + size),
            _ => Err(cut_short(
                element,
                Place::Byte(bytes.len() as u64),
                room / stride.max(1),
            )),
        };
    }
    // Each row holds at least the count of a list, so the loop ends with the file.
    let mut row_at = at;
    for row in 0..element.count {
        row_at = skip_row(bytes, row_at, element, endian)
            .ok_or_else(|| cut_short(element, Place::Byte(row_at as u64), row as usize))?;
    }
    Ok(row_at)
}

/// Where a row that starts at `at` ends; `None` if that is behind the end of the file.
fn skip_row(bytes: &[u8], mut at: usize, element: &Element, endian: Endian) -> Option<usize> {
    for property in &element.properties {
        at = at.checked_add(property_size(bytes.get(at..)?, property, endian)?)?;
    }
    (at <= bytes.len()).then_some(at)
}

/// Bytes that a property takes at the start of `bytes`; `None` without its count there, or where
/// the count is negative.
fn property_size(bytes: &[u8], property: &Property, endian: Endian) -> Option<usize> {
    let size = property.scalar.size();
    let Some(count_type) = property.list_count else {
        return Some(size);
    };
    let count = count_type.decode(bytes, endian)?;
    (count >= 0.0).then(|| {
        (count as usize)
            .saturating_mul(size)
            .saturating_add(count_type.size())
    })
}

/// Offsets of the properties, and the stride, when rows hold their scalars only.
fn packed_offsets(element: &Element) -> (Vec<usize>, usize) {
    let mut stride = 0;
    let offsets = element
        .properties
        .iter()
        .map(|property| {
            let offset = stride;
            if property.list_count.is_none() {
                stride += property.scalar.size();
            }
            offset
        })
        .collect();
    (offsets, stride)
}

/// The rows of an element without their lists. `bytes` are exactly the element's rows.
fn without_lists(bytes: &[u8], element: &Element, endian: Endian, stride: usize) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        packed.reserve(stride);
        for property in &element.properties {
            let size = property_size(&bytes[at..], property, endian).unwrap_or(0);
            if property.list_count.is_none() {
                packed.extend_from_slice(&bytes[at..at + size]);
            }
            at += size;
        }
    }
    packed
}
