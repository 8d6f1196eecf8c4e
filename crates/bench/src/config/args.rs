//! Command-line arguments, with errors of one line.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Args, FromArgMatches};

use super::ConfigError;

/// `reproduce`: run an experiment, or what of it is missing, and write its tables and figure.
#[derive(Debug, Clone, Args)]
pub struct ReproduceArgs {
    /// The figure: a file name in the experiments folder without .toml, or `all`
    pub figure: String,
    /// How much to run: smoke (CI), quick (a first look), paper (the protocol to the letter)
    #[arg(long, default_value = "quick")]
    pub profile: String,
    /// Only these methods, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Only these panels, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub panels: Vec<String>,
    /// Repetitions, instead of the profile's number
    #[arg(long)]
    pub repetitions: Option<String>,
    /// Threads for units side by side, which share those that are left over; as many as there are cores if absent
    #[arg(long)]
    pub jobs: Option<String>,
    /// What computes the networks: native, flex or ndarray
    #[arg(long, default_value = "native")]
    pub backend: String,
    /// The seed that every random number of the run comes from
    #[arg(long, default_value = "1")]
    pub seed: String,
    /// Results go to OUT/FIGURE/PROFILE [default: runs]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Forget finished units of this selection and run them again
    #[arg(long)]
    pub fresh: bool,
    /// Keep each trained proposal in OUT/FIGURE/PROFILE/models; finished units without one are trained again
    #[arg(long)]
    pub save_models: bool,
    /// The folder with the experiment files [default: experiments]
    #[arg(long)]
    pub experiments: Option<PathBuf>,
}

impl ReproduceArgs {
    /// The folder with the experiment files.
    pub(super) fn experiments(&self) -> PathBuf {
        self.experiments.clone().unwrap_or_else(|| "experiments".into())
    }

    /// The folder that results go to.
    pub(super) fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| "runs".into())
    }
}

/// `verify`: hold the paper's claims against finished runs.
#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// The folder that holds FIGURE/PROFILE/units.csv; verdict.md is written there [default: experiments/reference]
    #[arg(long)]
    pub from: Option<PathBuf>,
    /// The folder with the experiment files [default: experiments]
    #[arg(long)]
    pub experiments: Option<PathBuf>,
}

impl VerifyArgs {
    /// The folder with the experiment files.
    pub fn experiments(&self) -> PathBuf {
        self.experiments.clone().unwrap_or_else(|| "experiments".into())
    }

    /// The folder with the results, which must be there.
    ///
    /// # Errors
    /// [`ConfigError::Option`] if it is not a folder.
    pub fn from(&self) -> Result<PathBuf, ConfigError> {
        let from = self.from.clone().unwrap_or_else(|| "experiments/reference".into());
        if from.is_dir() {
            return Ok(from);
        }
        Err(ConfigError::Option {
            option: "--from".into(),
            value: from.display().to_string(),
            expected: "there is no such folder; give one that holds FIGURE/PROFILE/units.csv".into(),
        })
    }
}

/// What is to be timed, and against whom.
#[derive(Debug, Clone, Args)]
pub struct BenchArgs {
    /// Run the same work in other libraries as well, in turns with ours; needs Python 3 and the network
    #[arg(long)]
    pub peers: bool,
    /// How many times each piece of work is timed
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub rounds: u64,
    /// Only work whose name contains this, as "filter bootstrap", "train rnn K=50" or "growth"
    #[arg(long, default_value = "")]
    pub only: String,
    /// A Python that has the other libraries; without it one is built from a pinned list
    #[arg(long)]
    pub python: Option<PathBuf>,
    /// The folder for speed.json and speed.md [default: runs/speed]
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// The folder with the scripts that run other libraries [default: crates/bench/peers]
    #[arg(long)]
    pub peer_scripts: Option<PathBuf>,
}

impl BenchArgs {
    /// The folder for results.
    pub fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| "runs/speed".into())
    }

    /// The folder with the scripts that run other libraries.
    pub fn peer_scripts(&self) -> PathBuf {
        self.peer_scripts.clone().unwrap_or_else(|| "crates/bench/peers".into())
    }
}

/// The outcome of parsing.
#[derive(Debug)]
pub enum Parsed<T> {
    /// Arguments to act on.
    Args(T),
    /// Help that was asked for.
    Help(String),
}

/// Parses `arguments` (the program's name first) with a command made of `T`'s arguments.
///
/// # Errors
/// [`ConfigError::Usage`] in one line.
pub fn parse<T: FromArgMatches>(
    command: clap::Command,
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<Parsed<T>, ConfigError> {
    let name = command.get_bin_name().unwrap_or(command.get_name()).to_string();
    let usage = |error: &clap::Error| {
        let text = error.to_string();
        let said: Vec<&str> =
            text.lines().take_while(|line| !line.starts_with("Usage")).map(str::trim).collect();
        let said = said.join(" ");
        let said = said.trim_start_matches("error: ").trim();
        ConfigError::Usage(format!("{said}; see {name} --help"))
    };
    match command.try_get_matches_from(arguments) {
        Ok(matches) => T::from_arg_matches(&matches).map(Parsed::Args).map_err(|error| usage(&error)),
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(Parsed::Help(error.to_string())),
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                Err(ConfigError::Usage(format!("no command is given; see {name} --help")))
            }
            _ => Err(usage(&error)),
        },
    }
}
