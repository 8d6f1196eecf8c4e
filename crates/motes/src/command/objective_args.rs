//! The arguments that say what is maximised, and from where on.

use std::path::PathBuf;

use clap::Args;
use motes::train::LearnObjective;
use motes_cli::one_of;

use super::share::share;

#[derive(Args)]
pub(super) struct ObjectiveArgs {
    /// What is maximised: inclusive, from what the model draws for itself; wake, from a filter on DATA; fivo, the log-evidence of a filter on DATA
    #[arg(long, value_name = "O", default_value = "inclusive", value_parser = objective)]
    pub(super) objective: LearnObjective,
    /// A folder that learn wrote, to learn further: for the same model, or for one with other parameters
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["base", "head", "network", "widths"])]
    pub(super) from: Option<PathBuf>,
    /// The probability that an update leaves out a hidden unit
    #[arg(long, value_name = "P", allow_negative_numbers = true, default_value = "0", value_parser = share)]
    pub(super) dropout: f64,
    /// L of a penalty L/2 times the sum of all squared weights
    #[arg(long, value_name = "L", allow_negative_numbers = true, default_value = "0", value_parser = penalty)]
    pub(super) penalty: f64,
}

fn objective(text: &str) -> Result<LearnObjective, String> {
    let names = LearnObjective::ALL.map(|objective| objective.to_string());
    let at = names.iter().position(|name| name == text);
    at.map(|at| LearnObjective::ALL[at]).ok_or_else(|| one_of(text, names.iter().map(String::as_str)))
}

fn penalty(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(penalty) if (0.0..f64::INFINITY).contains(&penalty) => Ok(penalty),
        _ => Err("it must be a number of at least 0".into()),
    }
}
