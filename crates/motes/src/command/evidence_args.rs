//! The arguments of `motes evidence`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use motes::smc::Resampling;
use motes::{EvidenceOptions, Model, MotesError};
use motes_cli::integer;

use super::model_args::ModelArgs;
use super::numbers::{fraction, resampling};
use super::proposal_arg::ProposalArg;
use super::share::share;

/// A proposal, or that pilots choose one.
#[derive(Debug, Clone)]
enum Choice {
    Auto,
    Of(ProposalArg),
}

impl FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" { Ok(Choice::Auto) } else { text.parse().map(Choice::Of) }
    }
}

#[derive(Args)]
pub(super) struct EvidenceArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The data, a CSV file with a header; - is standard input
    pub(super) data: PathBuf,
    /// What particles are drawn from: bootstrap, linearised, optimal, look-ahead, exact, or a folder that learn wrote; auto takes exact where a model has exact answers, else what small filters of each on the data choose
    #[arg(long, value_name = "P", default_value = "auto")]
    proposal: Choice,
    /// The number of particles of each run
    #[arg(long, value_name = "K", allow_negative_numbers = true, default_value = "1000", value_parser = integer(1..=1_000_000_000_usize))]
    particles: usize,
    /// The number of independent runs; of one alone there is no standard error
    #[arg(long, value_name = "R", allow_negative_numbers = true, default_value = "4", value_parser = integer(1..=1_000_000_usize))]
    runs: usize,
    /// The share of particles that are drawn from the transition whatever the proposal is, from 0 to below 1; if absent 0.1 of a learned proposal, 0.1 of linearised, 0.1 of look-ahead where noise is drawn that is not normal, 0.03 of it where a measurement is skewed, else 0
    #[arg(long, value_name = "W", allow_negative_numbers = true, value_parser = share)]
    defensive: Option<f64>,
    /// Resample where the effective sample size is below this share of the particles, above 0 and at most 1; 1 is at each step
    #[arg(long, value_name = "F", allow_negative_numbers = true, default_value = "0.5", value_parser = fraction)]
    resample_below: f64,
    /// How ancestors are drawn: multinomial, systematic, stratified or residual
    #[arg(long, value_name = "SCHEME", default_value = "systematic", value_parser = resampling)]
    resampling: Resampling,
    /// Run no filter of each other proposal beside, to see whether it finds more
    #[arg(long)]
    no_check: bool,
    /// Write the table to a file, which is replaced when the table is whole; standard output if absent
    #[arg(long, short = 'o', value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Print one JSON object with the figures of the whole run
    #[arg(long)]
    pub(super) json: bool,
    /// Exit with status 1 if a warning fired
    #[arg(long)]
    pub(super) strict: bool,
}

impl EvidenceArgs {
    /// Whether nobody names a proposal.
    pub(super) fn chooses(&self) -> bool {
        matches!(self.proposal, Choice::Auto)
    }

    /// A learned proposal is read here, for `model`.
    pub(super) fn options(&self, model: &Model) -> Result<EvidenceOptions, MotesError> {
        let proposal = match &self.proposal {
            Choice::Auto => None,
            Choice::Of(proposal) => Some(proposal.of(model)?),
        };
        Ok(EvidenceOptions {
            proposal,
            particles: self.particles,
            runs: self.runs,
            defensive: self.defensive,
            resample_below: self.resample_below,
            resampling: self.resampling,
            check: !self.no_check,
            seed: self.model.seed,
        })
    }
}
