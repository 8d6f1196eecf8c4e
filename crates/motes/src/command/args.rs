//! The arguments of each command.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use motes::output::Output;
use motes::smc::Resampling;
use motes::{FilterOptions, LearnOptions, LearnedProposal, Model, MotesError, Quantiles};
use motes_cli::integer;

use super::evidence_args::EvidenceArgs;
use super::fit_args::FitArgs;
use super::fitted_args::{At, FittedArgs};
use super::kind_args::KindArgs;
use super::model_args::ModelArgs;
use super::numbers::{fraction, resampling, seconds};
use super::objective_args::ObjectiveArgs;
use super::proposal_arg::ProposalArg;
use super::share::share;

/// Particle filters for state-space models: hidden states, evidence and warnings from a model file and a CSV file.
#[derive(Parser)]
#[command(
    name = "motes",
    version,
    after_help = "Exit status: 0; 1 where a warning fired and --strict was given; 2 for bad input; 3 where input or output failed."
)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Estimate the hidden states of data, time by time, with the evidence of each measurement
    #[command(
        after_help = "Examples:\n  motes filter nile.toml nile.csv -o states.csv --report nile.html\n  motes filter growth.toml data.csv --proposal linearised --particles 500 --set q=2\n  tail -f log.csv | motes filter walk.toml -"
    )]
    Filter(FilterArgs),
    /// Say what a model is, whether it can be simulated and differentiated, and whether data fit it
    #[command(after_help = "Example:\n  motes check influenza.toml influenza.csv")]
    Check(CheckArgs),
    /// Hold proposals against each other, on simulated sequences or on data, with the same particles and at equal time
    #[command(after_help = "Example:\n  motes compare tracking.toml --particles 300 --sequences 40")]
    Compare(CompareArgs),
    /// Estimate the hidden states of data given all of them, by trajectories drawn backwards
    #[command(after_help = "Example:\n  motes smooth nile.toml nile.csv --paths 500 -o smoothed.csv")]
    Smooth(SmoothArgs),
    /// Estimate the log-evidence of recorded data with its standard error, by particles that look ahead where that is worth it
    #[command(
        after_help = "Examples:\n  motes evidence whiskers.toml data.csv\n  motes evidence growth.toml data.csv --proposal linearised --particles 5000 --runs 8 --json"
    )]
    Evidence(EvidenceArgs),
    /// Draw series of states and measurements from a model
    #[command(after_help = "Example:\n  motes simulate growth.toml --steps 100 --series 20 -o data.csv")]
    Simulate(SimulateArgs),
    /// Find the parameters of a model from data: draws from the posterior of all that have a prior
    #[command(after_help = "Example:\n  motes fit ricker.toml ricker.csv -o ricker-fit")]
    Fit(FitArgs),
    /// Learn a proposal for a model from sequences that it draws for itself, and hold it against designed ones
    #[command(
        after_help = "Examples:\n  motes learn growth.toml -o growth-proposal\n  motes filter growth.toml data.csv --proposal growth-proposal\n  motes learn returns.toml returns.csv -o tuned"
    )]
    Learn(LearnArgs),
    /// Print what a shell needs to complete this command
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page
    Man {
        /// The command that it is about; all of them in short if absent
        about: Option<String>,
    },
}

/// How to filter.
#[derive(Args)]
pub(super) struct FilterSettingsArgs {
    /// What particles are drawn from: bootstrap, linearised, optimal, or a folder that learn wrote; look-ahead to smooth; exact takes the Kalman filter or the forward algorithm in their place, for models that are linear with Gaussian noise or of few discrete states
    #[arg(long, value_name = "P", default_value = "bootstrap")]
    pub(super) proposal: ProposalArg,
    /// The number of particles
    #[arg(long, value_name = "K", allow_negative_numbers = true, default_value = "1000", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) particles: usize,
    /// The share of particles that are drawn from the transition whatever the proposal is, from 0 to below 1; if absent 0.1 of a learned proposal, 0.1 of linearised where it draws noise that is not normal, else 0
    #[arg(long, value_name = "W", allow_negative_numbers = true, value_parser = share)]
    pub(super) defensive: Option<f64>,
    /// Resample where the effective sample size is below this share of the particles, above 0 and at most 1; 1 is at each step
    #[arg(long, value_name = "F", allow_negative_numbers = true, default_value = "0.5", value_parser = fraction)]
    pub(super) resample_below: f64,
    /// How ancestors are drawn: multinomial, systematic, stratified or residual
    #[arg(long, value_name = "SCHEME", default_value = "systematic", value_parser = resampling)]
    pub(super) resampling: Resampling,
    /// The probabilities of the quantiles that are given, above 0 and below 1, each above the one before; columns are called by their decimals, as in q025
    #[arg(long, value_name = "Q,Q", allow_negative_numbers = true, default_value = "0.05,0.5,0.95")]
    pub(super) quantiles: Quantiles,
    /// Run small filters beside it for the standard error of the log-evidence, and a bootstrap filter beside any other proposal, and warn where estimates cannot be trusted; this is the default, and changes no other result
    #[arg(long, overrides_with = "no_check")]
    check: bool,
    /// Do without them, and without a standard error, which is faster
    #[arg(long, overrides_with = "check")]
    no_check: bool,
}

impl FilterSettingsArgs {
    pub(super) fn options(
        &self,
        model: &Model,
        seed: u64,
        forecast: usize,
    ) -> Result<FilterOptions, MotesError> {
        Ok(FilterOptions {
            proposal: self.proposal.of(model)?,
            particles: self.particles,
            defensive: self.defensive,
            resample_below: self.resample_below,
            resampling: self.resampling,
            seed,
            quantiles: self.quantiles.clone(),
            forecast,
            check: !self.no_check,
            ..FilterOptions::default()
        })
    }
}

/// Where results go.
#[derive(Args)]
pub(super) struct OutputArgs {
    /// Write the table to a file, which is replaced when the table is whole; standard output if absent
    #[arg(long, short = 'o', value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Print one JSON object with the figures of the whole run
    #[arg(long)]
    pub(super) json: bool,
    /// Write a report with figures, an HTML file that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
    /// Exit with status 1 if a warning fired
    #[arg(long)]
    pub(super) strict: bool,
}

impl OutputArgs {
    /// Where the table goes, if anywhere.
    pub(super) fn table(&self) -> Option<Output> {
        match (&self.output, self.json) {
            (Some(path), _) => Some(Output::File(path.clone())),
            (None, false) => Some(Output::Standard),
            (None, true) => None,
        }
    }

    /// Refuses places that cannot be written to, before the work is done.
    pub(super) fn check(&self) -> Result<(), MotesError> {
        let report = self.report.clone().map(Output::File);
        for output in self.table().into_iter().chain(report) {
            output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
        }
        Ok(())
    }
}

#[derive(Args)]
pub(super) struct FilterArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The data, a CSV file with a header; - reads standard input and answers line by line
    pub(super) data: PathBuf,
    #[command(flatten)]
    pub(super) fitted: FittedArgs,
    #[command(flatten)]
    pub(super) settings: FilterSettingsArgs,
    /// Predict each measurement from those before it: columns with its mean, its standard deviation, and the place of what was measured (pit), which is uniform between 0 and 1 where the model is right
    #[arg(long)]
    pub(super) predictive: bool,
    /// Predict the states and measurements of so many times after the last measurement
    #[arg(long, value_name = "H", allow_negative_numbers = true, default_value = "0", value_parser = integer(0..=1_000_000_usize))]
    pub(super) forecast: usize,
    /// Times and inputs of the rows after the last one, which are predicted, or of which --forecast takes the first ones: a CSV file with the columns that the model's [time] and [inputs] name
    #[arg(long, value_name = "FILE")]
    pub(super) inputs: Option<PathBuf>,
    #[command(flatten)]
    pub(super) output: OutputArgs,
}

#[derive(Args)]
pub(super) struct SmoothArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The data, a CSV file with a header; - is standard input
    pub(super) data: PathBuf,
    #[command(flatten)]
    pub(super) fitted: FittedArgs,
    #[command(flatten)]
    pub(super) settings: FilterSettingsArgs,
    /// The number of trajectories
    #[arg(long, value_name = "B", allow_negative_numbers = true, default_value = "200", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) paths: usize,
    #[command(flatten)]
    pub(super) output: OutputArgs,
}

#[derive(Args)]
pub(super) struct LearnArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Recorded data to learn from in addition, or alone by --objective wake and fivo, a CSV file with a header; - is standard input
    pub(super) data: Option<PathBuf>,
    /// The folder that the proposal is written into; a proposal that is there is replaced
    #[arg(long, short = 'o', value_name = "FOLDER")]
    pub(super) output: PathBuf,
    /// Gradient steps
    #[arg(long, value_name = "U", allow_negative_numbers = true, default_value = "5000", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) updates: usize,
    /// End learning after so many seconds, whatever its updates; the result then depends on the machine
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    pub(super) budget: Option<f64>,
    /// The number of times in each simulated sequence
    #[arg(long, value_name = "T", allow_negative_numbers = true, default_value = "100", value_parser = integer(2..=1_000_000_usize))]
    pub(super) steps: usize,
    #[command(flatten)]
    pub(super) objective: ObjectiveArgs,
    #[command(flatten)]
    pub(super) kind: KindArgs,
    /// The number of particles of the card
    #[arg(long, value_name = "K", allow_negative_numbers = true, default_value = "100", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) particles: usize,
    /// The number of sequences that it is judged on; 0 writes no card
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value = "20", value_parser = integer(0..=1_000_000_usize))]
    pub(super) sequences: usize,
    /// Print one JSON object with all figures
    #[arg(long)]
    pub(super) json: bool,
    /// Write the card as a page with a figure, an HTML file that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
}

impl LearnArgs {
    /// The proposal to learn further is read here, for `model`.
    pub(super) fn options(&self, model: &Model) -> Result<LearnOptions, MotesError> {
        let ObjectiveArgs { objective, from, dropout, penalty } = &self.objective;
        let start = from.as_ref().map(|folder| LearnedProposal::load_to_tune(folder, model)).transpose()?;
        Ok(LearnOptions {
            objective: *objective,
            start,
            dropout: *dropout,
            weight_penalty: *penalty,
            updates: self.updates,
            seconds: self.budget,
            steps: self.steps,
            base: self.kind.base,
            head: self.kind.head,
            sees: self.kind.network,
            widths: self.kind.widths.clone(),
            seed: self.model.seed,
        })
    }
}

#[derive(Args)]
pub(super) struct SimulateArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    #[command(flatten)]
    pub(super) fitted: FittedArgs,
    /// The number of times in each series
    #[arg(long, value_name = "T", allow_negative_numbers = true, required_unless_present = "inputs", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) steps: Option<usize>,
    /// Times and inputs of the rows instead: a CSV file with the columns that the model's [time] and [inputs] name, those of data, too
    #[arg(long, value_name = "FILE", conflicts_with = "steps")]
    pub(super) inputs: Option<PathBuf>,
    /// The number of series
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value = "1", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) series: usize,
    /// Draw parameters that have a prior anew for each series; each is a column
    #[arg(long, conflicts_with = "parameters")]
    pub(super) prior: bool,
    /// Write the table to a file, which is replaced when the table is whole; standard output if absent
    #[arg(long, short = 'o', value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Data that the model is for, a CSV file with a header; - is standard input
    pub(super) data: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct CompareArgs {
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Data whose series are filtered, instead of simulated sequences; - is standard input. With another argument behind it: a second model
    pub(super) data: Option<PathBuf>,
    /// The data that both models were fitted to, where there are two; the table then has their marginal likelihoods and how well each expects the next measurement
    pub(super) data_of_both: Option<PathBuf>,
    /// Take the parameters that motes fit found, from its folder; for two models one folder each, in their order
    #[arg(long, value_name = "FOLDER")]
    pub(super) parameters: Vec<PathBuf>,
    /// Which of them one model is compared at: mean takes the posterior's mean, maximum the maximum of the likelihood; if absent the mean after a posterior fit, the maximum after a maximum fit
    #[arg(long, value_name = "WHICH", requires = "parameters")]
    pub(super) at: Option<At>,
    /// Proposals, separated by commas: bootstrap, linearised, optimal, folders that learn wrote; all that are designed and the model has if absent
    #[arg(long, value_name = "P,P", value_delimiter = ',')]
    pub(super) proposals: Vec<ProposalArg>,
    /// The number of particles of the card
    #[arg(long, value_name = "K", allow_negative_numbers = true, default_value = "100", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) particles: usize,
    /// The numbers of particles at which error is held against time
    #[arg(long, value_name = "K,K", allow_negative_numbers = true, value_delimiter = ',', default_value = "10,30,100,300,1000,3000,10000", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) sweep: Vec<usize>,
    /// The number of simulated sequences
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value = "20", value_parser = integer(1..=1_000_000_usize))]
    pub(super) sequences: usize,
    /// The number of times in each simulated sequence
    #[arg(long, value_name = "T", allow_negative_numbers = true, default_value = "100", value_parser = integer(1..=1_000_000_000_usize))]
    pub(super) steps: usize,
    /// Times and inputs of simulated sequences instead, a CSV file as that of simulate
    #[arg(long, value_name = "FILE", conflicts_with_all = ["steps", "data"])]
    pub(super) inputs: Option<PathBuf>,
    /// The share of particles that are drawn from the transition whatever the proposal is; if absent 0.1 of learned proposals, 0.1 of linearised where it draws noise that is not normal, else 0
    #[arg(long, value_name = "W", allow_negative_numbers = true, value_parser = share)]
    pub(super) defensive: Option<f64>,
    /// Resample where the effective sample size is below this share of the particles; 1 is at each step
    #[arg(long, value_name = "F", allow_negative_numbers = true, default_value = "0.5", value_parser = fraction)]
    pub(super) resample_below: f64,
    /// How ancestors are drawn: multinomial, systematic, stratified or residual
    #[arg(long, value_name = "SCHEME", default_value = "systematic", value_parser = resampling)]
    pub(super) resampling: Resampling,
    /// Write the card to a file, which is replaced when the card is whole; standard output if absent
    #[arg(long, short = 'o', value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Print one JSON object with all figures
    #[arg(long)]
    pub(super) json: bool,
    /// Write the card as a page with a figure, an HTML file that needs nothing else
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
}
