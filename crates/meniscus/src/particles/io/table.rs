//! Tables of text: columns whose type their values decide, names that mean a position.

use super::bytes::assemble;
use super::text::float;
use super::{ParseError, Parsed};
use crate::particles::{Column, ColumnData};
use glam::DVec3;

/// More columns than this are taken for a file that is no table.
pub(super) const MAX_COLUMNS: usize = 4096;

/// The values of one column so far: whole numbers until a fraction comes, nothing once text comes.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    Ints(Vec<i64>),
    Floats(Vec<f64>),
    Text,
}

impl Values {
    /// An empty column.
    pub(super) fn new() -> Self {
        Self::Ints(Vec::new())
    }

    /// Appends what a field spells; an empty field is NaN.
    pub(super) fn push(&mut self, field: &[u8]) {
        let field = field.trim_ascii();
        if let Self::Ints(ints) = self {
            let text = std::str::from_utf8(field).ok();
            if let Some(value) = text.and_then(|text| text.parse().ok()) {
                ints.push(value);
                return;
            }
            // Room to grow as much as the integers had.
            let mut floats = Vec::with_capacity(ints.capacity());
            floats.extend(ints.iter().map(|&value| value as f64));
            *self = Self::Floats(floats);
        }
        if let Self::Floats(floats) = self {
            let value = if field.is_empty() {
                Some(f64::NAN)
            } else {
                float(field)
            };
            match value {
                Some(value) => floats.push(value),
                None => *self = Self::Text,
            }
        }
    }

    /// Value `i` as a coordinate.
    fn get(&self, i: usize) -> f64 {
        match self {
            Self::Ints(ints) => ints[i] as f64,
            Self::Floats(floats) => floats[i],
            Self::Text => f64::NAN,
        }
    }

    /// The column's data: i32 where that is wide enough; `None` for text.
    pub(super) fn into_data(self) -> Option<ColumnData> {
        match self {
            Self::Ints(ints) => {
                let narrow: Option<Vec<i32>> = ints
                    .iter()
                    .map(|&value| i32::try_from(value).ok())
                    .collect();
                Some(narrow.map_or_else(|| ints.into(), Into::into))
            }
            Self::Floats(floats) => Some(floats.into()),
            Self::Text => None,
        }
    }
}

/// Named columns of equal length.
pub(super) struct Table {
    pub(super) names: Vec<String>,
    pub(super) values: Vec<Values>,
}

impl Table {
    /// An empty table.
    pub(super) fn new(names: Vec<String>) -> Self {
        let values = vec![Values::new(); names.len()];
        Self { names, values }
    }

    /// Splits off the position; the other columns of numbers stay, those of text become a warning.
    /// `axes` are three different columns without text.
    pub(super) fn into_parsed(self, axes: [usize; 3]) -> Result<Parsed, ParseError> {
        let Self { names, values } = self;
        let [x, y, z] = axes.map(|axis| &values[axis]);
        let rows = match x {
            Values::Ints(ints) => ints.len(),
            Values::Floats(floats) => floats.len(),
            Values::Text => 0,
        };
        let positions: Vec<DVec3> = (0..rows)
            .map(|i| DVec3::new(x.get(i), y.get(i), z.get(i)))
            .collect();
        let mut columns = Vec::new();
        let mut text = Vec::new();
        for (index, (name, values)) in names.into_iter().zip(values).enumerate() {
            if axes.contains(&index) {
                continue;
            }
            match values.into_data() {
                Some(data) => columns.push(Column::new(name, 1, data)),
                None => text.push(name),
            }
        }
        let mut warnings = Vec::new();
        if !text.is_empty() {
            warnings.push(format!(
                "columns that hold more than numbers were skipped: {}",
                text.join(", ")
            ));
        }
        Ok(Parsed {
            particles: assemble(positions, joined(columns))?,
            frames: 1,
            warnings,
            left_out: 0,
        })
    }
}

/// Joins neighbours `v:0 v:1 v:2` (ParaView) and `v[0] v[1] v[2]` of one type into a vector `v`.
fn joined(columns: Vec<Column>) -> Vec<Column> {
    let mut joined = Vec::new();
    let mut rest = columns.into_iter().peekable();
    while let Some(first) = rest.next() {
        let Some((stem, 0)) = indexed(&first.name) else {
            joined.push(first);
            continue;
        };
        let stem = stem.to_owned();
        let mut parts = vec![first];
        while let Some(next) = rest.next_if(|next| {
            indexed(&next.name) == Some((&stem, parts.len()))
                && next.data.type_name() == parts[0].data.type_name()
        }) {
            parts.push(next);
        }
        if parts.len() == 1 {
            joined.append(&mut parts);
        } else {
            joined.push(interleaved(stem, &parts));
        }
    }
    joined
}

/// `("v", 2)` of `v:2` and `v[2]`.
fn indexed(name: &str) -> Option<(&str, usize)> {
    let (stem, index) = match name.strip_suffix(']') {
        Some(open) => open.rsplit_once('[')?,
        None => name.rsplit_once(':')?,
    };
    Some((stem, index.parse().ok()?)).filter(|(stem, _)| !stem.is_empty())
}

fn interleaved(name: String, parts: &[Column]) -> Column {
    let rows = parts[0].rows();
    macro_rules! by_type {
        ($($variant:ident)*) => {
            match &parts[0].data {
                $(ColumnData::$variant(_) => {
                    let slices: Vec<_> = parts
                        .iter()
                        .filter_map(|part| match &part.data {
                            ColumnData::$variant(values) => Some(values),
                            _ => None,
                        })
                        .collect();
                    (0..rows)
                        .flat_map(|row| slices.iter().map(move |values| values[row]))
                        .collect::<Vec<_>>()
                        .into()
                })*
            }
        };
    }
    let data: ColumnData = by_type!(I8 U8 I16 U16 I32 U32 I64 U64 F32 F64);
    Column::new(name, parts.len(), data)
}

/// The columns that hold the position, by the names that programs give them.
pub(super) fn position_columns(names: &[String]) -> Option<[usize; 3]> {
    let plain: Vec<String> = names.iter().map(|name| without_unit(name)).collect();
    let find = |wanted: String| plain.iter().position(|name| *name == wanted);
    let schemes: [fn(char, usize) -> String; 16] = [
        |axis, _| axis.to_string(),
        |_, i| format!("points:{i}"),
        |_, i| format!("points_{i}"),
        |axis, _| format!("pos_{axis}"),
        |axis, _| format!("position_{axis}"),
        |axis, _| format!("pos.{axis}"),
        |axis, _| format!("position.{axis}"),
        |_, i| format!("position[{i}]"),
        |_, i| format!("pos[{i}]"),
        |_, i| format!("position:{i}"),
        |_, i| format!("position_{i}"),
        |_, i| format!("coordinates:{i}"),
        |axis, _| format!("p{axis}"),
        |axis, _| format!("pos{axis}"),
        |axis, _| format!("coord_{axis}"),
        |axis, _| format!("{axis}_coord"),
    ];
    schemes.iter().find_map(|scheme| {
        Some([
            find(scheme('x', 0))?,
            find(scheme('y', 1))?,
            find(scheme('z', 2))?,
        ])
    })
}

/// A name in lower case without a unit behind it: `X (m)` and `x[m]` are x.
fn without_unit(name: &str) -> String {
    let name = name.trim().to_lowercase();
    for (open, close) in [('(', ')'), ('[', ']')] {
        if let Some((stem, unit)) = name
            .strip_suffix(close)
            .and_then(|rest| rest.rsplit_once(open))
            && !unit.starts_with(|c: char| c.is_ascii_digit())
        {
            return stem.trim_end().to_owned();
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_found_under_their_usual_names() {
        let find = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            position_columns(&names)
        };
        assert_eq!(find(&["id", "X", "Y", "Z"]), Some([1, 2, 3]));
        assert_eq!(
            find(&["v:0", "Points:0", "Points:1", "Points:2"]),
            Some([1, 2, 3])
        );
        assert_eq!(
            find(&["position[2]", "position[1]", "position[0]"]),
            Some([2, 1, 0])
        );
        assert_eq!(find(&["X (m)", "Y (m)", "Z (m)"]), Some([0, 1, 2]));
        assert_eq!(find(&["pos_x", "pos_y", "pos_z", "vx"]), Some([0, 1, 2]));
        assert_eq!(find(&["x", "y", "points:2"]), None);
    }

    #[test]
    fn values_decide_the_type() {
        let column = |fields: &[&str]| {
            let mut values = Values::new();
            fields
                .iter()
                .for_each(|field| values.push(field.as_bytes()));
            values.into_data()
        };
        assert_eq!(column(&["1", " -2 "]), Some(vec![1_i32, -2].into()));
        assert_eq!(
            column(&["1", "3000000000"]),
            Some(vec![1_i64, 3_000_000_000].into())
        );
        assert_eq!(column(&["1", "0.5"]), Some(vec![1.0, 0.5].into()));
        assert_eq!(column(&["1", "red", "2"]), None);
        let Some(ColumnData::F64(missing)) = column(&["1", ""]) else {
            panic!("an empty field is NaN")
        };
        assert!(missing[1].is_nan());
    }

    #[test]
    fn numbered_neighbours_become_a_vector() {
        let column = |name: &str, value: f64| Column::new(name, 1, vec![value, value + 0.5]);
        let columns = joined(vec![
            column("v:0", 1.0),
            column("v:1", 2.0),
            column("rho", 9.0),
            column("w[0]", 3.0),
            column("a:1", 4.0),
        ]);
        assert_eq!(columns[0], Column::new("v", 2, vec![1.0, 2.0, 1.5, 2.5]));
        let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["v", "rho", "w[0]", "a:1"]);
    }
}
