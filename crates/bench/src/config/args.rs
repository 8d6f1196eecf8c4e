//! The arguments of the commands that run experiments and judge them.

use std::path::PathBuf;

use clap::Args;
use motes_cli::{integer, one_of};
use motes_proposals::Backend;

use super::cluster::ClusterArgs;
use super::error::ConfigError;

/// As many repetitions as a run may have.
pub(super) const MOST_REPETITIONS: usize = 1_000_000;

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
    /// Only these values on the x axis, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub x: Vec<String>,
    /// Repetitions, instead of the profile's number
    #[arg(long, value_parser = integer(1..=MOST_REPETITIONS))]
    pub repetitions: Option<usize>,
    /// Threads for units side by side, which share those that are left over; as many as there are cores if absent
    #[arg(long, value_parser = integer(1..=1024_usize))]
    pub jobs: Option<usize>,
    /// What computes the networks: native, flex or ndarray on the host, wgpu or cuda on a graphics processor
    #[arg(long, default_value_t = Backend::Native, value_parser = backend)]
    pub backend: Backend,
    /// The seed that every random number of the run comes from
    #[arg(long, default_value_t = 1, value_parser = integer(0..=u64::MAX))]
    pub seed: u64,
    /// Results go to OUT/FIGURE/PROFILE
    #[arg(long, default_value = "runs")]
    pub out: PathBuf,
    /// Forget finished units of this selection and run them again
    #[arg(long)]
    pub fresh: bool,
    /// Keep each trained proposal in OUT/FIGURE/PROFILE/models; finished units without one are trained again
    #[arg(long)]
    pub save_models: bool,
    /// Check arguments and experiment files, say how many units they ask for, and run nothing
    #[arg(long)]
    pub dry_run: bool,
    /// The folder with the experiment files
    #[arg(long, default_value = "experiments")]
    pub experiments: PathBuf,
    /// Where units are run
    #[command(flatten)]
    pub cluster: ClusterArgs,
}

impl ReproduceArgs {
    /// What a figure is run with where nothing else is said.
    pub fn of(figure: &str) -> Self {
        ReproduceArgs {
            figure: figure.into(),
            profile: "quick".into(),
            methods: Vec::new(),
            panels: Vec::new(),
            x: Vec::new(),
            repetitions: None,
            jobs: None,
            backend: Backend::Native,
            seed: 1,
            out: "runs".into(),
            fresh: false,
            save_models: false,
            dry_run: false,
            experiments: "experiments".into(),
            cluster: ClusterArgs::default(),
        }
    }
}

fn backend(name: &str) -> Result<Backend, String> {
    let names = Backend::ALL.map(|backend| backend.to_string());
    let at = names.iter().position(|known| known == name);
    at.map(|at| Backend::ALL[at]).ok_or_else(|| one_of(name, names.iter().map(String::as_str)))
}

/// `verify`: hold the paper's claims against finished runs.
#[derive(Debug, Clone, Args)]
pub struct VerifyArgs {
    /// The folder that holds FIGURE/PROFILE/units.csv; verdict.md is written there
    #[arg(long, default_value = "experiments/reference")]
    pub from: PathBuf,
    /// The folder with the experiment files
    #[arg(long, default_value = "experiments")]
    pub experiments: PathBuf,
}

impl VerifyArgs {
    /// The folder with the results.
    ///
    /// # Errors
    /// [`ConfigError::Usage`] if it is not a folder.
    pub fn results(&self) -> Result<&PathBuf, ConfigError> {
        if self.from.is_dir() {
            return Ok(&self.from);
        }
        let expected = "there is no such folder; give one that holds FIGURE/PROFILE/units.csv";
        Err(ConfigError::option("--from", &self.from.display().to_string(), expected.into()))
    }
}
