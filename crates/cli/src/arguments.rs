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
    let is_said = |line: &&str| !line.starts_with("Usage") && !line.starts_with("For more information");
    let said: Vec<&str> = text.lines().take_while(is_said).map(str::trim).collect();
    let said = said.join(" ");
    UsageError::Other(format!("{}; see {name} --help", said.trim_start_matches("error: ").trim()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{integer, one_of};
    use clap::Parser;

    #[derive(Debug, Parser)]
    #[command(name = "program")]
    struct Arguments {
        #[arg(long, value_parser = integer(1..=9_u32))]
        count: Option<u32>,
        #[arg(long, value_parser = colour)]
        colour: Option<String>,
    }

    fn colour(name: &str) -> Result<String, String> {
        let known = ["red", "green"];
        if known.contains(&name) { Ok(name.into()) } else { Err(one_of(name, known)) }
    }

    fn parsed(arguments: &[&str]) -> Result<Parsed<Arguments>, String> {
        let all = std::iter::once("program").chain(arguments.iter().copied());
        parse(all.map(OsString::from)).map_err(|error| error.to_string())
    }

    #[test]
    fn errors_are_one_line_that_says_what_would_be_right() {
        for (arguments, line) in [
            (["--count", "10"], "--count 10: it must be an integer from 1 to 9"),
            (["--count", "1.5"], "--count 1.5: it must be an integer from 1 to 9"),
            (["--count", "-1"], "--count -1: it must be an integer from 1 to 9"),
            (["--colour", "gren"], "--colour gren: did you mean green? there are red, green"),
            (["--colour", "violet"], "--colour violet: there are red, green"),
            (
                ["--colur", "red"],
                "unexpected argument '--colur' found  tip: a similar argument exists: '--colour'; see program --help",
            ),
        ] {
            let [option, value] = arguments;
            // With an equals sign, a value may begin like an option.
            let given = if value.starts_with('-') {
                vec![format!("{option}={value}")]
            } else {
                arguments.map(String::from).into()
            };
            let given: Vec<&str> = given.iter().map(String::as_str).collect();
            assert_eq!(parsed(&given).unwrap_err(), line);
        }
    }

    #[test]
    fn an_option_without_its_value_points_to_the_help_once() {
        let said = parsed(&["--count"]).unwrap_err();
        assert_eq!(
            said,
            "a value is required for '--count <COUNT>' but none was supplied; see program --help"
        );
    }

    #[test]
    fn good_arguments_and_help_are_no_errors() {
        let Ok(Parsed::Args(arguments)) = parsed(&["--count", "9", "--colour", "red"]) else {
            panic!("refused")
        };
        assert_eq!((arguments.count, arguments.colour.as_deref()), (Some(9), Some("red")));
        let Ok(Parsed::Help(text)) = parsed(&["--help"]) else { panic!("no help") };
        assert!(text.contains("--colour"), "{text}");
    }
}
