//! Arrays of points and cells: SCALARS, VECTORS, FIELD and their relatives.

use super::types::Kind;
use super::{File, Section};
use crate::particles::io::ParseError;
use crate::particles::io::bytes::Scalar;
use crate::particles::io::vtk_values::Element;
use crate::particles::{Column, ColumnData};

impl File<'_> {
    /// Reads the attribute of that keyword; false if there is none of that name.
    pub(super) fn attribute(&mut self, keyword: &str) -> Result<bool, ParseError> {
        match keyword {
            "SCALARS" => self.scalars()?,
            "VECTORS" | "NORMALS" => self.named(3)?,
            "TENSORS" => self.named(9)?,
            "TENSORS6" => self.named(6)?,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.named(1)?,
            "TEXTURE_COORDINATES" => {
                let name = self.cursor.name()?;
                let components = self.cursor.count("the number of texture coordinates")?;
                let kind = self.cursor.kind()?;
                self.array(name, kind, components)?;
            }
            "COLOR_SCALARS" => self.colour_scalars()?,
            "LOOKUP_TABLE" => self.skip_lookup_table()?,
            "FIELD" => self.field()?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn scalars(&mut self) -> Result<(), ParseError> {
        let name = self.cursor.name()?;
        let kind = self.cursor.kind()?;
        let components = self.cursor.optional_count("the number of components")?;
        if self.cursor.next_is("LOOKUP_TABLE") {
            self.cursor.word("LOOKUP_TABLE")?;
            self.cursor.word("the name of a lookup table")?;
        }
        self.array(name, kind, components.unwrap_or(1))
    }

    fn named(&mut self, components: usize) -> Result<(), ParseError> {
        let name = self.cursor.name()?;
        let kind = self.cursor.kind()?;
        self.array(name, kind, components)
    }

    fn colour_scalars(&mut self) -> Result<(), ParseError> {
        let name = self.cursor.name()?;
        let components = self.cursor.count("the number of components")?;
        let rows = self.rows()?;
        let colours = self.cursor.colours(rows, components)?;
        self.keep(name, components, colours);
        Ok(())
    }

    /// `name size` and as many RGBA colours.
    fn skip_lookup_table(&mut self) -> Result<(), ParseError> {
        self.cursor.word("the name of a lookup table")?;
        let size = self.cursor.count("the size of the lookup table")?;
        let byte = Kind::Numbers(Element::Number(Scalar::U8));
        self.cursor.skip_tuples(byte, size, 4)
    }

    /// An array with one tuple for each point or cell of the section.
    fn array(&mut self, name: String, kind: Kind, components: usize) -> Result<(), ParseError> {
        let rows = self.rows()?;
        match self.section {
            Section::Points(_) => {
                let data = self.cursor.numbers(kind, rows, components)?;
                self.keep_if_numbers(name, kind, components, data);
                Ok(())
            }
            _ => {
                self.cell_arrays += 1;
                self.cursor.skip_tuples(kind, rows, components)
            }
        }
    }

    fn rows(&self) -> Result<usize, ParseError> {
        match self.section {
            Section::Points(rows) | Section::Cells(rows) => Ok(rows),
            Section::Dataset => Err(self
                .cursor
                .error("data arrays stand before POINT_DATA or CELL_DATA")),
        }
    }

    /// `FIELD name n`, then n arrays `name components tuples type` with sizes of their own.
    fn field(&mut self) -> Result<(), ParseError> {
        self.cursor.word("the name of the field")?;
        let arrays = self.cursor.count("the number of arrays")?;
        for _ in 0..arrays {
            let name = self.cursor.name()?;
            if name == "NULL_ARRAY" {
                continue;
            }
            let components = self.cursor.count("the number of components")?;
            let tuples = self.cursor.count("the number of tuples")?;
            let kind = self.cursor.kind()?;
            match self.section {
                Section::Points(points) if points == tuples => {
                    let data = self.cursor.numbers(kind, tuples, components)?;
                    self.keep_if_numbers(name, kind, components, data);
                }
                section => {
                    self.cursor.skip_tuples(kind, tuples, components)?;
                    match section {
                        Section::Points(points) => self.warnings.push(format!(
                            "array {name:?} has {tuples} rows for {points} points and was left out"
                        )),
                        Section::Cells(_) => self.cell_arrays += 1,
                        Section::Dataset => {}
                    }
                }
            }
            if self.cursor.next_is("METADATA") {
                self.cursor.word("METADATA")?;
                self.cursor.skip_metadata();
            }
        }
        Ok(())
    }

    fn keep_if_numbers(&mut self, name: String, kind: Kind, components: usize, data: ColumnData) {
        if matches!(kind, Kind::Numbers(_)) {
            self.keep(name, components, data);
        } else {
            self.warnings
                .push(format!("array {name:?} holds strings and was left out"));
        }
    }

    fn keep(&mut self, name: String, components: usize, data: ColumnData) {
        if components > 0 && matches!(self.section, Section::Points(_)) {
            self.columns.push(Column::new(name, components, data));
        }
    }
}
