//! Numbers per particle by name: a column, a component or the magnitude of one, a role, or a group of
//! scalar columns.

use super::{Column, Particles, Role};
use glam::DVec3;

/// Suffixes of the scalar columns that together form a vector or a tensor, longest first.
const GROUP_SUFFIXES: [&[&str]; 8] = [
    &["00", "01", "02", "10", "11", "12", "20", "21", "22"],
    &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
    &["0", "1", "2", "3", "4", "5", "6", "7", "8"],
    &["xx", "xy", "xz", "yy", "yz", "zz"],
    &["0", "1", "2", "3", "4", "5"],
    &["x", "y", "z"],
    &["X", "Y", "Z"],
    &["0", "1", "2"],
];

/// Where one component comes from.
#[derive(Debug, Clone, Copy)]
enum Source<'a> {
    Axis(&'a [DVec3], usize),
    Column(&'a Column, usize),
}

/// Numbers per particle that were asked for by name: a column, a component of it, its magnitude, or
/// several scalar columns taken together.
#[derive(Debug, Clone)]
pub struct Attribute<'a> {
    name: String,
    sources: Vec<Source<'a>>,
    scale: f64,
    magnitude: bool,
}

impl<'a> Attribute<'a> {
    fn new(name: &str, sources: Vec<Source<'a>>) -> Self {
        Self {
            name: name.to_owned(),
            sources,
            scale: 1.0,
            magnitude: false,
        }
    }

    pub(super) fn of_column(column: &'a Column) -> Self {
        let sources = (0..column.components)
            .map(|component| Source::Column(column, component))
            .collect();
        Self::new(&column.name, sources)
    }

    /// With the first component behind the others.
    pub(super) fn rotated_left(mut self) -> Self {
        self.sources.rotate_left(1);
        self
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self {
            scale: self.scale * factor,
            ..self
        }
    }

    /// The column that the first component comes from, unless it is the position.
    pub fn first_column(&self) -> Option<&'a Column> {
        match self.sources.first()? {
            Source::Axis(..) => None,
            Source::Column(column, _) => Some(column),
        }
    }

    /// The columns that the components come from.
    pub fn columns(&self) -> impl Iterator<Item = &'a Column> {
        self.sources.iter().filter_map(|source| match *source {
            Source::Axis(..) => None,
            Source::Column(column, _) => Some(column),
        })
    }

    /// The names of the columns that the components come from, with the component there.
    pub(super) fn sources(&self) -> impl Iterator<Item = (&'a str, usize)> {
        self.sources.iter().filter_map(|source| match *source {
            Source::Axis(..) => None,
            Source::Column(column, component) => Some((&*column.name, component)),
        })
    }

    /// The name: what was asked for, or the column that plays the role.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Numbers per particle.
    pub fn components(&self) -> usize {
        if self.magnitude {
            1
        } else {
            self.sources.len()
        }
    }

    /// The number of particle `row`.
    ///
    /// # Panics
    /// If `row` or `component` is out of range.
    pub fn get(&self, row: usize, component: usize) -> f64 {
        if !self.magnitude {
            return self.scale * self.sources[component].get(row);
        }
        let squares: f64 = self.sources.iter().map(|s| s.get(row).powi(2)).sum();
        self.scale * squares.sqrt()
    }

    /// The numbers of `out.len()` particles from `first` on: [`Attribute::get`] for many rows.
    ///
    /// # Panics
    /// If `component` or a row is out of range.
    pub fn read(&self, first: usize, component: usize, out: &mut [f64]) {
        if self.magnitude {
            for (i, out) in out.iter_mut().enumerate() {
                *out = self.get(first + i, 0);
            }
            return;
        }
        match self.sources[component] {
            Source::Axis(positions, axis) => {
                for (out, position) in out.iter_mut().zip(&positions[first..]) {
                    *out = position[axis];
                }
            }
            Source::Column(column, component) => column.read(first, component, out),
        }
        if self.scale != 1.0 {
            out.iter_mut().for_each(|value| *value *= self.scale);
        }
    }

    /// The length of the vector, as one number.
    #[must_use]
    pub fn magnitude(self) -> Self {
        Self {
            name: format!("|{}|", self.name),
            magnitude: true,
            ..self
        }
    }

    fn component(self, component: usize, name: &str) -> Option<Self> {
        let source = *self.sources.get(component)?;
        (!self.magnitude).then(|| Self {
            name: name.to_owned(),
            sources: vec![source],
            ..self
        })
    }
}

impl Source<'_> {
    fn get(self, row: usize) -> f64 {
        match self {
            Self::Axis(positions, axis) => positions[row][axis],
            Self::Column(column, component) => column.get(row, component),
        }
    }
}

/// A name that no column answers to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingColumn {
    /// The name asked for.
    pub name: String,
    /// The columns there are.
    pub columns: Vec<String>,
    /// The column with the most similar name, when one is similar.
    pub nearest: Option<String>,
    /// When the column is there and only the component is not: how many it has.
    pub components: Option<usize>,
}

impl std::error::Error for MissingColumn {}

impl MissingColumn {
    /// What is missing.
    pub fn problem(&self) -> String {
        match self.components {
            None => format!("no column `{}`", self.name),
            Some(1) => format!("no `{}`: the column has one component", self.name),
            Some(n) => format!("no `{}`: the column has {n} components", self.name),
        }
    }

    /// The nearest name and all names there are.
    pub fn help(&self) -> String {
        let suggestion = match &self.nearest {
            Some(nearest) => format!("did you mean `{nearest}`? "),
            None => String::new(),
        };
        match self.components {
            Some(1) => "use the name alone".to_owned(),
            Some(_) => "components are .x, .y, .z or .0, .1, …".to_owned(),
            None if self.columns.is_empty() => {
                format!("{suggestion}there are x, y, z and no other column")
            }
            None => format!("{suggestion}there are x, y, z, {}", self.columns.join(", ")),
        }
    }
}

impl std::fmt::Display for MissingColumn {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}; {}", self.problem(), self.help())
    }
}

/// The index of the name of a component: `x` is 0, `7` is 7.
fn component_index(suffix: &str) -> Option<usize> {
    const LETTERS: [(&str, usize); 8] = [
        ("x", 0),
        ("y", 1),
        ("z", 2),
        ("w", 3),
        ("r", 0),
        ("g", 1),
        ("b", 2),
        ("a", 3),
    ];
    let letter = LETTERS.iter().find(|(letter, _)| *letter == suffix);
    letter
        .map(|&(_, index)| index)
        .or_else(|| suffix.parse().ok())
}

/// `name.suffix` or `name[suffix]` in two.
fn split_component(name: &str) -> Option<(&str, &str)> {
    name.strip_suffix(']')
        .and_then(|rest| rest.rsplit_once('['))
        .or_else(|| name.rsplit_once('.'))
}

impl Particles {
    /// Numbers per particle by name. In this order: `x`, `y` or `z` of the position; a column of
    /// exactly that name; `|name|`; a component `name.x`, `name.y`, `name.z`, `name.0`, `name[0]`, …
    /// or `name.magnitude`; a [`Role`]'s name; a group of scalar columns by what their names share
    /// (`v` for `vx vy vz`, `F` for `F00` … `F22`); `position`.
    ///
    /// # Errors
    /// When nothing answers to the name; the error lists what there is.
    pub fn attribute(&self, name: &str) -> Result<Attribute<'_>, MissingColumn> {
        if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
            return Ok(Attribute::new(
                name,
                vec![Source::Axis(&self.positions, axis)],
            ));
        }
        if let Some(column) = self.column(name) {
            return Ok(Attribute::of_column(column));
        }
        if let Some(inner) = name
            .strip_prefix('|')
            .and_then(|rest| rest.strip_suffix('|'))
        {
            return self.whole(inner).map(Attribute::magnitude);
        }
        if let Some((base, suffix)) = split_component(name) {
            if let Ok(attribute) = self.whole(base) {
                if suffix == "magnitude" {
                    return Ok(attribute.magnitude());
                }
                let components = attribute.components();
                return component_index(suffix)
                    .and_then(|index| attribute.component(index, name))
                    .ok_or_else(|| MissingColumn {
                        components: Some(components),
                        ..self.missing(name)
                    });
            }
            if component_index(suffix).is_some() {
                return Err(self.missing(base));
            }
        }
        self.whole(name)
    }

    /// A column, role or group of scalars by its whole name.
    fn whole(&self, name: &str) -> Result<Attribute<'_>, MissingColumn> {
        let axes = || {
            (name == "position").then(|| {
                let axes = [0, 1, 2].map(|axis| Source::Axis(&self.positions, axis));
                Attribute::new(name, axes.to_vec())
            })
        };
        self.column(name)
            .map(Attribute::of_column)
            .or_else(|| self.role(Role::from_name(name)?))
            .or_else(|| self.group(name))
            .or_else(axes)
            .ok_or_else(|| self.missing(name))
    }

    /// Scalar columns `{name}x`, `{name}y`, … as one attribute.
    pub(super) fn group(&self, name: &str) -> Option<Attribute<'_>> {
        GROUP_SUFFIXES.iter().find_map(|suffixes| {
            ["", "_", ".", ":"].iter().find_map(|separator| {
                let names: Vec<String> = suffixes
                    .iter()
                    .map(|suffix| format!("{name}{separator}{suffix}"))
                    .collect();
                self.together(name, &names, 1)
            })
        })
    }

    /// Columns of `components` each as one attribute, one behind the other.
    pub(super) fn together<S: AsRef<str>>(
        &self,
        name: &str,
        names: &[S],
        components: usize,
    ) -> Option<Attribute<'_>> {
        let columns = names
            .iter()
            .map(|name| {
                let column = self.column(name.as_ref())?;
                (column.components == components).then_some(column)
            })
            .collect::<Option<Vec<_>>>()?;
        let each = |column| (0..components).map(move |component| Source::Column(column, component));
        Some(Attribute::new(
            name,
            columns.into_iter().flat_map(each).collect(),
        ))
    }

    fn missing(&self, name: &str) -> MissingColumn {
        // Names come from files: what is too long to be a misspelling is not compared.
        const LONGEST: usize = 64;
        let wanted = name.to_lowercase();
        let allowed = (wanted.chars().count() / 3).max(2);
        let roles = Role::ALL
            .into_iter()
            .filter(|role| self.role(*role).is_some())
            .map(|role| -> &str { role.name() });
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        let nearest = names
            .iter()
            .copied()
            .chain(roles)
            .filter(|other| other.len() <= LONGEST && wanted.len() <= LONGEST)
            .map(|other| {
                let distance = strsim::osa_distance(&wanted, &other.to_lowercase());
                (distance, other)
            })
            .filter(|(distance, other)| *distance <= allowed && *distance < other.chars().count())
            .min_by_key(|(distance, _)| *distance)
            .map(|(_, other)| other.to_owned());
        MissingColumn {
            name: name.to_owned(),
            columns: names.into_iter().map(str::to_owned).collect(),
            nearest,
            components: None,
        }
    }
}
