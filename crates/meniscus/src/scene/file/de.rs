//! Reads typed data from a [`Node`]: a serde deserializer whose errors know their place.

use super::error::{SceneError, SceneErrorKind};
use super::node::{Entry, Node, Value};
use super::suggest::help_for;
use serde::de::{
    DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use std::fmt::Display;
use std::marker::PhantomData;
use std::ops::Range;

/// An error on its way up to the root.
#[derive(Debug)]
pub(super) struct DeError {
    problem: Problem,
    help: Option<String>,
    /// Keys and indices from the innermost outwards.
    path: Vec<String>,
    pub(super) span: Option<Range<usize>>,
}

#[derive(Debug)]
enum Problem {
    UnknownKey(String),
    /// What follows the key's name in the message.
    Value(String),
}

impl DeError {
    fn value(what: String) -> Self {
        Self {
            problem: Problem::Value(what),
            help: None,
            path: Vec::new(),
            span: None,
        }
    }

    fn at(mut self, span: &Range<usize>) -> Self {
        self.span.get_or_insert_with(|| span.clone());
        self
    }

    fn inside(mut self, step: impl Display) -> Self {
        self.path.push(step.to_string());
        self
    }

    /// The finished message, with the dotted key.
    pub(super) fn into_scene_error(self) -> SceneError {
        let path: Vec<&str> = self.path.iter().rev().map(String::as_str).collect();
        let name = path
            .iter()
            .rev()
            .find(|step| step.parse::<usize>().is_err())
            .copied();
        let message = match (&self.problem, name) {
            (Problem::UnknownKey(key), Some(table)) => {
                format!("unknown key `{key}` in `{table}`")
            }
            (Problem::UnknownKey(key), None) => format!("unknown key `{key}`"),
            (Problem::Value(what), Some(key)) => format!("`{key}`: {what}"),
            (Problem::Value(what), None) => what.clone(),
        };
        let error = SceneError::new(SceneErrorKind::Schema, message).at(path.join("."));
        match self.help {
            Some(help) => error.with_help(help),
            None => error,
        }
    }
}

impl Display for DeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.problem {
            Problem::UnknownKey(key) => write!(f, "unknown key `{key}`"),
            Problem::Value(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for DeError {}

/// serde's word for what was expected, in the words of scene files.
fn wanted(expected: &dyn Expected) -> String {
    let text = expected.to_string();
    let numbers = |count: &str| format!("{count} numbers");
    match text.as_str() {
        "f64" => "a number".to_owned(),
        "u32" => "a whole number, 0 or more".to_owned(),
        "a string" | "path string" => "a text in quotes".to_owned(),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        "a map" => "a table".to_owned(),
        "a sequence of 3 f64 values" => numbers("3"),
        _ if text.starts_with("struct ") => "a table of keys".to_owned(),
        _ => match text.strip_prefix("an array of length ") {
            Some(count) => numbers(count),
            None => text,
        },
    }
}

fn seen(unexpected: &Unexpected<'_>) -> String {
    match unexpected {
        Unexpected::Bool(value) => value.to_string(),
        Unexpected::Signed(number) => number.to_string(),
        Unexpected::Unsigned(number) => number.to_string(),
        Unexpected::Float(number) => number.to_string(),
        Unexpected::Str(text) => format!("the text \"{text}\""),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "a table".to_owned(),
        Unexpected::Unit | Unexpected::Option => "nothing".to_owned(),
        other => other.to_string(),
    }
}

impl Error for DeError {
    fn custom<T: Display>(message: T) -> Self {
        Self::value(message.to_string())
    }

    fn invalid_type(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        let error = Self::value(format!(
            "expected {}, found {}",
            wanted(expected),
            seen(&unexpected)
        ));
        let help = match (unexpected, expected.to_string().as_str()) {
            (Unexpected::Map, "a sequence") => {
                Some("it is a list of tables: in TOML write [[…]] with two brackets, in JSON [{…}]")
            }
            (Unexpected::Seq, text) if text.starts_with("struct ") => {
                Some("it is a single table: in TOML write […] with one bracket, in JSON {…}")
            }
            _ => None,
        };
        Self {
            help: help.map(str::to_owned),
            ..error
        }
    }

    fn invalid_value(unexpected: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::value(format!(
            "expected {}, found {}",
            wanted(expected),
            seen(&unexpected)
        ))
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        Self::value(format!("expected {}, found {length}", wanted(expected)))
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Self {
            help: Some(help_for(variant, expected, "it can be")),
            ..Self::value(format!("there is no `{variant}`"))
        }
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self {
            problem: Problem::UnknownKey(field.to_owned()),
            help: Some(help_for(field, expected, "the keys here are")),
            path: Vec::new(),
            span: None,
        }
    }

    fn missing_field(field: &'static str) -> Self {
        Self::value(format!("the key `{field}` is missing"))
    }
}

impl<'de> Deserializer<'de> for &'de Node {
    type Error = DeError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DeError> {
        match &self.value {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Integer(number) => visitor.visit_i64(*number),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Text(text) => visitor.visit_borrowed_str(text),
            Value::Date(text) => Err(DeError::invalid_type(
                Unexpected::Other(&format!("the date {text}")),
                &visitor,
            )),
            Value::List(items) => visit_list(items, visitor),
            Value::Table(entries) => visitor.visit_map(Entries {
                rest: entries.iter(),
                current: None,
            }),
        }
        .map_err(|error| error.at(&self.span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DeError> {
        match self.value {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, DeError> {
        visitor.visit_newtype_struct(self)
    }

    /// A struct is a table, never a list of its values in order.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DeError> {
        match &self.value {
            Value::List(_) => {
                let error = DeError::invalid_type(Unexpected::Seq, &visitor);
                Err(error.at(&self.span))
            }
            _ => self.deserialize_any(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DeError> {
        match &self.value {
            Value::Text(text) => visitor
                .visit_enum(text.as_str().into_deserializer())
                .map_err(|error: DeError| error.at(&self.span)),
            _ => {
                let list = super::suggest::one_of(variants.iter().copied());
                self.deserialize_any(Nothing(format!("one of the names {list}"), PhantomData))
            }
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// A visitor that takes nothing: any value is an error that says what was expected.
struct Nothing<T>(String, PhantomData<T>);

impl<'de, T> Visitor<'de> for Nothing<T> {
    type Value = T;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

fn visit_list<'de, V: Visitor<'de>>(items: &'de [Node], visitor: V) -> Result<V::Value, DeError> {
    let mut list = Items { items, next: 0 };
    let value = visitor.visit_seq(&mut list)?;
    if list.next < items.len() {
        return Err(DeError::value(format!(
            "expected {} elements, found {}",
            list.next,
            items.len()
        )));
    }
    Ok(value)
}

struct Items<'de> {
    items: &'de [Node],
    next: usize,
}

impl<'de> SeqAccess<'de> for &mut Items<'de> {
    type Error = DeError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, DeError> {
        let Some(item) = self.items.get(self.next) else {
            return Ok(None);
        };
        let index = self.next;
        self.next += 1;
        seed.deserialize(item)
            .map(Some)
            .map_err(|error| error.inside(index))
    }
}

struct Entries<'de> {
    rest: std::slice::Iter<'de, Entry>,
    current: Option<&'de Entry>,
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = DeError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DeError> {
        self.current = self.rest.next();
        let Some(entry) = self.current else {
            return Ok(None);
        };
        let key = serde::de::value::BorrowedStrDeserializer::new(&entry.key);
        seed.deserialize(key)
            .map(Some)
            .map_err(|error: DeError| error.at(&entry.key_span))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, DeError> {
        let Some(entry) = self.current.take() else {
            return Err(DeError::value("a value was read before its key".to_owned()));
        };
        seed.deserialize(&entry.node)
            .map_err(|error| error.at(&entry.node.span).inside(&entry.key))
    }
}
