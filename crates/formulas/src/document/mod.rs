//! A model file as TOML: sections, keys and values, each with its place.

mod syntax_error;
mod value;
mod vector_keys;

use toml::Spanned;
use toml::de::DeTable;

use crate::error::Fault;
use vector_keys::QuotedText;

pub(crate) use value::{Entry, Found, Table, Value};

/// Reads the text of a file. Places are bytes of this text.
pub(crate) fn read(text: &str) -> Result<Table, Fault> {
    let quoted = QuotedText::of(text);
    let parsed = DeTable::parse(quoted.text()).map_err(|error| {
        let reason = error.message().lines().collect::<Vec<_>>().join(", ");
        syntax_error::explain(text, error.span().map(|span| quoted.original(span.start)), reason)
    })?;
    Ok(table(parsed.get_ref(), &quoted))
}

/// The entries of a table. Nesting is as deep as the parser of TOML lets it be.
fn table(parsed: &DeTable<'_>, quoted: &QuotedText<'_>) -> Table {
    let mut entries: Vec<(&Spanned<_>, &Spanned<_>)> = parsed.iter().collect();
    // The map is in the order of the alphabet.
    entries.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<_>)| Entry {
        key: key.get_ref().to_string(),
        key_at: quoted.original(key.span().start),
        value: Value::of(value, quoted, &|inner| table(inner, quoted)),
    };
    entries.into_iter().map(entry).collect()
}
