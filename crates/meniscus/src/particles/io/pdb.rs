//! PDB: text in fixed columns, `ATOM` and `HETATM` records, models as frames.
//!
//! Format description 3.3 of the wwPDB, and what simulation programs make of it: no element column,
//! four-letter residue names, segments in place of chains, serial numbers beyond their five columns
//! (hybrid-36, hexadecimal, shifted or starred), frames parted by `END` alone. `ANISOU` gives the atom
//! before it its displacements. `CRYST1` is ignored: nothing is wrapped or repeated.

use super::atom_names::{Alignment, element};
use super::atoms::{Atom, Atoms, Displacements};
use super::text::{float, lines, quote};
use super::{ParseError, Parsed, Place};
use crate::particles::elements::atomic_number;
use glam::DVec3;
use std::ops::Range;

/// Records that a PDB file may start with.
const FIRST_RECORDS: [&[u8]; 10] = [
    b"HEADER", b"TITLE ", b"COMPND", b"REMARK", b"CRYST1", b"ATOM  ", b"HETATM", b"MODEL ",
    b"AUTHOR", b"OBSLTE",
];

/// Where the coordinates stand, and how messages name the columns.
const COORDINATES: [(Range<usize>, &str); 3] = [
    (30..38, "x in columns 31 to 38"),
    (38..46, "y in columns 39 to 46"),
    (46..54, "z in columns 47 to 54"),
];

/// Where serial, name, alternate location, residue and chain of an atom stand: ANISOU repeats them.
const IDENTITY: Range<usize> = 6..27;

/// Whether the first record is one of PDB's, or an atom comes early.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 14)];
    FIRST_RECORDS.iter().any(|record| start.starts_with(record))
        || lines(start, 1)
            .take(200)
            .any(|(_, line)| is_atom(line) && line.len() > 46)
}

fn is_atom(line: &[u8]) -> bool {
    // Serials of seven digits reach into the record's name.
    line.starts_with(b"ATOM ") || line.starts_with(b"HETATM")
}

/// Reads model `frame`; the others are only counted.
pub(super) fn read(bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
    let mut atoms = Atoms::default();
    let mut serials = Serials::default();
    let (mut frames, mut in_frame) = (0, 0_usize);
    let mut starred = 0_usize;
    let mut lost = 0_usize;
    let mut last: Option<(&[u8], Option<usize>)> = None;
    for (number, line) in lines(bytes, 1) {
        if is_atom(line) {
            if frames == frame {
                let (atom, is_starred) = atom(line, number, &mut serials)?;
                starred += usize::from(is_starred);
                last = Some((line, atoms.push(&atom)));
            }
            in_frame += 1;
        } else if line.starts_with(b"ANISOU") {
            if frames == frame {
                let is_same = |other: &[u8]| line.get(IDENTITY) == other.get(IDENTITY);
                match last {
                    Some((other, Some(at))) if is_same(other) => {
                        atoms.displace(at, displacements(line));
                    }
                    // Its atom was left out.
                    Some((other, None)) if is_same(other) => {}
                    _ => lost += 1,
                }
            }
        } else if (line.starts_with(b"MODEL") || line.starts_with(b"END")) && in_frame > 0 {
            (frames, in_frame) = (frames + 1, 0);
        }
    }
    frames += usize::from(in_frame > 0);
    if frames == 0 {
        return Err(ParseError::new(
            Place::Whole,
            "there is no ATOM or HETATM record",
        ));
    }
    let mut parsed = atoms.into_parsed(1.0, frames)?;
    if lost > 0 {
        parsed.warnings.push(format!(
            "{lost} ANISOU records were left out that do not follow their atom"
        ));
    }
    if starred > 0 {
        parsed.warnings.push(format!(
            "{starred} atoms have coordinates that did not fit their columns (*****)"
        ));
    }
    Ok(parsed)
}

/// The bytes of some columns without the blanks around them, as far as the line goes.
fn field(line: &[u8], columns: Range<usize>) -> &[u8] {
    let end = columns.end.min(line.len());
    line.get(columns.start..end)
        .unwrap_or_default()
        .trim_ascii()
}

fn atom<'a>(
    line: &'a [u8],
    number: u64,
    serials: &mut Serials,
) -> Result<(Atom<'a>, bool), ParseError> {
    let mut position = [0.0; 3];
    let mut is_starred = false;
    for (coordinate, (columns, what)) in position.iter_mut().zip(COORDINATES) {
        let text = field(line, columns);
        *coordinate = if text.starts_with(b"**") {
            is_starred = true;
            f64::NAN
        } else {
            float(text).ok_or_else(|| wrong_coordinate(line, number, text, what))?
        };
    }
    let name = field(line, 12..16);
    // Simulation programs use column 21 for residue names of four letters.
    let residue_name = field(line, 17..21);
    let mut four = [b' '; 4];
    for (to, from) in four.iter_mut().zip(line.get(12..16).unwrap_or_default()) {
        *to = *from;
    }
    let (residue, insertion) = residue_number(field(line, 22..27));
    let chain = match field(line, 21..22) {
        [] => field(line, 72..76),
        chain => chain,
    };
    let stated = field(line, 76..78);
    let is_symbol = !stated.is_empty() && stated.iter().all(u8::is_ascii_alphabetic);
    let atomic_number = match atomic_number(stated) {
        number if is_symbol && number > 0 => Some(number),
        _ => element(name, residue_name, Alignment::Pdb(four)),
    };
    let number_in = |columns| float::<f32>(field(line, columns)).filter(|x| x.is_finite());
    let atom = Atom {
        position: DVec3::from_array(position),
        name,
        chain,
        residue,
        insertion,
        serial: serials.next(line),
        atomic_number,
        hetero: line.starts_with(b"HETATM"),
        alternate: field(line, 16..17),
        occupancy: number_in(54..60),
        b_factor: number_in(60..66),
        charge: charge(field(line, 78..80)),
        velocity: None,
    };
    Ok((atom, is_starred))
}

/// The displacements of an ANISOU record, which counts in 10⁻⁴ Å²; NaN where they are no numbers.
fn displacements(line: &[u8]) -> Displacements {
    [28, 35, 42, 49, 56, 63].map(|start| {
        let number = float::<f32>(field(line, start..start + 7));
        number.map_or(f32::NAN, |u| u * 1e-4)
    })
}

fn wrong_coordinate(line: &[u8], number: u64, text: &[u8], what: &str) -> ParseError {
    let problem = if text.is_empty() {
        format!(
            "expected {what}, but the line ends or is blank there ({} bytes)",
            line.len()
        )
    } else {
        format!("expected {what}, found {}", quote(text))
    };
    ParseError::new(Place::Line(number), problem)
        .with_help("PDB has fixed columns; write the file again, or as mmCIF, GRO or XYZ")
}

/// The serial numbers of a model, in whatever way they outgrow five digits.
#[derive(Debug, Default)]
struct Serials {
    last: i32,
}

impl Serials {
    fn next(&mut self, line: &[u8]) -> i32 {
        let start = if line.starts_with(b"HETATM") { 6 } else { 4 };
        let text = field(line, start..12);
        // Past 99999 VMD counts in hexadecimal: 186a0 follows.
        let hexadecimal = std::str::from_utf8(text)
            .ok()
            .and_then(|text| i32::from_str_radix(text, 16).ok())
            .filter(|&number| self.last >= 99_999 && number == self.last.saturating_add(1));
        self.last = hexadecimal
            .or_else(|| decimal(text))
            .or_else(|| hybrid_36(text, 5))
            .unwrap_or(self.last.saturating_add(1));
        self.last
    }
}

fn decimal(text: &[u8]) -> Option<i32> {
    std::str::from_utf8(text).ok()?.parse().ok()
}

/// Hybrid-36 (R. W. Grosse-Kunstleve, cctbx): `A0000` follows `99999`, `a0000` follows `ZZZZZ`.
fn hybrid_36(text: &[u8], width: u32) -> Option<i32> {
    let first = *text.first()?;
    if text.len() != width as usize || !first.is_ascii_alphabetic() {
        return None;
    }
    let is_upper = first.is_ascii_uppercase();
    let digit = |&byte: &u8| match byte {
        b'0'..=b'9' => Some(i64::from(byte - b'0')),
        b'A'..=b'Z' if is_upper => Some(i64::from(byte - b'A') + 10),
        b'a'..=b'z' if !is_upper => Some(i64::from(byte - b'a') + 10),
        _ => None,
    };
    let value = text
        .iter()
        .try_fold(0_i64, |value, byte| Some(value * 36 + digit(byte)?))?;
    let block = 36_i64.pow(width - 1);
    let offset = if is_upper { -10 } else { 16 } * block;
    i32::try_from(value + offset + 10_i64.pow(width)).ok()
}

/// A residue's number and insertion code. Programs with more than 9999 residues use the column of the
/// insertion code for a fifth digit.
fn residue_number(text: &[u8]) -> (i32, &[u8]) {
    if let Some(number) = decimal(text) {
        return (number, &[]);
    }
    if let Some((last, digits)) = text.split_last()
        && last.is_ascii_alphabetic()
        && let Some(number) = decimal(digits.trim_ascii_end())
    {
        return (number, std::slice::from_ref(last));
    }
    let head = &text[..text.len().min(4)];
    (hybrid_36(head, 4).unwrap_or(0), &text[head.len()..])
}

/// `2+`, `1-`, also `+2`.
fn charge(text: &[u8]) -> Option<i8> {
    let (digit, sign) = match text {
        [digit, sign] if digit.is_ascii_digit() => (digit, sign),
        [sign, digit] if digit.is_ascii_digit() => (digit, sign),
        _ => return None,
    };
    let size = (digit - b'0') as i8;
    match sign {
        b'+' => Some(size),
        b'-' => Some(-size),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
