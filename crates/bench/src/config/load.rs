//! Reading experiment files, with errors that name file, line and key.

use std::path::Path;

use motes_cli::one_of;
use serde::de::DeserializeOwned;

use super::error::ConfigError;
use super::schema::Experiment;

/// The figures that have a file in `folder`, sorted.
pub(crate) fn figures(folder: &Path) -> Result<Vec<String>, ConfigError> {
    let unreadable = |error: std::io::Error| ConfigError::File {
        file: folder.display().to_string(),
        reason: format!("{error}; it must be a folder with experiment files"),
    };
    let mut figures = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|extension| extension == "toml")
            && let Some(name) = path.file_stem().and_then(|name| name.to_str())
        {
            figures.push(name.to_string());
        }
    }
    figures.sort();
    Ok(figures)
}

/// Reads and parses the file of an experiment.
pub(super) fn load(file: &Path) -> Result<Experiment, ConfigError> {
    read_toml(file)
}

/// Reads and parses one file.
pub(crate) fn read_toml<T: DeserializeOwned>(file: &Path) -> Result<T, ConfigError> {
    let fail = |reason| ConfigError::File { file: file.display().to_string(), reason };
    let text = std::fs::read_to_string(file).map_err(|error| fail(error.to_string()))?;
    toml::from_str(&text).map_err(|error| fail(explain(&text, &error)))
}

/// What the parser calls a value that a key takes, and what one who writes the file calls it.
const TYPES: [(&str, &str); 5] = [
    ("expected usize", "expected a whole number of at least 0"),
    ("expected u32", "expected a whole number of at least 0"),
    ("expected u64", "expected a whole number of at least 0"),
    ("expected f64", "expected a number"),
    ("expected a sequence", "expected a list"),
];

/// A parser's error in one line: where, which key, and for an unknown one the nearest known.
fn explain(text: &str, error: &toml::de::Error) -> String {
    let message = error.message().lines().collect::<Vec<_>>().join(" ");
    let message = TYPES.iter().fold(message, |message, (theirs, ours)| message.replace(theirs, ours));
    let place = error.span().map(|span| {
        let before = &text[..span.start.min(text.len())];
        let line = before.matches('\n').count() + 1;
        let content = text.lines().nth(line - 1).unwrap_or_default();
        let key = content.split_once('=').map(|(key, _)| key.trim()).filter(|key| !key.is_empty());
        match key {
            // What is missing is missing from a table, whose first line this is.
            Some(key) if !message.starts_with("missing field") => format!("line {line}, key `{key}`: "),
            _ => format!("line {line}: "),
        }
    });
    let message = match unknown_name(&message) {
        Some((found, known)) => {
            let names = one_of(&found, known.iter().map(String::as_str));
            format!("`{found}` is not known here; {names}")
        }
        None => message,
    };
    format!("{}{message}", place.unwrap_or_default())
}

/// From serde's "unknown field `a`, expected one of `b`, `c`": a, and b and c.
fn unknown_name(message: &str) -> Option<(String, Vec<String>)> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut names = message.split('`').skip(1).step_by(2).map(str::to_string);
    Some((names.next()?, names.collect()))
}
