//! VTK legacy files, versions 1.0 to 5.1, ascii and binary (big endian): the points and their data.
//!
//! Format: *VTK File Formats*, "Simple Legacy Formats" (Kitware), and what `vtkDataReader` does
//! where that text is silent. Cells are stepped over; a point is a particle whether or not a cell
//! uses it.

mod attributes;
mod cursor;
mod types;

#[cfg(test)]
mod tests;

use super::bytes::assemble;
use super::vtk_values::{Words, positions_of};
use super::{ParseError, Parsed};
use crate::particles::Column;
use cursor::Cursor;
use glam::DVec3;
use types::Kind;

const MAGIC: &[u8] = b"# vtk DataFile";

/// Whether the content starts as every legacy file does.
pub(super) fn detect(prefix: &[u8]) -> bool {
    let start = prefix.strip_prefix(b"\xef\xbb\xbf").unwrap_or(prefix);
    start
        .trim_ascii_start()
        .get(..MAGIC.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(MAGIC))
}

/// Reads the points and their data. A file is one frame.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let mut words = Words::new(bytes, 0);
    words.skip_space();
    let _version = words.line();
    let _title = words.line();
    let mut cursor = Cursor::new(words, false);
    let encoding = cursor.word("ASCII or BINARY")?;
    let binary = encoding.eq_ignore_ascii_case(b"BINARY");
    if !binary && !encoding.eq_ignore_ascii_case(b"ASCII") {
        return Err(cursor.unexpected(encoding, "ASCII or BINARY in the third line"));
    }
    cursor.binary = binary;
    let mut file = File {
        cursor,
        points: None,
        section: Section::Dataset,
        columns: Vec::new(),
        warnings: Vec::new(),
        cell_arrays: 0,
    };
    while file.cursor.peek().is_some() {
        file.item()?;
    }
    let Some(positions) = file.points else {
        return Err(file
            .cursor
            .error("there is no POINTS section")
            .with_help("particles are the points of a POLYDATA or UNSTRUCTURED_GRID data set"));
    };
    if file.columns.is_empty() && file.cell_arrays > 0 {
        file.warnings.push(format!(
            "{} arrays belong to cells, not to points, and were left out",
            file.cell_arrays
        ));
    }
    Ok(Parsed {
        particles: assemble(positions, file.columns)?,
        frames: 1,
        warnings: file.warnings,
        left_out: 0,
    })
}

/// To what the arrays that follow belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    /// The data set as a whole.
    Dataset,
    /// Points, of this number.
    Points(usize),
    /// Cells, of this number.
    Cells(usize),
}

struct File<'a> {
    cursor: Cursor<'a>,
    points: Option<Vec<DVec3>>,
    section: Section,
    columns: Vec<Column>,
    warnings: Vec<String>,
    cell_arrays: usize,
}

impl File<'_> {
    /// Reads one keyword and what belongs to it.
    fn item(&mut self) -> Result<(), ParseError> {
        let word = self.cursor.word("a keyword")?;
        let keyword = String::from_utf8_lossy(word).to_ascii_uppercase();
        match keyword.as_str() {
            "DATASET" => self.dataset(),
            "POINTS" => self.read_points(),
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => self.skip_cells(),
            "CELL_TYPES" => {
                let cells = self.cursor.count("the number of cells")?;
                self.cursor.skip_numbers(Kind::I32, cells)
            }
            "DIMENSIONS" => (0..3).try_for_each(|_| self.cursor.word("a dimension").map(drop)),
            "EXTENT" => (0..6).try_for_each(|_| self.cursor.word("an extent").map(drop)),
            "METADATA" => {
                self.cursor.skip_metadata();
                Ok(())
            }
            "POINT_DATA" => self.begin_point_data(),
            "CELL_DATA" => {
                self.section = Section::Cells(self.cursor.count("the number of cells")?);
                Ok(())
            }
            _ if self.attribute(&keyword)? => Ok(()),
            _ => Err(self.cursor.unexpected(
                word,
                "a keyword (POINTS, CELLS, POINT_DATA, SCALARS, FIELD, …)",
            )),
        }
    }

    fn dataset(&mut self) -> Result<(), ParseError> {
        let word = self.cursor.word("the kind of data set")?;
        match word.to_ascii_uppercase().as_slice() {
            b"POLYDATA" | b"UNSTRUCTURED_GRID" | b"STRUCTURED_GRID" => Ok(()),
            b"STRUCTURED_POINTS" | b"RECTILINEAR_GRID" => Err(self
                .cursor
                .error(format!(
                    "a {} is a grid without points of its own",
                    String::from_utf8_lossy(word)
                ))
                .with_help("particles are the points of a POLYDATA or UNSTRUCTURED_GRID")),
            _ => Err(self
                .cursor
                .unexpected(word, "POLYDATA or UNSTRUCTURED_GRID")),
        }
    }

    fn read_points(&mut self) -> Result<(), ParseError> {
        if self.points.is_some() {
            return Err(self.cursor.error("a second POINTS section"));
        }
        let count = self.cursor.count("the number of points")?;
        let kind = self.cursor.number_kind()?;
        let triples = self.cursor.numbers(kind, count, 3)?;
        self.points = Some(positions_of(&triples));
        Ok(())
    }

    fn begin_point_data(&mut self) -> Result<(), ParseError> {
        let count = self.cursor.count("the number of points")?;
        let points = self.points.as_ref().map_or(0, Vec::len);
        if count != points {
            return Err(self.cursor.error(format!(
                "POINT_DATA is for {count} points, POINTS has {points}"
            )));
        }
        self.section = Section::Points(count);
        Ok(())
    }

    /// Steps over cells: `n size` and then either the counts and indices in one array (before 5.0),
    /// or `OFFSETS type` with n numbers and `CONNECTIVITY type` with `size` numbers.
    fn skip_cells(&mut self) -> Result<(), ParseError> {
        let offsets = self.cursor.count("the number of cells")?;
        let size = self.cursor.count("the size of the cell list")?;
        if !self.cursor.next_is("OFFSETS") {
            return self.cursor.skip_numbers(Kind::I32, size);
        }
        for (keyword, values) in [("OFFSETS", offsets), ("CONNECTIVITY", size)] {
            let word = self.cursor.word(keyword)?;
            if !word.eq_ignore_ascii_case(keyword.as_bytes()) {
                return Err(self.cursor.unexpected(word, keyword));
            }
            let kind = self.cursor.number_kind()?;
            self.cursor.skip_numbers(kind, values)?;
            if self.cursor.next_is("METADATA") {
                self.cursor.word("METADATA")?;
                self.cursor.skip_metadata();
            }
        }
        Ok(())
    }
}
