//! Arguments that say where units are run.

use clap::{Args, ValueEnum};
use motes_cli::integer;

use super::error::ConfigError;
use super::time_limit::TimeLimit;

/// As many tasks as an array may have.
const MOST_TASKS: usize = 1_000_000;

/// What runs the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Engine {
    /// This process.
    #[default]
    Local,
    /// Tasks of a Slurm job array.
    Slurm,
}

/// Where units are run, and how a cluster is asked for it.
#[derive(Debug, Clone, Default, Args)]
pub struct ClusterArgs {
    /// What runs the units: local, this process; slurm, tasks of a job array on a folder that all nodes share
    #[arg(long, value_enum, default_value_t)]
    pub engine: Engine,
    /// With --engine slurm: tasks of the array, which share the units; one for each unit, but at most 100, if absent
    #[arg(long, value_parser = integer(1..=MOST_TASKS))]
    pub tasks: Option<usize>,
    /// With --engine slurm: the partition
    #[arg(long)]
    pub partition: Option<String>,
    /// With --engine slurm: the time limit of a task, as Slurm has it: minutes, hours:minutes:seconds or days-hours
    #[arg(long)]
    pub time: Option<TimeLimit>,
    /// With --engine slurm: more options for sbatch, in one word: "--account=x --mem-per-cpu=4G"
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true)]
    pub sbatch: Option<String>,
    /// Say how many units are done, failed and left, and what the tasks of job arrays are doing; run nothing
    #[arg(long)]
    pub status: bool,
    /// Say how long the units would take on so many cores, by trials on this machine and the spread of measured times; run nothing
    #[arg(long, value_name = "CORES", value_delimiter = ',', value_parser = integer(1..=MOST_TASKS))]
    pub project: Vec<usize>,
}

impl ClusterArgs {
    /// Whether something is to be said of the units and none is to be run.
    pub fn runs_nothing(&self) -> bool {
        self.status || !self.project.is_empty()
    }

    /// Threads of a process where nothing is said: all that there are, or one for a task, of which there are many.
    pub fn threads(&self) -> usize {
        match self.engine == Engine::Slurm || !self.project.is_empty() {
            true => 1,
            false => std::thread::available_parallelism().map_or(1, usize::from),
        }
    }

    /// Refuses what would not be looked at, and what would spoil a script.
    ///
    /// # Errors
    /// [`ConfigError::Usage`] naming the option.
    pub fn check(&self, fresh: bool) -> Result<(), ConfigError> {
        if fresh && self.engine == Engine::Slurm {
            let expected =
                "finished units would be gone before Slurm took the job; give another --out".into();
            return Err(ConfigError::option("--fresh", "with --engine slurm", expected));
        }
        let given = [
            ("--tasks", self.tasks.map(|tasks| tasks.to_string())),
            ("--partition", self.partition.clone()),
            ("--time", self.time.as_ref().map(ToString::to_string)),
            ("--sbatch", self.sbatch.clone()),
        ];
        for (option, value) in given.into_iter().filter_map(|(option, value)| Some((option, value?))) {
            if self.engine == Engine::Local {
                return Err(ConfigError::option(option, &value, "it is for --engine slurm".into()));
            }
            let is_a_line = !value.trim().is_empty() && !value.contains(char::is_control);
            if !is_a_line || (option == "--partition" && value.contains(char::is_whitespace)) {
                let expected = "it must be one word, or options in one line for --sbatch";
                return Err(ConfigError::option(option, &value.escape_debug().to_string(), expected.into()));
            }
        }
        Ok(())
    }
}
