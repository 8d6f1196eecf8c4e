//! The arguments of `motes fit`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use motes::{FitOptions, Model, MotesError};
use motes_cli::integer;

use super::model_args::ModelArgs;
use super::numbers::seconds;
use super::proposal_arg::ProposalArg;

/// What a fit finds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Method {
    /// Draws of the posterior
    Posterior,
    /// The maximum of the likelihood, with intervals by its profile
    Maximum,
}

#[derive(Args)]
pub(super) struct FitArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The data, a CSV file with a header; - is standard input
    pub(super) data: PathBuf,
    /// The folder that the fit is written into; a fit that was stopped goes on from there
    #[arg(long, short = 'o', value_name = "FOLDER")]
    pub(super) output: PathBuf,
    /// What is found: draws of the posterior, or the maximum of the likelihood with intervals by its profile
    #[arg(long, value_name = "METHOD", default_value = "posterior")]
    pub(super) method: Method,
    /// The estimator of the likelihood: bootstrap, linearised, optimal, look-ahead, exact, or a folder that learn wrote; if absent exact where there is one, else that which costs the least
    #[arg(long, value_name = "P")]
    pub(super) proposal: Option<ProposalArg>,
    /// The number of particles; found in the warm-up if absent
    #[arg(long, value_name = "K", allow_negative_numbers = true, value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) particles: Option<usize>,
    /// The number of chains, or of searches for the maximum
    #[arg(long, value_name = "C", allow_negative_numbers = true, default_value = "4", value_parser = integer(1..=1000_usize))]
    pub(super) chains: usize,
    /// The draws of each chain; if absent they go on until R̂ is below 1.01 and each parameter has an effective sample size of 400, 20,000 at most
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = integer(4..=1_000_000_000_usize))]
    pub(super) draws: Option<usize>,
    /// By --method maximum, the passes of iterated filtering through the data; if absent 100 for 8 parameters or more, and searches on quadratics for fewer
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = integer(1..=1_000_000_usize))]
    pub(super) passes: Option<usize>,
    /// By --method maximum, a parameter whose profile and interval are sought, and may be given several times; if absent all, or none by iterated filtering
    #[arg(long, value_name = "NAME")]
    profile: Vec<String>,
    /// End with the draws, or the searches, that there are after so many seconds; they then depend on the machine
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub(super) budget: Option<f64>,
    /// Predict the states and measurements of so many times after the last measurement, in states.csv of the folder and in the report
    #[arg(long, value_name = "H", allow_negative_numbers = true, default_value = "0", value_parser = integer(0..=1_000_000_usize))]
    pub(super) forecast: usize,
    /// Times and inputs of the rows after the last one, which are predicted, or of which --forecast takes the first ones: a CSV file with the columns that the model's [time] and [inputs] name
    #[arg(long, value_name = "FILE")]
    pub(super) inputs: Option<PathBuf>,
    /// Print one JSON object with all figures
    #[arg(long)]
    pub(super) json: bool,
    /// Write a report with figures of the posterior, an HTML file that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
    /// Exit with status 1 if a warning fired
    #[arg(long)]
    pub(super) strict: bool,
}

impl FitArgs {
    pub(super) fn options(&self, model: &Model) -> Result<FitOptions, MotesError> {
        Ok(FitOptions {
            proposal: self.proposal.as_ref().map(|proposal| proposal.of(model)).transpose()?,
            particles: self.particles,
            chains: self.chains,
            draws: self.draws,
            profiles: self.profile.clone(),
            passes: self.passes,
            seconds: self.budget,
            seed: self.model.seed,
        })
    }
}
