//! GRO of GROMACS: a title, a count, atoms in fixed columns, a box; several frames. Lengths in nm,
//! velocities in nm/ps. The number of decimals is told by the distance between the points.

use super::atom_names::{Alignment, element};
use super::atoms::{Atom, Atoms};
use super::text::{float, lines, quote, unexpected};
use super::{ParseError, Parsed, Place};
use glam::DVec3;

/// Nanometres in an ångström.
const NM_PER_ANGSTROM: f64 = 0.1;
/// Where the numbers of a row start.
const NUMBERS: usize = 20;

/// A title, a count, and an atom in fixed columns.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 14)];
    let mut lines = lines(start, 1).map(|(_, line)| line).skip(1);
    let (Some(count_line), Some(atom)) = (lines.next(), lines.next()) else {
        return false;
    };
    let is_residue = atom
        .get(..5)
        .is_some_and(|text| text.trim_ascii().iter().all(u8::is_ascii_digit) && text != b"     ");
    count(count_line).is_some_and(|count| count > 0)
        && is_residue
        && column_width(atom).is_some_and(|width| row_numbers(atom, width, 0).is_some())
}

fn count(line: &[u8]) -> Option<usize> {
    let digits = line.trim_ascii();
    let is_number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
    std::str::from_utf8(digits)
        .ok()
        .filter(|_| is_number)?
        .parse()
        .ok()
}

/// Columns per number: the distance between the first two points of a row.
fn column_width(row: &[u8]) -> Option<usize> {
    let numbers = row.get(NUMBERS..)?;
    let mut points = numbers
        .iter()
        .enumerate()
        .filter(|(_, byte)| **byte == b'.')
        .map(|(at, _)| at);
    let (first, second) = (points.next()?, points.next()?);
    Some(second - first)
}

/// Three numbers from number `first` of a row on; `None` where one is missing or none.
fn row_numbers(row: &[u8], width: usize, first: usize) -> Option<[f64; 3]> {
    let mut numbers = [0.0; 3];
    for (k, number) in numbers.iter_mut().enumerate() {
        let start = NUMBERS + (first + k) * width;
        let end = (start + width).min(row.len());
        *number = float(row.get(start..end)?.trim_ascii())?;
    }
    Some(numbers)
}

/// Reads frame `frame`; the others are only counted.
pub(super) fn read(bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
    let mut lines = lines(bytes, 1);
    let (mut frames, mut found) = (0, None);
    let mut ignored = None;
    while let Some((number, title)) = lines.next() {
        // What follows the last box: blank lines, or nothing.
        if frames > 0 && title.trim_ascii().is_empty() {
            continue;
        }
        let result = read_frame(&mut lines, number, frames == frame);
        match result {
            Ok(atoms) => {
                frames += 1;
                found = atoms.or(found);
            }
            // A run that still writes leaves an unfinished frame at the end.
            Err(error) if found.is_some() => {
                ignored = Some(format!(
                    "frames from number {frames} on were ignored: {error}"
                ));
                break;
            }
            Err(error) => return Err(error),
        }
    }
    let mut parsed = found
        .unwrap_or_default()
        .into_parsed(NM_PER_ANGSTROM, frames)?;
    parsed.warnings.extend(ignored);
    Ok(parsed)
}

/// The atoms of the frame whose title stood in line `title`, if they are wanted.
fn read_frame<'a>(
    lines: &mut impl Iterator<Item = (u64, &'a [u8])>,
    title: u64,
    wanted: bool,
) -> Result<Option<Atoms>, ParseError> {
    let expected = "the number of atoms after the title";
    let (line, text) = lines.next().ok_or_else(|| {
        ParseError::new(
            Place::Line(title),
            format!("expected {expected}, the file ends"),
        )
    })?;
    let count = count(text).ok_or_else(|| unexpected(line, expected, text))?;
    let cut_short = |read: usize, line: u64| {
        let problem = format!("the file ends after {read} of the {count} atoms of this frame");
        ParseError::new(Place::Line(line), problem)
            .with_help("the file is cut short or the count is wrong; write it again")
    };
    let mut atoms = Atoms::default();
    let mut width = None;
    let mut last = line;
    for index in 0..count {
        let (line, row) = lines.next().ok_or_else(|| cut_short(index, last))?;
        last = line;
        if !wanted {
            continue;
        }
        let width = match width {
            Some(width) => width,
            None => *width.insert(column_width(row).ok_or_else(|| wrong_row(line, row))?),
        };
        atoms.push(&read_row(row, width).ok_or_else(|| {
            // The row after the last atom holds the box: three to nine numbers.
            if row_is_box(row) {
                cut_short(index, line)
            } else {
                wrong_row(line, row)
            }
        })?);
    }
    // The box; a file may end without it.
    lines.next();
    Ok(wanted.then_some(atoms))
}

fn row_is_box(row: &[u8]) -> bool {
    super::text::words(row).all(|word| float::<f64>(word).is_some())
}

fn wrong_row(line: u64, row: &[u8]) -> ParseError {
    let problem = format!(
        "expected an atom with x, y, z from column {} on, found {}",
        NUMBERS + 1,
        quote(row)
    );
    ParseError::new(Place::Line(line), problem)
}

fn read_row(row: &[u8], width: usize) -> Option<Atom<'_>> {
    let field = |columns: std::ops::Range<usize>| row.get(columns).map(<[u8]>::trim_ascii);
    let integer = |text: &[u8]| std::str::from_utf8(text).ok()?.parse::<i32>().ok();
    let position = row_numbers(row, width, 0)?;
    let velocity = row_numbers(row, width, 3).map(|v| v.map(|speed| speed as f32));
    let (residue_name, name) = (field(5..10)?, field(10..15)?);
    Some(Atom {
        position: DVec3::from_array(position),
        name,
        residue: integer(field(0..5)?).unwrap_or(0),
        serial: integer(field(15..20)?).unwrap_or(0),
        atomic_number: element(name, residue_name, Alignment::None),
        velocity,
        ..Atom::default()
    })
}

#[cfg(test)]
mod tests;
