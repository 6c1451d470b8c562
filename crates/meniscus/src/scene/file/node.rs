//! A tree of values that remembers where each was written: what TOML and JSON have in common.

use std::ops::Range;

/// A value and its bytes in the text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) span: Range<usize>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// JSON null: as if the key were not there.
    Null,
    Bool(bool),
    Integer(i64),
    Float(f64),
    Text(String),
    /// A date or time, which no key takes; its text.
    Date(String),
    List(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) key_span: Range<usize>,
    pub(super) node: Node,
}

impl Node {
    /// The bytes of the value at a dotted key, or of the nearest table around it that is written.
    pub(super) fn locate(&self, key: &str) -> Range<usize> {
        if key.is_empty() {
            return self.span.clone();
        }
        match &self.value {
            // Names may contain dots, so try every entry that `key` can start with.
            Value::Table(entries) => entries
                .iter()
                .find_map(|entry| {
                    let rest = key.strip_prefix(entry.key.as_str())?;
                    if rest.is_empty() && matches!(entry.node.value, Value::Table(_)) {
                        return Some(entry.key_span.clone());
                    }
                    (rest.is_empty() || rest.starts_with('.'))
                        .then(|| entry.node.locate(rest.trim_start_matches('.')))
                })
                .unwrap_or_else(|| self.span.clone()),
            Value::List(items) => {
                let (index, rest) = key.split_once('.').unwrap_or((key, ""));
                match index.parse().ok().and_then(|index: usize| items.get(index)) {
                    Some(item) => item.locate(rest),
                    None => self.span.clone(),
                }
            }
            _ => self.span.clone(),
        }
    }
}
