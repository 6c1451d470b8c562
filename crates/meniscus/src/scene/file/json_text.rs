//! JSON text to [`Node`]: serde_json parses, and its borrowed raw values tell where each piece stands.

use super::node::{Entry, Node, Value};
use super::toml_text::SyntaxError;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::ops::Range;

pub(super) fn parse(text: &str) -> Result<Node, SyntaxError> {
    // One pass over everything first: syntax, depth (at most 128) and trailing text.
    serde_json::from_str::<IgnoredAny>(text).map_err(|error| syntax_error(text, &error))?;
    let raw: &RawValue = part(text, text)?;
    node(text, raw)
}

fn part<'a, T: Deserialize<'a>>(text: &str, part: &'a str) -> Result<T, SyntaxError> {
    serde_json::from_str(part).map_err(|error| SyntaxError {
        span: span_of(text, part),
        message: error.to_string(),
    })
}

/// Where the slice `part` of `text` stands in it.
fn span_of(text: &str, part: &str) -> Range<usize> {
    let start = (part.as_ptr() as usize).wrapping_sub(text.as_ptr() as usize);
    start..start.saturating_add(part.len())
}

fn node(text: &str, raw: &RawValue) -> Result<Node, SyntaxError> {
    let piece = raw.get();
    let span = span_of(text, piece);
    let value = match piece.as_bytes().first() {
        Some(b'{') => Value::Table(entries(text, piece, span.start)?),
        Some(b'[') => {
            let items: Vec<&RawValue> = part(text, piece)?;
            let items: Result<_, _> = items.into_iter().map(|item| node(text, item)).collect();
            Value::List(items?)
        }
        Some(b'"') => Value::Text(part(text, piece)?),
        Some(b't' | b'f') => Value::Bool(part(text, piece)?),
        Some(b'n') => Value::Null,
        // The standard library reads floats exactly; the syntax has been checked.
        _ => match piece.parse() {
            Ok(integer) => Value::Integer(integer),
            Err(_) => Value::Float(piece.parse().unwrap_or(f64::NAN)),
        },
    };
    Ok(Node { value, span })
}

fn entries(text: &str, object: &str, start: usize) -> Result<Vec<Entry>, SyntaxError> {
    let pairs: Pairs<'_> = part(text, object)?;
    let mut entries: Vec<Entry> = Vec::with_capacity(pairs.0.len());
    let mut searched = start + 1;
    for (key, raw) in pairs.0 {
        let value = node(text, raw)?;
        // Between the last value and this one: a comma, the key in quotes, a colon, white space.
        let between = &text[searched..value.span.start];
        let open = between.find('"').unwrap_or(0);
        let close = between.rfind('"').unwrap_or(open);
        let key_span = searched + open..searched + close + 1;
        if entries.iter().any(|entry| entry.key == key) {
            return Err(SyntaxError {
                span: key_span,
                message: format!("the key `{key}` stands twice in one object"),
            });
        }
        searched = value.span.end;
        entries.push(Entry {
            key,
            key_span,
            node: value,
        });
    }
    Ok(entries)
}

/// The pairs of an object in the order of the text, double ones included.
struct Pairs<'a>(Vec<(String, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Pairs<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PairsVisitor;
        impl<'de> Visitor<'de> for PairsVisitor {
            type Value = Vec<(String, &'de RawValue)>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut pairs = Vec::new();
                while let Some(pair) = map.next_entry()? {
                    pairs.push(pair);
                }
                Ok(pairs)
            }
        }
        deserializer.deserialize_map(PairsVisitor).map(Pairs)
    }
}

fn syntax_error(text: &str, error: &serde_json::Error) -> SyntaxError {
    let line_start: usize = text
        .split_inclusive('\n')
        .take(error.line().saturating_sub(1))
        .map(str::len)
        .sum();
    let at = line_start + error.column().saturating_sub(1);
    let full = error.to_string();
    // Without serde_json's own " at line 3 column 5".
    let message = full
        .rsplit_once(" at line ")
        .map_or(full.as_str(), |(what, _)| what);
    SyntaxError {
        span: at..at + 1,
        message: message.to_owned(),
    }
}
