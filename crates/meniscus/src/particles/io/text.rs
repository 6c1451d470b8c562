//! Numbers and lines of text formats.

use super::{ParseError, Place};
use crate::particles::ColumnData;

/// The lines of some text with their numbers, counted from `first`; ends are `\n`, `\r\n` or, where
/// the text has no `\n` at all, `\r`. Lines come without their end.
pub(super) fn lines(bytes: &[u8], first: u64) -> impl Iterator<Item = (u64, &[u8])> {
    let end = line_end(bytes);
    let whole = bytes.strip_suffix(&[end]).unwrap_or(bytes);
    let pieces = (!bytes.is_empty()).then(|| whole.split(move |&byte| byte == end));
    pieces
        .into_iter()
        .flatten()
        .zip(first..)
        .map(|(line, number)| (number, line.strip_suffix(b"\r").unwrap_or(line)))
}

/// The byte that ends lines: `\r` for old Macintosh text without any `\n`.
pub(super) fn line_end(bytes: &[u8]) -> u8 {
    match bytes.iter().find(|&&byte| byte == b'\n' || byte == b'\r') {
        Some(b'\r') if !bytes.contains(&b'\n') => b'\r',
        _ => b'\n',
    }
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// A float as programs print it: also `nan(ind)`, `1.#INF`, Fortran's `1.5D+02`.
pub(super) fn float<T: std::str::FromStr + From<f32>>(word: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['+', '-']);
    if unsigned.starts_with("nan(")
        || unsigned.starts_with("1.#ind")
        || unsigned.starts_with("1.#qnan")
    {
        return Some(f32::NAN.into());
    }
    if unsigned.starts_with("1.#inf") {
        let infinity = if lower.starts_with('-') {
            f32::NEG_INFINITY
        } else {
            f32::INFINITY
        };
        return Some(infinity.into());
    }
    let fortran =
        lower.contains('d') && unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    fortran
        .then(|| lower.replacen('d', "e", 1).parse().ok())
        .flatten()
}

/// An integer, also where it is written as a float without a fraction.
fn integer<T: std::str::FromStr + TryFrom<i128>>(word: &[u8]) -> Option<T> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(value) = text.parse() {
        return Some(value);
    }
    let value: f64 = text.parse().ok()?;
    (value.fract() == 0.0 && value.abs() < 2e19)
        .then(|| T::try_from(value as i128).ok())
        .flatten()
}

/// Appends the number that `word` spells, if the column's type can hold it.
pub(super) fn push(data: &mut ColumnData, word: &[u8]) -> Option<()> {
    match data {
        ColumnData::I8(values) => values.push(integer(word)?),
        ColumnData::U8(values) => values.push(integer(word)?),
        ColumnData::I16(values) => values.push(integer(word)?),
        ColumnData::U16(values) => values.push(integer(word)?),
        ColumnData::I32(values) => values.push(integer(word)?),
        ColumnData::U32(values) => values.push(integer(word)?),
        ColumnData::I64(values) => values.push(integer(word)?),
        ColumnData::U64(values) => values.push(integer(word)?),
        ColumnData::F32(values) => values.push(float(word)?),
        ColumnData::F64(values) => values.push(float(word)?),
    }
    Some(())
}

/// A word for an error message: printable and short.
pub(super) fn quote(word: &[u8]) -> String {
    let start = String::from_utf8_lossy(&word[..word.len().min(40)]);
    let dots = if word.len() > 40 { "…" } else { "" };
    format!("{:?}{dots}", start)
}

/// The error "`expected`, found `word`" in line `line`.
pub(super) fn unexpected(line: u64, expected: &str, word: &[u8]) -> ParseError {
    ParseError::new(
        Place::Line(line),
        format!("expected {expected}, found {}", quote(word)),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_any_of_the_three_ways() {
        for text in ["a b\n\nc", "a b\r\n\r\nc\r\n", "a b\r\rc\r", "a b\n\nc\n"] {
            let found: Vec<_> = lines(text.as_bytes(), 5).collect();
            assert_eq!(found, [(5, &b"a b"[..]), (6, b""), (7, b"c")], "{text:?}");
        }
        assert_eq!(lines(b"", 1).count(), 0);
    }

    #[test]
    fn floats_are_read_as_programs_print_them() {
        assert_eq!(float::<f64>(b"-7e-2"), Some(-0.07));
        assert_eq!(float::<f64>(b"1.5D+02"), Some(150.0));
        assert_eq!(float::<f32>(b".5"), Some(0.5));
        assert_eq!(float::<f64>(b"-1.#INF"), Some(f64::NEG_INFINITY));
        for nan in [
            &b"nan"[..],
            b"-nan",
            b"NaN",
            b"-nan(ind)",
            b"-1.#IND00",
            b"1.#QNAN",
        ] {
            assert!(float::<f64>(nan).is_some_and(f64::is_nan), "{}", quote(nan));
        }
        for wrong in [&b""[..], b"abc", b"d", b"1.5x", b"0x10", b"\xff"] {
            assert_eq!(float::<f64>(wrong), None, "{}", quote(wrong));
        }
    }

    #[test]
    fn integers_must_fit() {
        let mut bytes = ColumnData::U8(Vec::new());
        assert_eq!(push(&mut bytes, b"255"), Some(()));
        assert_eq!(push(&mut bytes, b"3.0"), Some(()));
        for wrong in [&b"256"[..], b"-1", b"1.5", b"1e30", b"nan"] {
            assert_eq!(push(&mut bytes, wrong), None, "{}", quote(wrong));
        }
        assert_eq!(bytes, ColumnData::U8(vec![255, 3]));
    }
}
