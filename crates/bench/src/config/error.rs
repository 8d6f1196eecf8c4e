//! One line that says what is wrong, where, and what would be right.

use std::path::PathBuf;

use thiserror::Error;

/// Input that cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ConfigError {
    /// An argument of the command line.
    #[error("{0}")]
    Usage(String),
    /// A value given on the command line.
    #[error("{option} {value}: {expected}")]
    Option {
        /// The option's name.
        option: String,
        /// The value found.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// An experiment file that cannot be read or parsed.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A key of an experiment file.
    #[error("{file}: key `{key}` is {value}; {expected}")]
    Key {
        /// The file.
        file: String,
        /// The key with its tables.
        key: String,
        /// The value found.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// The output folder cannot be written.
    #[error("--out {folder}: {reason}; give a folder that can be written", folder = folder.display())]
    Output {
        /// The folder.
        folder: PathBuf,
        /// Why not.
        reason: String,
    },
}

impl ConfigError {
    /// 3 where input or output failed, 2 for every other bad input.
    pub fn exit_status(&self) -> u8 {
        match self {
            ConfigError::Output { .. } => 3,
            _ => 2,
        }
    }
}

/// "did you mean `a`? there are a, b and c": the names to choose from, the nearest one first.
pub fn one_of<'a>(found: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.into_iter().collect();
    let nearest = names.iter().min_by_key(|name| strsim::damerau_levenshtein(found, name));
    let hint = nearest
        .filter(|name| strsim::damerau_levenshtein(found, name) <= found.len().max(3) / 3 + 1)
        .map(|name| format!("did you mean {name}? "))
        .unwrap_or_default();
    format!("{hint}there are {}", names.join(", "))
}
