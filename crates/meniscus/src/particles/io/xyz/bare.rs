//! Tables of numbers separated by spaces: `x y z …` rows, with or without a line of names.

use crate::particles::io::table::{MAX_COLUMNS, Table, position_columns};
use crate::particles::io::text::{float, lines, quote, words};
use crate::particles::io::{ParseError, Parsed, Place};

/// Rows that detection looks at.
const ROWS: usize = 8;

fn numeric(word: &[u8]) -> bool {
    float::<f64>(word).is_some()
}

/// The words of a line that may carry names: without the `#` of a comment.
fn names(line: &[u8]) -> Vec<String> {
    let line = line.trim_ascii_start();
    words(line.strip_prefix(b"#").unwrap_or(line))
        .map(|word| String::from_utf8_lossy(word).into_owned())
        .collect()
}

fn is_comment(line: &[u8]) -> bool {
    line.trim_ascii_start().starts_with(b"#")
}

/// Whether the first rows are all of the same three or more numbers, after comments and at most one
/// line of names.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1 << 16)];
    let whole = start.len() == bytes.len();
    let mut rows = lines(start, 1)
        .map(|(_, line)| line)
        .filter(|line| !line.trim_ascii().is_empty() && !is_comment(line))
        .peekable();
    if let Some(first) = rows.peek()
        && !words(first).any(numeric)
        && position_columns(&names(first)).is_some()
    {
        rows.next();
    }
    let (mut width, mut seen) = (None, 0);
    while let Some(row) = rows.next() {
        // The last line of a longer file may be cut by the window.
        if seen == ROWS || (!whole && rows.peek().is_none()) {
            break;
        }
        let count = words(row).count();
        if count < 3 || !words(row).all(numeric) || *width.get_or_insert(count) != count {
            return false;
        }
        seen += 1;
    }
    seen > 0
}

/// Reads the rows.
pub(super) fn read(bytes: &[u8]) -> Result<Parsed, ParseError> {
    let mut table: Option<(Table, [usize; 3])> = None;
    let mut heading: Option<Vec<String>> = None;
    for (number, line) in lines(bytes, 1) {
        let place = Place::Line(number);
        if line.trim_ascii().is_empty() {
            continue;
        }
        if is_comment(line) || (heading.is_none() && table.is_none() && !words(line).any(numeric)) {
            if table.is_none() && position_columns(&names(line)).is_some() {
                heading = Some(names(line));
            }
            continue;
        }
        let (table, axes) = match &mut table {
            Some(table) => table,
            None => table.insert(start(line, place, heading.take())?),
        };
        let width = table.values.len();
        let mut count = 0;
        for (index, word) in words(line).enumerate() {
            let Some(values) = table.values.get_mut(index) else {
                count = words(line).count();
                break;
            };
            if axes.contains(&index) && !numeric(word) {
                let problem = format!("expected a coordinate, found {}", quote(word));
                return Err(ParseError::new(place, problem));
            }
            values.push(word);
            count += 1;
        }
        if count != width {
            let problem = format!("{count} numbers, the first row has {width}");
            return Err(ParseError::new(place, problem));
        }
    }
    match table {
        Some((table, axes)) => table.into_parsed(axes),
        None => Err(ParseError::new(Place::Whole, "no row of numbers")),
    }
}

/// The table that the first row calls for; names count only if there is one for each number.
fn start(
    row: &[u8],
    place: Place,
    heading: Option<Vec<String>>,
) -> Result<(Table, [usize; 3]), ParseError> {
    let width = words(row).count();
    if !(3..=MAX_COLUMNS).contains(&width) {
        let problem = format!(
            "expected rows of 3 to {MAX_COLUMNS} numbers, found {}",
            quote(row)
        );
        return Err(ParseError::new(place, problem));
    }
    let named = heading.filter(|names| names.len() == width);
    let names = named.unwrap_or_else(|| {
        let extra = (4..=width).map(|column| format!("column_{column}"));
        ["x", "y", "z"]
            .map(str::to_owned)
            .into_iter()
            .chain(extra)
            .collect()
    });
    let axes = position_columns(&names).unwrap_or([0, 1, 2]);
    Ok((Table::new(names), axes))
}
