//! `--set key.path=value`: one key of a scene, changed as if it were written in the file.

use super::error::{SceneError, SceneErrorKind};
use super::node::{Entry, Node, Value};
use super::{from_node, toml_text};
use crate::scene::Scene;
use std::ops::Range;

/// The flag, as error messages name it.
const NAME: &str = "--set";
/// More parts than any key has.
const MAX_STEPS: usize = 16;
/// Keys of the root that hold lists.
const LISTS: [&str; 7] = [
    "surface", "instance", "mesh", "sphere", "plane", "clip", "light",
];

impl Scene {
    /// Sets the value at a dotted key: `surface.0.threshold`, `camera.eye`, `material.clay.color`.
    /// Lists count from 0; the number after the last appends. The value is written as in TOML;
    /// quotes around a text and brackets around a list of numbers may be left out.
    ///
    /// Types are checked here; whether the scene still makes sense is [`Scene::validate`]'s to say,
    /// once everything is set.
    ///
    /// # Errors
    /// When there is no such key or the value is of the wrong type; the scene is then unchanged. The
    /// excerpt is `key=value`.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SceneError> {
        let text = format!("{key}={value}");
        if key.split('.').count() > MAX_STEPS {
            let error = SceneError::new(SceneErrorKind::Schema, "there is no key that long");
            return Err(error.at(key).pointing(NAME, &text, 0..key.len()));
        }
        let value_span = key.len() + 1..text.len();
        let as_text = Value::Text(value.to_owned());
        let parsed = parsed_value(value);
        let mut result = self.with_value(key, &text, value_span.clone(), parsed.clone());
        // A name may look like a number.
        if result.is_err()
            && parsed != as_text
            && let Ok(scene) = self.with_value(key, &text, value_span, as_text)
        {
            result = Ok(scene);
        }
        *self = result?;
        Ok(())
    }

    fn with_value(
        &self,
        key: &str,
        text: &str,
        span: Range<usize>,
        value: Value,
    ) -> Result<Self, SceneError> {
        let whole = toml::Value::try_from(self).map_err(|error| {
            SceneError::new(
                SceneErrorKind::Invalid,
                format!("cannot change the scene: {error}"),
            )
        })?;
        let mut root = unplaced(whole);
        let value = with_span(value, &span);
        insert(&mut root, key, 0, Node { value, span }).map_err(|(message, span)| {
            SceneError::new(SceneErrorKind::Schema, message)
                .at(key)
                .pointing(NAME, text, span)
        })?;
        from_node(&root).map_err(|error| {
            let span = error.span.clone().unwrap_or(0..key.len());
            error.into_scene_error().pointing(NAME, text, span)
        })
    }
}

/// The value as TOML reads it, as a list if it is bare numbers with commas, else as text.
fn parsed_value(value: &str) -> Value {
    let read = |text: &str| {
        let node = toml_text::parse(text).ok()?;
        match node.value {
            Value::Table(entries) if entries.len() == 1 => entries.into_iter().next(),
            _ => None,
        }
    };
    let is_number = |node: &Node| matches!(node.value, Value::Integer(_) | Value::Float(_));
    if let Some(entry) = read(&format!("value = {value}")) {
        return entry.node.value;
    }
    match read(&format!("value = [{value}]")).map(|entry| entry.node.value) {
        Some(Value::List(items)) if items.len() > 1 && items.iter().all(is_number) => {
            Value::List(items)
        }
        _ => Value::Text(value.to_owned()),
    }
}

/// The value with every piece of it pointing at `span`.
fn with_span(value: Value, span: &Range<usize>) -> Value {
    let node = |node: Node| Node {
        value: with_span(node.value, span),
        span: span.clone(),
    };
    match value {
        Value::List(items) => Value::List(items.into_iter().map(node).collect()),
        Value::Table(entries) => Value::Table(
            entries
                .into_iter()
                .map(|entry| Entry {
                    key_span: span.clone(),
                    node: node(entry.node),
                    key: entry.key,
                })
                .collect(),
        ),
        other => other,
    }
}

/// Puts `new` at `key`, the bytes of the argument from `start` on.
fn insert(
    node: &mut Node,
    key: &str,
    start: usize,
    new: Node,
) -> Result<(), (String, Range<usize>)> {
    let (step, rest) = match key.split_once('.') {
        Some((step, rest)) => (step, Some(rest)),
        None => (key, None),
    };
    let span = start..start + step.len();
    if step.is_empty() {
        return Err(("a key has an empty part".to_owned(), span));
    }
    let child = match &mut node.value {
        Value::Table(entries) => {
            let index = entries.iter().position(|entry| entry.key == step);
            let index = index.unwrap_or_else(|| {
                let value = if start == 0 && LISTS.contains(&step) {
                    Value::List(Vec::new())
                } else {
                    Value::Table(Vec::new())
                };
                entries.push(Entry {
                    key: step.to_owned(),
                    key_span: span.clone(),
                    node: Node {
                        value,
                        span: span.clone(),
                    },
                });
                entries.len() - 1
            });
            entries[index].key_span = span.clone();
            &mut entries[index].node
        }
        Value::List(items) => {
            let count = items.len();
            match step.parse::<usize>() {
                Ok(index) if index <= count => {
                    if index == count {
                        items.push(Node {
                            value: Value::Table(Vec::new()),
                            span: span.clone(),
                        });
                    }
                    &mut items[index]
                }
                Ok(index) => {
                    return Err((
                        format!("there is no number {index}: the list has {count}, counted from 0"),
                        span,
                    ));
                }
                Err(_) => {
                    return Err((
                        format!("`{step}` must be a number, counted from 0: this is a list"),
                        span,
                    ));
                }
            }
        }
        _ => return Err((format!("there is no `{step}` inside this value"), span)),
    };
    match rest {
        Some(rest) => insert(child, rest, span.end + 1, new),
        None => {
            *child = new;
            Ok(())
        }
    }
}

fn unplaced(value: toml::Value) -> Node {
    let value = match value {
        toml::Value::String(text) => Value::Text(text),
        toml::Value::Integer(number) => Value::Integer(number),
        toml::Value::Float(number) => Value::Float(number),
        toml::Value::Boolean(value) => Value::Bool(value),
        toml::Value::Datetime(date) => Value::Date(date.to_string()),
        toml::Value::Array(items) => Value::List(items.into_iter().map(unplaced).collect()),
        toml::Value::Table(table) => Value::Table(
            table
                .into_iter()
                .map(|(key, value)| Entry {
                    key,
                    key_span: 0..0,
                    node: unplaced(value),
                })
                .collect(),
        ),
    };
    Node { value, span: 0..0 }
}
