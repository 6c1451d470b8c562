//! NPZ: a zip archive of arrays.

use super::bytes::assemble;
use super::npy::array::Array;
use super::npy::{POSITION_NAMES, take_positions};
use super::{ParseError, Parsed, Place, gzip};
use crate::particles::Column;
use npyz::npz::{NpzArchive, array_name_from_file_name};
use std::io::{Cursor, Read};

/// Whether the content is a zip archive whose first file is an array.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let Some([low, high]) = bytes.get(26..28) else {
        return false;
    };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    bytes.starts_with(b"PK\x03\x04")
        && bytes
            .get(30..30 + length)
            .is_some_and(|name| name.ends_with(b".npy"))
}

/// Reads the positions and every array with as many rows as a column.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let damaged = |error: String| {
        ParseError::new(Place::Whole, format!("the archive: {error}"))
            .with_help("the file is damaged or cut short; write it again")
    };
    let mut archive =
        NpzArchive::new(Cursor::new(bytes)).map_err(|error| damaged(error.to_string()))?;
    let zip = archive.zip_archive();
    let mut room = gzip::allowance(bytes.len());
    let mut columns = Vec::new();
    let mut ignored = Vec::new();
    for index in 0..zip.len() {
        let file = zip
            .by_index(index)
            .map_err(|error| damaged(error.to_string()))?;
        let Some(name) = array_name_from_file_name(file.name()).map(str::to_owned) else {
            continue;
        };
        let mut content = Vec::new();
        let in_array = |error: ParseError| ParseError {
            problem: format!("array \"{name}\": {error}"),
            place: Place::Whole,
            help: error.help,
        };
        file.take(room + 1)
            .read_to_end(&mut content)
            .map_err(|error| in_array(damaged(error.to_string())))?;
        room = room.checked_sub(content.len() as u64).ok_or_else(|| {
            ParseError::new(
                Place::Whole,
                format!(
                    "unfolds from {} bytes to more than {}",
                    bytes.len(),
                    gzip::allowance(bytes.len())
                ),
            )
            .with_help(
                "no frame of particles compresses like that; if it is real, store it uncompressed",
            )
        })?;
        let needed = is_position(&name);
        match Array::parse(&content).and_then(|array| column(&name, &array)) {
            Ok(Some(column)) => columns.push(column),
            Ok(None) => ignored.push(name),
            // What is no column may be an object or text; a damaged position is an error.
            Err(error) if needed => return Err(in_array(error)),
            Err(_) => ignored.push(name),
        }
    }
    choose(columns, ignored)
}

fn is_position(name: &str) -> bool {
    POSITION_NAMES
        .iter()
        .chain(&["y", "z"])
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// A plain array of one or two dimensions as a column.
fn column(name: &str, array: &Array) -> Result<Option<Column>, ParseError> {
    if array.has_fields() || !(1..=2).contains(&array.shape.len()) {
        return Ok(None);
    }
    Ok(array.columns()?.into_iter().next().map(|mut column| {
        column.name = name.to_owned();
        column
    }))
}

fn choose(columns: Vec<Column>, mut ignored: Vec<String>) -> Result<Parsed, ParseError> {
    let shapes: Vec<String> = columns
        .iter()
        .map(|column| format!("{} ({}, {})", column.name, column.rows(), column.components))
        .collect();
    let mut warnings = Vec::new();
    let mut triples = columns.iter().filter(|column| column.components == 3);
    let only_triple = match (triples.next(), triples.next()) {
        (Some(only), None) => Some(only.name.clone()),
        _ => None,
    };
    // Axes of different lengths are no position.
    let axes: Vec<usize> = columns
        .iter()
        .filter(|column| column.components == 1 && ["x", "y", "z"].contains(&column.name.as_str()))
        .map(Column::rows)
        .collect();
    let uneven = axes.windows(2).any(|pair| pair[0] != pair[1]);
    let has_named = columns
        .iter()
        .any(|column| column.components == 3 && is_position(&column.name));
    let columns = match only_triple {
        Some(name) if !has_named && axes.len() < 3 => {
            warnings.push(format!("array \"{name}\" was taken for the positions"));
            columns
                .into_iter()
                .map(|mut column| {
                    if column.name == name {
                        "positions".clone_into(&mut column.name);
                    }
                    column
                })
                .collect()
        }
        _ => columns,
    };
    let taken = if uneven && !has_named {
        None
    } else {
        take_positions(columns)
    };
    let Some((positions, columns)) = taken else {
        let found = if shapes.is_empty() {
            "none".to_owned()
        } else {
            shapes.join(", ")
        };
        return Err(ParseError::new(
            Place::Whole,
            format!("no array for the positions; arrays: {found}"),
        )
        .with_help("store positions as an array \"positions\" of shape (n, 3)"));
    };
    let (columns, others): (Vec<Column>, Vec<Column>) = columns
        .into_iter()
        .partition(|column| column.rows() == positions.len());
    ignored.extend(others.into_iter().map(|column| column.name));
    if !ignored.is_empty() {
        warnings.push(format!(
            "arrays without one row of numbers per particle were ignored: {}",
            ignored.join(", ")
        ));
    }
    Ok(Parsed {
        particles: assemble(positions, columns)?,
        frames: 1,
        warnings,
        left_out: 0,
    })
}
