//! The arguments that say which parameters of a fit are taken.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use motes::{FitParameters, Model, MotesError};

/// Which of the parameters that were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum At {
    /// Draws of the posterior, which results are averaged over
    Draws,
    /// The posterior's mean
    Mean,
    /// The maximum of the likelihood
    Maximum,
}

#[derive(Args)]
pub(super) struct FittedArgs {
    /// Take the parameters that motes fit found, from its folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) parameters: Option<PathBuf>,
    /// Which of them: draws averages over the posterior and has no log-evidence, mean takes its mean, maximum that of the likelihood; if absent draws after a posterior fit, maximum after a maximum fit
    #[arg(long, value_name = "WHICH", requires = "parameters")]
    at: Option<At>,
}

/// The draws of the posterior that results are averaged over.
const DRAWS: usize = 100;

/// A model with the parameters that were asked for.
pub(super) struct ModelAtFit {
    /// With those of the file, or those at one point of a fit.
    pub(super) model: Model,
    /// The draws of a fit that results are to be averaged over, where they are.
    pub(super) draws: Option<FitParameters>,
}

impl FittedArgs {
    /// The model of a file with the parameters that are asked for; those of a fit are not `set` besides.
    pub(super) fn of(&self, file: Model, set: &[(String, f64)]) -> Result<ModelAtFit, MotesError> {
        let Some(folder) = &self.parameters else { return Ok(ModelAtFit { model: file, draws: None }) };
        let draws = load(folder, &file, set)?;
        match self.at {
            None | Some(At::Draws) if !draws.is_maximum => Ok(ModelAtFit { model: file, draws: Some(draws) }),
            at => Ok(ModelAtFit { model: point(folder, at, &file, &draws)?, draws: None }),
        }
    }
}

/// The model of a file at one point of a fit: that which is asked for, or else the one that was found.
pub(super) fn at_point(
    folder: &Path,
    at: Option<At>,
    file: &Model,
    set: &[(String, f64)],
) -> Result<Model, MotesError> {
    point(folder, at, file, &load(folder, file, set)?)
}

/// What was fitted, but what is set besides.
fn load(folder: &Path, file: &Model, set: &[(String, f64)]) -> Result<FitParameters, MotesError> {
    let draws = FitParameters::load(folder, file)?;
    match set.iter().find(|(name, _)| draws.names.contains(name)) {
        None => Ok(draws),
        Some((name, _)) => Err(MotesError::Setting(format!(
            "--set {name}: {} has values of it; leave out --set, or --parameters",
            folder.display()
        ))),
    }
}

fn point(folder: &Path, at: Option<At>, file: &Model, draws: &FitParameters) -> Result<Model, MotesError> {
    let reason = match (at, draws.is_maximum) {
        (None | Some(At::Maximum), true) | (None | Some(At::Mean), false) => return draws.at_mean(file),
        (Some(_), true) => "it has the maximum of the likelihood alone; take --at maximum",
        (Some(At::Maximum), false) => {
            "it has draws of the posterior; --at maximum needs a fit by --method maximum"
        }
        (Some(At::Draws), false) => "proposals are compared at one point; take --at mean",
    };
    Err(MotesError::Fit { folder: folder.display().to_string(), reason: reason.to_string() })
}

/// The models of some draws, evenly spread over all.
pub(super) fn spread(draws: &FitParameters, model: &Model) -> Result<Vec<Model>, MotesError> {
    draws.spread(model, DRAWS)
}
