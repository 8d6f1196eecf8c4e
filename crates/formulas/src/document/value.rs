//! A value of TOML with its place.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::vector_keys::QuotedText;
use crate::error::{Fault, Problem};

/// A key with its value.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) key: String,
    /// The byte where the key begins.
    pub(crate) key_at: usize,
    pub(crate) value: Value,
}

/// The keys of a file or section, in the order of the text.
pub(crate) type Table = Vec<Entry>;

/// A value, and where it stands.
#[derive(Debug, Clone)]
pub(crate) struct Value {
    /// The byte where it begins.
    pub(crate) at: usize,
    pub(crate) found: Found,
}

/// What a value is.
#[derive(Debug, Clone)]
pub(crate) enum Found {
    Text {
        text: String,
        /// The byte where the text within the quotes begins, if it stands there letter by letter.
        inner: Option<usize>,
    },
    /// A number, and how it is written.
    Number(f64, String),
    List(Vec<Value>),
    Table(Table),
    /// A date or a time without quotes, as it is written.
    Date(String),
    Truth,
}

impl Value {
    /// A value as the parser gives it; `table` reads one of its tables.
    pub(super) fn of(
        value: &Spanned<DeValue<'_>>,
        quoted: &QuotedText<'_>,
        table: &dyn Fn(&DeTable<'_>) -> Table,
    ) -> Value {
        let span = value.span();
        let written = quoted.text().get(span.clone()).unwrap_or_default();
        let found = match value.get_ref() {
            DeValue::String(text) => Found::Text {
                inner: inner(written, text).map(|offset| quoted.original(span.start + offset)),
                text: text.to_string(),
            },
            DeValue::Integer(integer) => {
                // i128 takes what 64 bits do not, and what it does not take is a number still.
                let exact = i128::from_str_radix(integer.as_str(), integer.radix()).map(|value| value as f64);
                let value = exact.or_else(|_| integer.as_str().parse());
                Found::Number(value.unwrap_or(f64::INFINITY), written.to_string())
            }
            DeValue::Float(float) => {
                Found::Number(float.as_str().parse().unwrap_or(f64::NAN), written.to_string())
            }
            DeValue::Boolean(_) => Found::Truth,
            DeValue::Datetime(_) => Found::Date(written.to_string()),
            DeValue::Array(list) => {
                Found::List(list.iter().map(|value| Value::of(value, quoted, table)).collect())
            }
            DeValue::Table(inner) => Found::Table(table(inner)),
        };
        Value { at: quoted.original(span.start), found }
    }

    /// The text of a key that has one.
    pub(crate) fn text(&self, key: &str) -> Result<&str, Fault> {
        match &self.found {
            Found::Text { text, .. } => Ok(text),
            _ => {
                let (found, expected) = (self.words(), "text in quotes".to_string());
                Err(Fault::at(self.at, Problem::Value { found, expected }).of_key(key))
            }
        }
    }

    /// What it is, in words.
    pub(crate) fn words(&self) -> String {
        match &self.found {
            Found::Text { text, .. } if text.is_empty() => "an empty text".to_string(),
            Found::Text { text, .. } => {
                let short: String = text.chars().take(30).collect();
                let rest = if short.len() < text.len() { "…" } else { "" };
                format!("the text \"{short}{rest}\"")
            }
            Found::Number(_, written) => format!("the number {written}"),
            Found::List(_) => "a list".to_string(),
            Found::Table(_) => "a section".to_string(),
            Found::Date(_) => "a date or time".to_string(),
            Found::Truth => "true or false".to_string(),
        }
    }
}

/// Where `text` begins in how it is written, with its quotes, if nothing in it is written otherwise.
fn inner(written: &str, text: &str) -> Option<usize> {
    let mark = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|mark| written.starts_with(mark))?;
    let content = &written[mark.len()..];
    // A newline right after three marks is no part of the text.
    [0, 1, 2]
        .into_iter()
        .find(|skipped| {
            let rest = content.get(*skipped..).and_then(|content| content.strip_prefix(text));
            content.as_bytes()[..*skipped].iter().all(|byte| b"\r\n".contains(byte)) && rest == Some(mark)
        })
        .map(|skipped| mark.len() + skipped)
}
