//! CSV, TSV and semicolon-separated tables with a header (x, y, z under their usual names); a table
//! of numbers only is taken as x, y, z and further columns.

use super::table::{MAX_COLUMNS, Table, position_columns};
use super::text::{float, lines, quote};
use super::{ParseError, Parsed, Place};
use ::csv::{ByteRecord, ReaderBuilder, Trim};

const DELIMITERS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// The first two lines that are neither empty nor comments, without a byte order mark.
fn first_lines(bytes: &[u8]) -> Option<(&[u8], Option<&[u8]>)> {
    let start = &bytes[..bytes.len().min(1 << 16)];
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let mut lines = lines(start, 1)
        .map(|(_, line)| line)
        .filter(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#"));
    Some((lines.next()?, lines.next()))
}

/// The delimiter that a line has most of.
fn delimiter(line: &[u8]) -> Option<u8> {
    let count = |delimiter: u8| line.iter().filter(|&&byte| byte == delimiter).count();
    DELIMITERS
        .into_iter()
        .rev()
        .max_by_key(|&delimiter| count(delimiter))
        .filter(|&delimiter| count(delimiter) >= 2)
}

fn fields(line: &[u8], delimiter: u8) -> usize {
    line.split(|&byte| byte == delimiter).count()
}

/// Whether the content is text whose first lines have at least three fields each.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let Some((first, second)) = first_lines(bytes) else {
        return false;
    };
    let readable = |line: &[u8]| {
        std::str::from_utf8(line)
            .is_ok_and(|line| !line.contains(|c: char| c.is_control() && c != '\t'))
    };
    delimiter(first).is_some_and(|delimiter| {
        readable(first)
            && second.is_none_or(|second| {
                readable(second) && fields(second, delimiter) == fields(first, delimiter)
            })
    })
}

/// Reads the table.
pub(super) fn read(bytes: &[u8], _frame: usize) -> Result<Parsed, ParseError> {
    let Some((delimiter, first)) =
        first_lines(bytes).and_then(|(first, _)| Some((delimiter(first)?, first)))
    else {
        return Err(ParseError::new(
            Place::Whole,
            "no line with three fields separated by commas, semicolons or tabs",
        ));
    };
    if fields(first, delimiter) > MAX_COLUMNS {
        return Err(ParseError::new(
            Place::Line(1),
            format!("more than {MAX_COLUMNS} columns"),
        ));
    }
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(bytes);
    let mut record = ByteRecord::new();
    let mut next = |record: &mut ByteRecord| {
        reader
            .read_byte_record(record)
            .map_err(|error| ParseError::new(Place::Whole, error.to_string()))
    };
    if !next(&mut record)? {
        return Err(ParseError::new(Place::Whole, "the table is empty"));
    }
    if record.len() < 3 {
        return Err(ParseError::new(
            Place::Line(record.position().map_or(1, ::csv::Position::line)),
            format!("{} fields, a position needs three", record.len()),
        ));
    }
    let headless = record.iter().all(|field| float::<f64>(field).is_some());
    let names: Vec<String> = if headless {
        let extra = (4..=record.len()).map(|column| format!("column_{column}"));
        ["x", "y", "z"]
            .map(str::to_owned)
            .into_iter()
            .chain(extra)
            .collect()
    } else {
        record
            .iter()
            .map(|field| String::from_utf8_lossy(field).into_owned())
            .collect()
    };
    let Some(axes) = position_columns(&names) else {
        return Err(no_position(&names));
    };
    let width = record.len();
    let mut table = Table::new(names);
    let mut more = headless || next(&mut record)?;
    while more {
        add_row(&mut table, &record, width, axes)?;
        more = next(&mut record)?;
    }
    let mut parsed = table.into_parsed(axes)?;
    if headless {
        parsed.warnings.insert(
            0,
            "the table has no header; its first three columns were taken as x, y and z".to_owned(),
        );
    }
    Ok(parsed)
}

fn add_row(
    table: &mut Table,
    record: &ByteRecord,
    width: usize,
    axes: [usize; 3],
) -> Result<(), ParseError> {
    let line = || Place::Line(record.position().map_or(0, ::csv::Position::line));
    if record.len() != width {
        return Err(ParseError::new(
            line(),
            format!("{} fields, the first line has {width}", record.len()),
        ));
    }
    for axis in axes {
        let field = &record[axis];
        if !field.is_empty() && float::<f64>(field).is_none() {
            return Err(ParseError::new(
                line(),
                format!(
                    "expected a number for {}, found {}",
                    table.names[axis],
                    quote(field)
                ),
            ));
        }
    }
    for (values, field) in table.values.iter_mut().zip(record) {
        values.push(field);
    }
    Ok(())
}

fn no_position(names: &[String]) -> ParseError {
    let shown: Vec<String> = names
        .iter()
        .take(12)
        .map(|name| quote(name.as_bytes()))
        .collect();
    let more = if names.len() > 12 { ", …" } else { "" };
    ParseError::new(
        Place::Line(1),
        format!(
            "no columns for the position; the header has {}{more}",
            shown.join(", ")
        ),
    )
    .with_help("name the columns of the position x, y, z (or Points:0 …, pos_x …, position[0] …)")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::Column;
    use glam::DVec3;

    #[test]
    fn any_delimiter_and_naming_is_read() {
        for text in [
            "id,X,Y,Z,rho\n7,1,2.5,3,0.5\n8,-1,0,1e3,1\n",
            "id;x;y;z;rho\r\n7;1;2.5;3;0.5\r\n8;-1;0;1e3;1",
            "# made by hand\nid\tpos_x\tpos_y\tpos_z\trho\n7\t1\t2.5\t3\t0.5\n\n8\t-1\t0\t1e3\t1\n",
            "\u{feff}\"id\",\"Points:0\",\"Points:1\",\"Points:2\",\"rho\"\n7,1,2.5,3,0.5\n8,-1,0,1e3,1\n",
            "id , px , py , pz , rho\n 7 , 1 , 2.5 , 3 , 0.5 \n 8 , -1 , 0 , 1e3 , 1 \n",
        ] {
            assert!(detect(text.as_bytes()), "{text:?}");
            let parsed = read(text.as_bytes(), 0).unwrap();
            let positions = [DVec3::new(1.0, 2.5, 3.0), DVec3::new(-1.0, 0.0, 1000.0)];
            assert_eq!(parsed.particles.positions, positions, "{text:?}");
            assert_eq!(
                parsed.particles.columns,
                [
                    Column::new("id", 1, vec![7, 8]),
                    Column::new("rho", 1, vec![0.5, 1.0])
                ]
            );
            assert_eq!(parsed.warnings, [""; 0]);
        }
    }

    #[test]
    fn text_columns_are_skipped_with_a_warning_and_gaps_are_nan() {
        let parsed = read(b"name,x,y,z,m\nab,1,2,,4\n\"c,d\",1,2,3,\n", 0).unwrap();
        assert!(parsed.particles.positions[0].z.is_nan());
        assert_eq!(parsed.particles.columns.len(), 1);
        assert!(parsed.particles.columns[0].get(1, 0).is_nan());
        assert!(parsed.warnings[0].contains("name"), "{:?}", parsed.warnings);
    }

    #[test]
    fn numbers_without_a_header_are_positions() {
        let parsed = read(b"1,2,3,9\n4,5,6,8\n", 0).unwrap();
        assert_eq!(parsed.particles.positions[1], DVec3::new(4.0, 5.0, 6.0));
        assert_eq!(
            parsed.particles.columns,
            [Column::new("column_4", 1, vec![9, 8])]
        );
        assert!(parsed.warnings[0].contains("header"));
    }

    #[test]
    fn errors_say_what_is_missing_and_where() {
        for (text, line, problem) in [
            ("a,b,c\n1,2,3\n", 1, "\"a\", \"b\", \"c\""),
            ("2\r;2;\n1;2;3\n", 1, "1 fields, a position needs three"),
            ("x,y,z\n1,2\n", 2, "2 fields, the first line has 3"),
            ("x,y,z\n1,2,3\n1,two,3\n", 3, "\"two\""),
        ] {
            let error = read(text.as_bytes(), 0).unwrap_err();
            assert_eq!(error.place, Place::Line(line), "{text:?}");
            assert!(error.problem.contains(problem), "{text:?}: {error}");
        }
        let wide = ",".repeat(MAX_COLUMNS);
        assert!(
            read(wide.as_bytes(), 0)
                .unwrap_err()
                .problem
                .contains("columns")
        );
        for text in [
            "",
            "hello\n",
            "0 1 2\n",
            "a,b,c\n\u{1},2,3\n",
            "x,y,z\n1 2 3\n",
        ] {
            assert!(!detect(text.as_bytes()), "{text:?}");
        }
    }
}
