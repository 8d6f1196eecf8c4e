//! The arguments that say which model, and how.

use std::path::{Path, PathBuf};

use clap::Args;
use motes::{Model, MotesError};
use motes_cli::integer;

use super::undeclared::undeclared;

/// The model, and what of it is changed.
#[derive(Args)]
pub(super) struct ModelArgs {
    /// The model file
    pub(super) model: PathBuf,
    /// Give a parameter of the model another value
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = parameter)]
    pub(super) set: Vec<(String, f64)>,
    /// The seed that every random number comes from
    #[arg(long, default_value = "1", allow_negative_numbers = true, value_parser = integer(0..=u64::MAX))]
    pub(super) seed: u64,
    /// Threads; as many as there are cores if absent
    #[arg(long, value_name = "J", allow_negative_numbers = true, value_parser = integer(1..=1024_usize))]
    pub(super) threads: Option<usize>,
    /// Say nothing but errors
    #[arg(long, short)]
    pub(super) quiet: bool,
}

impl ModelArgs {
    pub(super) fn read(&self) -> Result<Model, MotesError> {
        self.read_beside(None)
    }

    /// The model that data are for.
    pub(super) fn read_beside(&self, data: Option<&Path>) -> Result<Model, MotesError> {
        Ok(Model::read(&self.model, &self.set).map_err(|error| undeclared(error, data))?)
    }
}

fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("it must be NAME=VALUE")?;
    let number: f64 =
        value.trim().parse().map_err(|_| format!("{value} is no number; it must be NAME=VALUE"))?;
    match number.is_finite() {
        true => Ok((name.trim().to_string(), number)),
        false => Err(format!("{value} is not finite")),
    }
}
