//! XYZ text: frames of a count, a comment and one row per atom; extended XYZ; and bare tables of
//! `x y z …` rows without any count.

mod bare;
mod layout;

use super::bytes::assemble;
use super::text::{float, lines, push, quote, unexpected, words};
use super::{ParseError, Parsed, Place};
use crate::particles::elements::atomic_number;
use crate::particles::{Column, Particles};
use glam::DVec3;
use layout::{Layout, Property, Role};

/// Whether the content is XYZ text: a count and rows that fit it, or bare rows of numbers.
pub(super) fn detect(bytes: &[u8]) -> bool {
    counted(bytes) || bare::detect(bytes)
}

/// Whether the first line is a count and the third one a row.
fn counted(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 16)];
    let mut lines = lines(start, 1).skip_while(|(_, line)| line.trim_ascii().is_empty());
    let Some(count) = lines.next().and_then(|(_, line)| count(line)) else {
        return false;
    };
    let (comment, row) = (lines.next(), lines.next());
    let described = comment.is_some_and(|(_, comment)| layout::properties(comment).is_some());
    match row {
        Some((_, row)) if count > 0 => {
            described
                || words(row)
                    .filter(|word| float::<f64>(word).is_some())
                    .count()
                    >= 3
        }
        _ => count == 0 || described || row.is_none() && comment.is_some(),
    }
}

/// The number on a line of its own.
fn count(line: &[u8]) -> Option<usize> {
    let digits = line.trim_ascii();
    let number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    std::str::from_utf8(digits)
        .ok()
        .filter(|_| number)?
        .parse()
        .ok()
}

/// Reads frame `frame`; the others are only counted.
pub(super) fn read(bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
    if !counted(bytes) {
        return bare::read(bytes);
    }
    let mut lines = lines(bytes, 1);
    let mut parsed = Parsed::default();
    let mut found = None;
    while let Some((number, line)) = lines
        .by_ref()
        .find(|(_, line)| !line.trim_ascii().is_empty())
    {
        let wanted = parsed.frames == frame;
        let result = count(line)
            .ok_or_else(|| unexpected(number, "the number of atoms of the next frame", line))
            .and_then(|count| {
                if wanted {
                    read_frame(&mut lines, number, count, bytes.len()).map(Some)
                } else {
                    skip_frame(&mut lines, number, count).map(|()| None)
                }
            });
        match result {
            Ok(frame) => {
                parsed.frames += 1;
                found = frame.or(found);
            }
            // A run that still writes leaves an unfinished frame at the end.
            Err(error) if found.is_some() => {
                parsed.warnings.push(format!(
                    "frames from number {} on were ignored: {error}",
                    parsed.frames
                ));
                break;
            }
            Err(error) => return Err(error),
        }
    }
    if let Some((particles, mut warnings)) = found {
        parsed.particles = particles;
        warnings.append(&mut parsed.warnings);
        parsed.warnings = warnings;
    }
    Ok(parsed)
}

fn skip_frame<'a>(
    lines: &mut impl Iterator<Item = (u64, &'a [u8])>,
    number: u64,
    count: usize,
) -> Result<(), ParseError> {
    // The comment and the rows; the iterator ends with the file, whatever the count says.
    match lines.nth(count) {
        Some(_) => Ok(()),
        None => Err(cut_short(Place::Line(number), count)),
    }
}

fn cut_short(place: Place, count: usize) -> ParseError {
    ParseError::new(
        place,
        format!("the file ends within this frame of {count} atoms"),
    )
    .with_help("the file is cut short or the count is wrong; write it again")
}

fn read_frame<'a>(
    lines: &mut impl Iterator<Item = (u64, &'a [u8])>,
    number: u64,
    count: usize,
    file_size: usize,
) -> Result<(Particles, Vec<String>), ParseError> {
    let cut = |line: u64| cut_short(Place::Line(line), count);
    let (mut last, comment) = lines.next().ok_or_else(|| cut(number))?;
    let mut layout = layout::properties(comment)
        .map(|properties| Layout::described(&properties, number + 1))
        .transpose()?;
    // A row takes at least "0 0 0" and its end.
    let mut positions = Vec::with_capacity(count.min(file_size / 6));
    let mut species = Vec::new();
    for _ in 0..count {
        let (number, row) = lines.next().ok_or_else(|| cut(last))?;
        last = number;
        if layout.is_none() {
            layout = Some(Layout::of_row(row, number)?);
        }
        if let Some(layout) = &mut layout {
            positions.push(read_row(row, number, layout, &mut species)?);
        }
    }
    let layout = layout.unwrap_or_default();
    let mut columns: Vec<Column> = Vec::new();
    // Rows that all have the dummy symbol X say nothing about elements.
    if species.iter().any(|&atom| atom != X) {
        let numbers: Vec<u8> = species
            .iter()
            .map(|&atom| if atom == X { 0 } else { atom })
            .collect();
        columns.push(Column::new("atomic_number", 1, numbers));
    }
    let (numbers, warnings) = layout.into_columns();
    columns.extend(numbers);
    Ok((assemble(positions, columns)?, warnings))
}

/// Marks the dummy symbol X among atomic numbers.
const X: u8 = u8::MAX;

fn read_row(
    row: &[u8],
    number: u64,
    layout: &mut Layout,
    species: &mut Vec<u8>,
) -> Result<DVec3, ParseError> {
    let mut words = words(row);
    let mut next = |property: &str| {
        words.next().ok_or_else(|| {
            let row = quote(row);
            let problem = format!("the row {row} ends before \"{property}\"");
            ParseError::new(Place::Line(number), problem)
        })
    };
    let mut position = [0.0; 3];
    for Property {
        name,
        components,
        role,
    } in &mut layout.properties
    {
        if *role == Role::Position {
            for coordinate in &mut position {
                let word = next(name)?;
                *coordinate =
                    float(word).ok_or_else(|| unexpected(number, "a coordinate", word))?;
            }
            continue;
        }
        for _ in 0..*components {
            let word = next(name)?;
            match role {
                Role::Species => {
                    species.push(if word == b"X" { X } else { atomic_number(word) });
                }
                Role::Flag(values) => {
                    values.push(u8::from(matches!(word, b"T" | b"True" | b"true" | b"1")));
                }
                Role::Number(data) => {
                    push(data, word).ok_or_else(|| unexpected(number, name, word))?;
                }
                Role::Position | Role::Text => {}
            }
        }
    }
    Ok(DVec3::from_array(position))
}

#[cfg(test)]
mod tests;
