//! What the words of a row mean.

use crate::particles::io::bytes::{Scalar, empty_data};
use crate::particles::io::text::{float, quote, unexpected, words};
use crate::particles::io::{ParseError, Place};
use crate::particles::{Column, ColumnData};

/// What a property is to us, with its values so far.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Role {
    Position,
    Species,
    Flag(Vec<u8>),
    Number(ColumnData),
    Text,
}

/// One or more neighbouring words of each row.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) components: usize,
    pub(super) role: Role,
}

/// All properties of a row, in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Layout {
    pub(super) properties: Vec<Property>,
}

/// The value of `Properties=` in the comment of extended XYZ.
pub(super) fn properties(comment: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(comment);
    let lower = text.to_ascii_lowercase();
    let key = "properties=";
    let at = lower
        .match_indices(key)
        .map(|(at, _)| at)
        .find(|&at| at == 0 || lower[..at].ends_with(|c: char| c.is_whitespace()))?;
    let value = &text[at + key.len()..];
    let value = match value.chars().next()? {
        quote @ ('"' | '\'') => value[1..].split(quote).next()?,
        _ => value.split_whitespace().next()?,
    };
    Some(value.to_owned())
}

impl Layout {
    /// The layout that `Properties=species:S:1:pos:R:3:…` in line `line` describes.
    pub(super) fn described(value: &str, line: u64) -> Result<Self, ParseError> {
        let wrong = |problem: String| {
            ParseError::new(Place::Line(line), problem)
                .with_help("extended XYZ describes rows as Properties=species:S:1:pos:R:3:name:R:1")
        };
        let parts: Vec<&str> = value.split(':').collect();
        let (triples, rest) = parts.as_chunks::<3>();
        if !rest.is_empty() {
            return Err(wrong(format!("{value:?} is no list of name:type:count")));
        }
        let mut layout = Self::default();
        for [name, kind, count] in triples {
            let components = count
                .parse::<u16>()
                .ok()
                .filter(|&count| count > 0)
                .ok_or_else(|| wrong(format!("{count:?} is no number of components")))?;
            let is = |wanted: &[&str]| {
                wanted
                    .iter()
                    .any(|&wanted| name.eq_ignore_ascii_case(wanted))
            };
            let has_position = layout.has_position();
            let role = match *kind {
                "R" if components == 3
                    && !has_position
                    && is(&["pos", "positions", "position"]) =>
                {
                    Role::Position
                }
                "S" if components == 1 && is(&["species", "element", "symbol", "type"]) => {
                    Role::Species
                }
                "R" => Role::Number(empty_data(Scalar::F64, 0)),
                "I" => Role::Number(empty_data(Scalar::I64, 0)),
                "L" => Role::Flag(Vec::new()),
                "S" => Role::Text,
                _ => {
                    return Err(wrong(format!(
                        "{kind:?} is no type; types are S, R, I and L"
                    )));
                }
            };
            layout.properties.push(Property {
                name: (*name).to_owned(),
                components: components.into(),
                role,
            });
        }
        let species = |property: &&Property| property.role == Role::Species;
        if layout.properties.iter().filter(species).count() > 1 {
            return Err(wrong("two properties name the species".to_owned()));
        }
        if layout.has_position() {
            Ok(layout)
        } else {
            Err(wrong(format!("{value:?} has no pos:R:3")))
        }
    }

    fn has_position(&self) -> bool {
        self.properties
            .iter()
            .any(|property| property.role == Role::Position)
    }

    /// The layout of a plain frame, told by its first row: a symbol or atomic number, x, y, z and
    /// more; or x, y, z without a symbol.
    pub(super) fn of_row(row: &[u8], line: u64) -> Result<Self, ParseError> {
        let words: Vec<&[u8]> = words(row).collect();
        let numeric = |word: &[u8]| float::<f64>(word).is_some();
        let symbol = words.first().is_some_and(|&word| {
            !numeric(word) || words.len() > 3 && word.iter().all(u8::is_ascii_digit)
        });
        let first = usize::from(symbol);
        let coordinates = words.get(first..first + 3);
        if !coordinates.is_some_and(|words| words.iter().all(|word| numeric(word))) {
            return Err(unexpected(line, "a symbol and x y z", row));
        }
        let mut properties = Vec::new();
        if symbol {
            properties.push(Property {
                name: "symbol".to_owned(),
                components: 1,
                role: Role::Species,
            });
        }
        properties.push(Property {
            name: "position".to_owned(),
            components: 3,
            role: Role::Position,
        });
        for (index, word) in words.iter().enumerate().skip(first + 3) {
            let role = match numeric(word) {
                true => Role::Number(empty_data(Scalar::F64, 0)),
                false => Role::Text,
            };
            properties.push(Property {
                name: format!("column_{}", index + 1),
                components: 1,
                role,
            });
        }
        Ok(Self { properties })
    }

    /// The columns of numbers and flags, and what was left out.
    pub(super) fn into_columns(self) -> (Vec<Column>, Vec<String>) {
        let (mut columns, mut warnings) = (Vec::new(), Vec::new());
        for Property {
            name,
            components,
            role,
        } in self.properties
        {
            let data = match role {
                Role::Position | Role::Species => continue,
                Role::Text => {
                    let name = quote(name.as_bytes());
                    warnings.push(format!("property {name} holds text and was skipped"));
                    continue;
                }
                Role::Number(ColumnData::I64(values)) => narrow(values),
                Role::Number(data) => data,
                Role::Flag(values) => values.into(),
            };
            columns.push(Column::new(name, components, data));
        }
        (columns, warnings)
    }
}

fn narrow(values: Vec<i64>) -> ColumnData {
    let narrow: Option<Vec<i32>> = values
        .iter()
        .map(|&value| i32::try_from(value).ok())
        .collect();
    narrow.map_or_else(|| values.into(), Into::into)
}
