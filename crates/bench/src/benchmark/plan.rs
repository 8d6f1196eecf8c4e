//! Arguments and a benchmark's file brought together.

use std::fmt;
use std::path::PathBuf;

use motes::Model;
use motes_cli::one_of;

use super::check::check;
use super::file::{Benchmark, BenchmarkProfile};
use crate::config::{ClusterArgs, ConfigError, Engine, ReproduceArgs, figures, read_toml};

/// What the names of all benchmarks begin with; by itself, all of them.
const PREFIX: &str = "learned";

/// One benchmark in one profile.
#[derive(Debug, Clone)]
pub struct BenchmarkPlan {
    /// Its name, `learned-…`.
    pub name: String,
    /// The profile's name.
    pub profile_name: String,
    /// The whole file.
    pub benchmark: Benchmark,
    /// The chosen profile.
    pub profile: BenchmarkProfile,
    /// The folder of the file, from which paths in it lead.
    pub home: PathBuf,
    /// Where results go.
    pub folder: PathBuf,
    /// Threads of references and of learning.
    pub jobs: usize,
    /// The seed of the run.
    pub seed: u64,
    /// Whether a finished benchmark is to be run again.
    pub fresh: bool,
}

/// Whether a name is that of a benchmark, or of all of them.
pub fn is_benchmark(name: &str) -> bool {
    name == PREFIX || name.starts_with("learned-")
}

impl fmt::Display for BenchmarkPlan {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Benchmark { designed, learned, .. } = &self.benchmark;
        let names = designed.iter().chain(learned.iter().map(|method| &method.name));
        let names: Vec<&str> = names.map(String::as_str).collect();
        let BenchmarkProfile { sequences, times, particles, equal_time, .. } = &self.profile;
        write!(
            formatter,
            "{} {}: {}, {sequences} sequences of {times} times, K = {particles}, error against time at K = {equal_time:?}, seed {}",
            self.name,
            self.profile_name,
            names.join(" "),
            self.seed
        )
    }
}

impl BenchmarkPlan {
    /// The model, with some parameters at other values.
    pub(super) fn model(
        &self,
        set: &std::collections::BTreeMap<String, f64>,
    ) -> Result<Model, motes::MotesError> {
        let mut values = self.benchmark.set.clone();
        values.extend(set.iter().map(|(name, value)| (name.clone(), *value)));
        let overrides: Vec<(String, f64)> = values.into_iter().collect();
        Ok(Model::read(&self.home.join(&self.benchmark.model), &overrides)?)
    }
}

/// The benchmarks that the arguments ask for. Reads their files and writes nothing.
///
/// # Errors
/// [`ConfigError`] for anything that could not be run.
pub fn benchmark_plans(args: &ReproduceArgs) -> Result<Vec<BenchmarkPlan>, ConfigError> {
    for (option, given) in [
        ("--methods", args.methods.join(",")),
        ("--panels", args.panels.join(",")),
        ("--x", args.x.join(",")),
        ("--repetitions", args.repetitions.map_or(String::new(), |count| count.to_string())),
    ] {
        if !given.is_empty() {
            let expected = "a benchmark has none to choose from; its file says what is compared".into();
            return Err(ConfigError::option(option, &given, expected));
        }
    }
    args.cluster.check(args.fresh)?;
    if args.cluster.engine == Engine::Slurm || args.cluster.runs_nothing() {
        let expected = "a benchmark times its methods side by side: it is run on one machine".into();
        let (option, value) = match args.cluster {
            ClusterArgs { status: true, .. } => ("--status", args.figure.as_str()),
            ClusterArgs { engine: Engine::Slurm, .. } => ("--engine", "slurm"),
            _ => ("--project", args.figure.as_str()),
        };
        return Err(ConfigError::option(option, value, expected));
    }
    let home = args.experiments.join(PREFIX);
    let known = figures(&home)?;
    let asked = args.figure.strip_prefix("learned-");
    let chosen: Vec<&String> = known.iter().filter(|name| asked.is_none_or(|asked| asked == *name)).collect();
    if chosen.is_empty() {
        let names: Vec<String> = known.iter().map(|name| format!("{PREFIX}-{name}")).collect();
        let names = names.iter().map(String::as_str).chain([PREFIX]);
        return Err(ConfigError::option("figure", &args.figure, one_of(&args.figure, names)));
    }
    let plan = |name: &&String| {
        let file = home.join(format!("{name}.toml"));
        let benchmark: Benchmark = read_toml(&file)?;
        check(&file.display().to_string(), &benchmark)?;
        let name = format!("{PREFIX}-{name}");
        let Some(profile) = benchmark.profiles.get(&args.profile).cloned() else {
            let expected = one_of(&args.profile, benchmark.profiles.keys().map(String::as_str));
            return Err(ConfigError::option("--profile", &args.profile, format!("{expected} in {name}")));
        };
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let plan = BenchmarkPlan {
            folder: args.out.join(&name).join(&args.profile),
            name,
            profile_name: args.profile.clone(),
            profile,
            home: home.clone(),
            jobs: args.jobs.unwrap_or(cores),
            seed: args.seed,
            fresh: args.fresh,
            benchmark,
        };
        let fail = |error: motes::MotesError| ConfigError::File {
            file: file.display().to_string(),
            reason: error.to_string(),
        };
        let sets = plan.benchmark.learned.iter().map(|method| &method.set);
        for set in sets.chain(plan.benchmark.recorded.iter().map(|recorded| &recorded.set)) {
            plan.model(set).map_err(fail)?;
        }
        Ok(plan)
    };
    chosen.iter().map(plan).collect()
}
