//! The table `_atom_site_anisotrop`: U in Å², or B = 8π²U, along the axes of the coordinates.

use super::number;
use super::tokens::Token;
use crate::particles::io::atoms::{B_OVER_U, Displacements};
use std::collections::HashMap;

const CATEGORY: &[u8] = b"_atom_site_anisotrop.";
/// Components in the order of [`Displacements`].
const COMPONENTS: [&str; 6] = ["[1][1]", "[2][2]", "[3][3]", "[1][2]", "[1][3]", "[2][3]"];

/// The part of a tag of the table behind the point.
pub(super) fn column_name<'a>(tag: Token<'a>) -> Option<&'a [u8]> {
    let (category, name) = tag.text.split_at_checked(CATEGORY.len())?;
    category.eq_ignore_ascii_case(CATEGORY).then_some(name)
}

/// Where a row has what.
pub(super) struct Layout {
    id: Option<usize>,
    components: [Option<usize>; 6],
    per_u: f64,
}

impl Layout {
    pub(super) fn new(names: &[&[u8]]) -> Self {
        let place = |wanted: &str| {
            let is = |name: &&[u8]| name.eq_ignore_ascii_case(wanted.as_bytes());
            names.iter().position(is)
        };
        let components = |letter: &str| COMPONENTS.map(|ij| place(&format!("{letter}{ij}")));
        let in_u = components("U");
        let has_u = in_u.iter().all(Option::is_some);
        Self {
            id: place("id"),
            components: if has_u { in_u } else { components("B") },
            per_u: if has_u { 1.0 } else { B_OVER_U },
        }
    }

    /// Adds a row; one without an id is passed over. What is no number becomes NaN.
    pub(super) fn read(&self, row: &[Token<'_>], into: &mut HashMap<i32, Displacements>) {
        let get = |place: Option<usize>| row.get(place?)?.value();
        let id = get(self.id).and_then(|text| std::str::from_utf8(text).ok()?.parse().ok());
        let Some(id) = id else { return };
        let component = |place| get(place).and_then(number).map(|u| (u / self.per_u) as f32);
        let displacements = self
            .components
            .map(|place| component(place).unwrap_or(f32::NAN));
        into.insert(id, displacements);
    }
}
