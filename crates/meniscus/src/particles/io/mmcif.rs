//! mmCIF: the tables `_atom_site` and `_atom_site_anisotrop` of the PDBx/mmCIF dictionary, in any order
//! of columns; models as frames.

mod displacements;
mod tokens;

use super::atom_names::{Alignment, element};
use super::atoms::{Atom, Atoms, Displacements};
use super::text::{float, quote};
use super::{ParseError, Parsed, Place};
use crate::particles::elements::atomic_number;
use glam::DVec3;
use std::collections::HashMap;
use tokens::{Token, Tokens};

macro_rules! columns {
    ($($variant:ident $name:literal;)*) => {
        /// The columns of `_atom_site` that we read.
        #[derive(Debug, Clone, Copy)]
        enum AtomSite {
            $($variant,)*
        }

        /// Their names, in the same order.
        const NAMES: &[&str] = &[$($name,)*];
    };
}
columns! {
    X "Cartn_x";
    Y "Cartn_y";
    Z "Cartn_z";
    Symbol "type_symbol";
    AuthName "auth_atom_id";
    LabelName "label_atom_id";
    AuthResidueName "auth_comp_id";
    LabelResidueName "label_comp_id";
    AuthChain "auth_asym_id";
    LabelChain "label_asym_id";
    AuthResidue "auth_seq_id";
    LabelResidue "label_seq_id";
    Insertion "pdbx_PDB_ins_code";
    Alternate "label_alt_id";
    Occupancy "occupancy";
    BFactor "B_iso_or_equiv";
    Model "pdbx_PDB_model_num";
    Group "group_PDB";
    Serial "id";
    Charge "pdbx_formal_charge";
}

/// Whether the first word is a data block.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 14)];
    Tokens::new(start).next().is_some_and(Token::is_data_block)
}

/// Reads model `frame`; of the others only the number is looked at.
pub(super) fn read(bytes: &[u8], frame: usize) -> Result<Parsed, ParseError> {
    let mut tokens = Tokens::new(bytes);
    let mut reader = Reader::new(frame);
    let mut pending = tokens.next();
    while let Some(token) = pending {
        if token.is_loop() {
            pending = reader.read_loop(&mut tokens)?;
        } else if token.is_tag() {
            // A table of one row may be written as pairs.
            let value = tokens.next();
            if let Some(value) = value
                && let Some(name) = column_name(token)
            {
                reader.pairs.push((name, value));
            }
            pending = tokens.next();
        } else if token.is_data_block() && reader.has_atoms() {
            break;
        } else {
            pending = tokens.next();
        }
    }
    reader.finish()
}

/// The part of an `_atom_site` tag behind the point.
fn column_name(tag: Token<'_>) -> Option<&[u8]> {
    let (category, name) = tag.text.split_at_checked(11)?;
    category
        .eq_ignore_ascii_case(b"_atom_site.")
        .then_some(name)
}

struct Reader<'a> {
    frame: usize,
    atoms: Atoms,
    /// Models by the text of their number, in order of appearance.
    models: HashMap<&'a [u8], usize>,
    last_model: Option<(&'a [u8], usize)>,
    pairs: Vec<(&'a [u8], Token<'a>)>,
    /// By the atoms' ids.
    displacements: HashMap<i32, Displacements>,
    /// Whether there are fractional coordinates, which are no positions in space.
    is_crystal: bool,
}

impl<'a> Reader<'a> {
    fn new(frame: usize) -> Self {
        Self {
            frame,
            atoms: Atoms::default(),
            models: HashMap::new(),
            last_model: None,
            pairs: Vec::new(),
            displacements: HashMap::new(),
            is_crystal: false,
        }
    }

    fn has_atoms(&self) -> bool {
        !self.models.is_empty()
    }

    /// Reads one table if it is that of the atoms, and gives the word behind it.
    fn read_loop(&mut self, tokens: &mut Tokens<'a>) -> Result<Option<Token<'a>>, ParseError> {
        let mut next = tokens.next();
        let mut names: Vec<&[u8]> = Vec::new();
        let mut displacement_names: Vec<&[u8]> = Vec::new();
        let (mut is_atoms, mut is_displacements) = (false, false);
        while let Some(tag) = next.filter(|token| token.is_tag()) {
            self.is_crystal |= tag.text.starts_with(b"_atom_site_fract");
            let name = column_name(tag);
            is_atoms |= name.is_some();
            names.push(name.unwrap_or_default());
            let name = displacements::column_name(tag);
            is_displacements |= name.is_some();
            displacement_names.push(name.unwrap_or_default());
            next = tokens.next();
        }
        if is_displacements {
            let layout = displacements::Layout::new(&displacement_names);
            let mut row: Vec<Token<'a>> = Vec::new();
            while let Some(token) = next.filter(|token| !token.ends_values()) {
                row.push(token);
                if row.len() == displacement_names.len() {
                    layout.read(&row, &mut self.displacements);
                    row.clear();
                }
                next = tokens.next();
            }
            return Ok(next);
        }
        if !is_atoms {
            while next.is_some_and(|token| !token.ends_values()) {
                next = tokens.next();
            }
            return Ok(next);
        }
        let layout = Layout::new(&names);
        let mut row: Vec<Token<'a>> = Vec::with_capacity(names.len().min(1 << 10));
        while let Some(token) = next.filter(|token| !token.ends_values()) {
            row.push(token);
            if row.len() == names.len() {
                self.read_row(&layout, &row)?;
                row.clear();
            }
            next = tokens.next();
        }
        match row.first() {
            None => Ok(next),
            Some(first) => Err(ParseError::new(
                Place::Line(first.line),
                format!(
                    "this row of _atom_site ends after {} of {} values",
                    row.len(),
                    names.len()
                ),
            )
            .with_help("the file is cut short or a value is missing")),
        }
    }

    fn read_row(&mut self, layout: &Layout, row: &[Token<'a>]) -> Result<(), ParseError> {
        use AtomSite as Column;
        let get = |column| layout.get(row, column);
        let model = get(Column::Model).unwrap_or(b"1");
        let next = self.models.len();
        let index = match self.last_model {
            Some((last, index)) if last == model => index,
            _ => *self.models.entry(model).or_insert(next),
        };
        self.last_model = Some((model, index));
        if index != self.frame {
            return Ok(());
        }
        let line = row.first().map_or(0, |token| token.line);
        let mut position = [0.0; 3];
        for (coordinate, column) in position.iter_mut().zip([Column::X, Column::Y, Column::Z]) {
            let name = NAMES[column as usize];
            // Unknown coordinates are dropped later, with words.
            let Some(text) = get(column) else {
                if layout.has(column) {
                    *coordinate = f64::NAN;
                    continue;
                }
                let problem = format!("the table _atom_site has no column {name}");
                return Err(ParseError::new(Place::Line(line), problem));
            };
            *coordinate = number(text).ok_or_else(|| {
                let problem = format!("expected {name}, found {}", quote(text));
                ParseError::new(Place::Line(line), problem)
            })?;
        }
        let either = |first, second| get(first).or_else(|| get(second)).unwrap_or_default();
        let integer = |text: &[u8]| std::str::from_utf8(text).ok()?.parse::<i32>().ok();
        let name = either(Column::AuthName, Column::LabelName);
        let stated = get(Column::Symbol).map_or(0, atomic_number);
        let atomic_number = match stated {
            0 => {
                let residue = either(Column::AuthResidueName, Column::LabelResidueName);
                element(name, residue, Alignment::None)
            }
            number => Some(number),
        };
        let real = |column| get(column).and_then(number).map(|value| value as f32);
        self.atoms.push(&Atom {
            position: DVec3::from_array(position),
            name,
            chain: either(Column::AuthChain, Column::LabelChain),
            residue: integer(either(Column::AuthResidue, Column::LabelResidue)).unwrap_or(0),
            insertion: get(Column::Insertion).unwrap_or_default(),
            serial: get(Column::Serial).and_then(integer).unwrap_or(0),
            atomic_number,
            hetero: get(Column::Group) == Some(b"HETATM"),
            alternate: get(Column::Alternate).unwrap_or_default(),
            occupancy: real(Column::Occupancy).filter(|value| value.is_finite()),
            b_factor: real(Column::BFactor).filter(|value| value.is_finite()),
            charge: get(Column::Charge)
                .and_then(integer)
                .and_then(|charge| i8::try_from(charge).ok()),
            velocity: None,
        });
        Ok(())
    }

    fn finish(mut self) -> Result<Parsed, ParseError> {
        let pairs = std::mem::take(&mut self.pairs);
        if !self.has_atoms() && !pairs.is_empty() {
            let (names, row): (Vec<&[u8]>, Vec<Token<'a>>) = pairs.into_iter().unzip();
            self.read_row(&Layout::new(&names), &row)?;
        }
        if !self.has_atoms() {
            let error = ParseError::new(Place::Whole, "there is no table _atom_site of atoms");
            return Err(if self.is_crystal {
                error.with_help(
                    "its coordinates are fractions of a crystal's cell; convert it to PDB or XYZ",
                )
            } else {
                error.with_help("structure factors and dictionaries hold no atoms")
            });
        }
        self.atoms.displace_by_serial(&self.displacements);
        self.atoms.into_parsed(1.0, self.models.len())
    }
}

/// For each of [`NAMES`] its place in a row.
struct Layout {
    places: Vec<Option<usize>>,
}

impl Layout {
    fn new(names: &[&[u8]]) -> Self {
        let place = |wanted: &&str| {
            let is = |name: &&[u8]| name.eq_ignore_ascii_case(wanted.as_bytes());
            names.iter().position(is)
        };
        Self {
            places: NAMES.iter().map(place).collect(),
        }
    }

    fn has(&self, column: AtomSite) -> bool {
        self.places[column as usize].is_some()
    }

    fn get<'a>(&self, row: &[Token<'a>], column: AtomSite) -> Option<&'a [u8]> {
        row.get(self.places[column as usize]?)?.value()
    }
}

/// A number, without the standard uncertainty that may follow it in parentheses.
fn number(text: &[u8]) -> Option<f64> {
    let end = text.iter().position(|&byte| byte == b'(');
    float(&text[..end.unwrap_or(text.len())])
}

#[cfg(test)]
mod tests;
