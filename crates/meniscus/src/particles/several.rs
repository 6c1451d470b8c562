//! Numbers that may be spread over several columns: `axes`, or `u,v,w`.

use super::{Attribute, MissingColumn, Particles, Role};

/// Attributes one behind the other.
#[derive(Debug, Clone)]
pub struct Several<'a> {
    name: String,
    parts: Vec<Attribute<'a>>,
}

impl Several<'_> {
    /// What was asked for, or the column that plays the role.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Numbers per particle.
    pub fn components(&self) -> usize {
        self.parts.iter().map(Attribute::components).sum()
    }

    /// The numbers of particle `row`, the first `N` of them; 0 beyond the last.
    ///
    /// # Panics
    /// If `row` is out of range.
    pub fn get<const N: usize>(&self, row: usize) -> [f64; N] {
        let mut numbers = [0.0; N];
        let each = self
            .parts
            .iter()
            .flat_map(|part| (0..part.components()).map(move |component| (part, component)));
        for (number, (part, component)) in numbers.iter_mut().zip(each) {
            *number = part.get(row, component);
        }
        numbers
    }
}

impl<'a> From<Attribute<'a>> for Several<'a> {
    fn from(attribute: Attribute<'a>) -> Self {
        Self {
            name: attribute.name().to_owned(),
            parts: vec![attribute],
        }
    }
}

impl Particles {
    /// The numbers that play `role` under a name that [`Particles::attribute`] knows, or under several
    /// parted by commas, one behind the other: `u,v,w`, `q.1,q.2,q.3,q.0`.
    ///
    /// # Errors
    /// When nothing answers to one of the names.
    pub fn several(&self, role: Role, names: &str) -> Result<Several<'_>, MissingColumn> {
        if self.column(names).is_some() || !names.contains(',') {
            let attribute = self.attribute(names)?;
            let is_column = self.column(names).is_some();
            return Ok(if is_column && role.is_scalar_first(names) {
                attribute.rotated_left().into()
            } else {
                attribute.into()
            });
        }
        let parts = names.split(',').map(|name| self.attribute(name.trim()));
        Ok(Several {
            name: names.to_owned(),
            parts: parts.collect::<Result<_, _>>()?,
        })
    }
}
