//! Arguments parsed by clap, with errors of one line.

use std::error::Error as _;
use std::ffi::OsString;

use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory, FromArgMatches};
use thiserror::Error;

/// Arguments that say nothing a program can do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UsageError {
    /// A value that its option cannot have.
    #[error("{option} {value}: {expected}")]
    Value {
        /// The option's name.
        option: String,
        /// The value found.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// Anything else, as clap puts it.
    #[error("{0}")]
    Other(String),
}

/// The outcome of parsing.
#[derive(Debug)]
pub enum Parsed<T> {
    /// Arguments to act on.
    Args(T),
    /// Help that was asked for.
    Help(String),
}

/// Parses `arguments`, the program's name first.
///
/// # Errors
/// [`UsageError`] in one line.
pub fn parse<T: CommandFactory + FromArgMatches>(
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<Parsed<T>, UsageError> {
    let command = T::command();
    let name = command.get_bin_name().unwrap_or(command.get_name()).to_string();
    let parsed = command.try_get_matches_from(arguments).and_then(|matches| T::from_arg_matches(&matches));
    match parsed {
        Ok(arguments) => Ok(Parsed::Args(arguments)),
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(Parsed::Help(error.to_string())),
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                Err(UsageError::Other(format!("no command is given; see {name} --help")))
            }
            _ => Err(value_error(&error).unwrap_or_else(|| other_error(&error, &name))),
        },
    }
}

/// The error of a value parser of ours.
fn value_error(error: &clap::Error) -> Option<UsageError> {
    let expected = error.source()?.to_string();
    let text = |kind| error.get(kind).map(ToString::to_string);
    let (argument, value) = (text(ContextKind::InvalidArg)?, text(ContextKind::InvalidValue)?);
    let option = argument.split(' ').next().unwrap_or_default().to_string();
    Some(UsageError::Value { option, value, expected })
}

fn other_error(error: &clap::Error, name: &str) -> UsageError {
    let text = error.to_string();
    let said: Vec<&str> = text.lines().take_while(|line| !line.starts_with("Usage")).map(str::trim).collect();
    let said = said.join(" ");
    UsageError::Other(format!("{}; see {name} --help", said.trim_start_matches("error: ").trim()))
}
