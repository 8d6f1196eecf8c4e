//! Arguments and experiment file brought together: exactly what is to be run.

use std::fmt;
use std::path::{Path, PathBuf};

use motes_cli::one_of;
use motes_proposals::Backend;
use serde::{Deserialize, Serialize};

use super::args::ReproduceArgs;
use super::check::check;
use super::densities::Densities;
use super::error::ConfigError;
use super::load::{figures, load};
use super::method::Method;
use super::schema::{Axis, Experiment, Panel, Profile};

/// One figure in one profile, restricted to what was asked for.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Plan {
    /// The figure's name.
    pub figure: String,
    /// The profile's name.
    pub profile_name: String,
    /// The whole file.
    pub experiment: Experiment,
    /// The chosen profile.
    pub profile: Profile,
    /// The chosen panels, in the file's order.
    pub panels: Vec<Panel>,
    /// The chosen values on the x axis, in the file's order.
    pub xs: Vec<usize>,
    /// The chosen methods, in the file's order.
    pub methods: Vec<Method>,
    /// Repetitions to run.
    pub repetitions: usize,
    /// Units run side by side.
    pub jobs: usize,
    /// What computes the networks.
    pub backend: Backend,
    /// The seed of the run.
    pub seed: u64,
    /// Where results go, figure and profile included.
    pub folder: PathBuf,
    /// Where proposals are kept that are learned once; figures share them.
    pub learned: PathBuf,
    /// Whether finished units are to be run again.
    pub fresh: bool,
    /// Whether trained proposals are kept.
    pub save_models: bool,
}

/// One unit of work by its place in the figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Point {
    /// The panel's name.
    pub panel: String,
    /// The value on the x axis.
    pub x: usize,
    /// The method.
    pub method: Method,
    /// The repetition, from 0.
    pub repetition: usize,
}

/// What it runs, in one line.
impl fmt::Display for Plan {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let methods: Vec<&str> = self.methods.iter().map(|method| method.name()).collect();
        let panels: Vec<&str> = self.panels.iter().map(|panel| panel.name.as_str()).collect();
        write!(
            formatter,
            "{} {}: panels {}, x = {:?}, methods {}, {} repetitions, seed {}, backend {}",
            self.figure,
            self.profile_name,
            panels.join(" "),
            self.xs,
            methods.join(" "),
            self.repetitions,
            self.seed,
            self.backend,
        )
    }
}

impl Plan {
    /// The units of this plan: panel by panel, so that finished panels come early.
    pub fn points(&self) -> Vec<Point> {
        let mut points = Vec::new();
        for panel in &self.panels {
            for &x in &self.xs {
                for &method in &self.methods {
                    for repetition in 0..self.repetitions {
                        points.push(Point { panel: panel.name.clone(), x, method, repetition });
                    }
                }
            }
        }
        points
    }

    /// Where the trained proposals of units are kept, if they are.
    pub(crate) fn models(&self) -> Option<PathBuf> {
        self.save_models.then(|| self.folder.join("models"))
    }

    /// What filters take the noises to be in the panel of that name, where it says so.
    pub fn densities(&self, panel: &str) -> Option<Densities> {
        self.experiment.panels.iter().find(|found| found.name == panel)?.densities
    }

    /// N, T and K of the units at `x` in the panel of that name; `None` if the figure has no such panel.
    pub fn sizes(&self, panel: &str, x: usize) -> Option<(usize, usize, usize)> {
        let Experiment { filter, axis, panels, .. } = &self.experiment;
        let panel = panels.iter().find(|found| found.name == panel)?;
        let (dimension, t) = self.experiment.sizes()?;
        let (n, k) = (panel.dimension.unwrap_or(dimension), filter.particles);
        Some(match axis {
            Axis::Particles => (n, t, x),
            Axis::Horizon => (n, x, k),
            Axis::Dimension => (x, t, k),
        })
    }
}

/// What the names of figures begin with that are not the paper's: proposals that are learned once, and the paper's on the evidence and smoothed states of what they
/// were trained on. By itself, all of them. `all` is the paper's.
const GROUPS: [&str; 2] = ["heldout", "hindsight"];

/// The plans that the arguments ask for, one for each figure. Reads experiment files and writes nothing.
///
/// # Errors
/// [`ConfigError`] for anything that could not be run.
pub fn plans(args: &ReproduceArgs) -> Result<Vec<Plan>, ConfigError> {
    let known = figures(&args.experiments)?;
    let group = match args.figure.as_str() {
        "all" => Some(None),
        name => GROUPS.into_iter().find(|group| *group == name).map(Some),
    };
    if let Some(group) = group {
        let of = |figure: &String| GROUPS.into_iter().find(|group| figure.starts_with(group));
        let of_group = known.iter().filter(|figure| of(figure) == group);
        return of_group.map(|figure| plan(figure, args)).collect();
    }
    if known.contains(&args.figure) {
        return Ok(vec![plan(&args.figure, args)?]);
    }
    let mut others = Vec::new();
    for figure in &known {
        let file = args.experiments.join(format!("{figure}.toml"));
        // A file that cannot be read has no other name to give; it is an error where it is asked for.
        let Ok(Experiment { also, .. }) = load(&file) else { continue };
        if also.contains(&args.figure) {
            return Ok(vec![plan(figure, args)?]);
        }
        others.extend(also);
    }
    let names = known.iter().chain(&others).map(String::as_str).chain(["all"]).chain(GROUPS);
    Err(ConfigError::option("figure", &args.figure, one_of(&args.figure, names)))
}

/// Every panel and x of a figure's paper profile; those of an experiment that has no file yet are none.
///
/// # Errors
/// [`ConfigError`] if the file cannot be used.
pub fn whole_figure(experiments: &Path, figure: &str) -> Result<Vec<(String, usize)>, ConfigError> {
    if !figures(experiments)?.iter().any(|known| known == figure) {
        return Ok(Vec::new());
    }
    let file = experiments.join(format!("{figure}.toml"));
    let experiment = load(&file)?;
    check(&file.display().to_string(), &experiment)?;
    let Some(profile) = experiment.profiles.get("paper") else { return Ok(Vec::new()) };
    let panels = experiment.panels.iter();
    let chosen =
        panels.filter(|panel| profile.panels.as_ref().is_none_or(|names| names.contains(&panel.name)));
    Ok(chosen.flat_map(|panel| profile.x.iter().map(|x| (panel.name.clone(), *x))).collect())
}

fn plan(figure: &str, args: &ReproduceArgs) -> Result<Plan, ConfigError> {
    let file = args.experiments.join(format!("{figure}.toml"));
    let experiment = load(&file)?;
    check(&file.display().to_string(), &experiment)?;
    let Some(profile) = experiment.profiles.get(&args.profile).cloned() else {
        let names = experiment.profiles.keys().map(String::as_str);
        return Err(ConfigError::option("--profile", &args.profile, one_in(figure, &args.profile, names)));
    };
    let of_profile: Vec<&Panel> = experiment
        .panels
        .iter()
        .filter(|panel| profile.panels.as_ref().is_none_or(|names| names.contains(&panel.name)))
        .collect();
    let panels = select(figure, ("--panels", &args.panels), &of_profile, |panel| &panel.name)?;
    let of_profile: Vec<(usize, String)> = profile.x.iter().map(|&x| (x, x.to_string())).collect();
    let xs = select(figure, ("--x", &args.x), &of_profile, |(_, x)| x)?;
    let methods = select(figure, ("--methods", &args.methods), &experiment.methods, |method| method.name())?;
    Ok(Plan {
        figure: figure.to_string(),
        profile_name: args.profile.clone(),
        panels: panels.into_iter().cloned().collect(),
        xs: xs.into_iter().map(|(x, _)| x).collect(),
        methods,
        repetitions: args.repetitions.unwrap_or(profile.repetitions),
        jobs: args.jobs.unwrap_or_else(|| args.cluster.threads()),
        backend: args.backend,
        seed: args.seed,
        folder: args.out.join(figure).join(&args.profile),
        learned: args.out.join("learned"),
        fresh: args.fresh,
        save_models: args.save_models,
        profile,
        experiment,
    })
}

/// The names to choose from in one figure, which `reproduce all` does not name otherwise.
fn one_in<'a>(figure: &str, found: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    format!("{} in {figure}", one_of(found, names))
}

/// Those of `all` in a figure whose names an option asked for, in the order of `all`; all of them if none was.
fn select<T: Clone>(
    figure: &str,
    (option, asked): (&str, &[String]),
    all: &[T],
    name: impl Fn(&T) -> &str,
) -> Result<Vec<T>, ConfigError> {
    for (at, asked_name) in asked.iter().enumerate() {
        if !all.iter().any(|item| name(item) == asked_name) {
            return Err(ConfigError::option(
                option,
                asked_name,
                one_in(figure, asked_name, all.iter().map(&name)),
            ));
        }
        if asked[..at].contains(asked_name) {
            return Err(ConfigError::option(option, &asked.join(","), format!("{asked_name} stands twice")));
        }
    }
    let chosen = all.iter().filter(|item| asked.is_empty() || asked.iter().any(|asked| asked == name(item)));
    Ok(chosen.cloned().collect())
}

/// Makes sure that results can be written to `folder`, by creating it and a file in it that is removed again.
///
/// # Errors
/// [`ConfigError::Output`].
pub fn check_output(folder: &Path) -> Result<(), ConfigError> {
    let fail =
        |error: std::io::Error| ConfigError::Output { folder: folder.into(), reason: error.to_string() };
    std::fs::create_dir_all(folder).map_err(fail)?;
    let probe = folder.join(format!(".writable-{}", std::process::id()));
    std::fs::write(&probe, b"").map_err(fail)?;
    std::fs::remove_file(&probe).map_err(fail)
}
