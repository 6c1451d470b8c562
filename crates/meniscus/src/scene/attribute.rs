//! Which number of which column colours a surface: `speed`, `velocity` (a vector's magnitude),
//! `velocity.x` or `velocity[0]` (one component).

/// What a surface is coloured by to show the colours of its particles' elements (Corey, Pauling and
/// Koltun's): where there are elements; other surfaces keep their material's colour.
pub const ELEMENT_COLOR: &str = "element";

/// What a surface is coloured by to show the colours that its particles bring along.
pub const OWN_COLOR: &str = "color";

/// Which number of a column's value counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Component {
    /// The length of the vector; of a scalar the scalar itself, sign included.
    Magnitude,
    /// One component, counted from 0.
    Index(usize),
}

impl Component {
    /// The number that counts among the components of one value.
    pub fn of(self, value: &[f32]) -> f32 {
        match (self, value) {
            (Self::Magnitude, &[scalar]) => scalar,
            (Self::Magnitude, _) => value.iter().map(|c| c * c).sum::<f32>().sqrt(),
            (Self::Index(index), _) => value.get(index).copied().unwrap_or(0.0),
        }
    }
}

/// A column and the number of it that counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AttributeRef {
    /// Name of the column.
    pub column: String,
    /// The number that counts.
    pub component: Component,
}

impl AttributeRef {
    /// Reads `text`. A column of exactly that name wins over a component of a shorter one; `exists`
    /// says which columns there are. `None` if there is no such column.
    pub fn parse(text: &str, exists: impl Fn(&str) -> bool) -> Option<Self> {
        if exists(text) {
            return Some(Self {
                column: text.to_owned(),
                component: Component::Magnitude,
            });
        }
        let (column, component) = match text.strip_suffix(']') {
            Some(inside) => inside.rsplit_once('[')?,
            None => text.rsplit_once('.')?,
        };
        let index = match component {
            "x" | "r" => 0,
            "y" | "g" => 1,
            "z" | "b" => 2,
            "w" | "a" => 3,
            digits => digits.parse().ok()?,
        };
        exists(column).then(|| Self {
            column: column.to_owned(),
            component: Component::Index(index),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_components_and_exact_names_are_told_apart() {
        let exists = |name: &str| ["velocity", "a.x", "speed"].contains(&name);
        let parse =
            |text| AttributeRef::parse(text, exists).map(|found| (found.column, found.component));
        let found = |column: &str, component| Some((column.to_owned(), component));
        assert_eq!(parse("speed"), found("speed", Component::Magnitude));
        assert_eq!(parse("velocity.y"), found("velocity", Component::Index(1)));
        assert_eq!(parse("velocity[2]"), found("velocity", Component::Index(2)));
        assert_eq!(
            parse("velocity.12"),
            found("velocity", Component::Index(12))
        );
        assert_eq!(parse("a.x"), found("a.x", Component::Magnitude));
        assert_eq!(parse("a.x.x"), found("a.x", Component::Index(0)));
        for wrong in [
            "",
            ".",
            "[0]",
            "velocity[",
            "velocity]",
            "velocity.q",
            "density",
            "velocity[-1]",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn magnitudes_of_scalars_keep_their_sign() {
        assert_eq!(Component::Magnitude.of(&[-2.0]), -2.0);
        assert_eq!(Component::Magnitude.of(&[3.0, -4.0]), 5.0);
        assert_eq!(Component::Index(1).of(&[3.0, -4.0]), -4.0);
        assert_eq!(Component::Index(7).of(&[3.0, -4.0]), 0.0);
    }
}
