//! The arguments that say which parameters of a fit are taken.

use std::path::PathBuf;

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
    /// Which of them: draws averages over the posterior and has no log-evidence, mean takes its mean, maximum that of the likelihood; if absent what was found
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
        let draws = FitParameters::load(folder, &file)?;
        if let Some((name, _)) = set.iter().find(|(name, _)| draws.names.contains(name)) {
            return Err(MotesError::Setting(format!(
                "--set {name}: {} has values of it; leave out --set, or --parameters",
                folder.display()
            )));
        }
        let refused = |reason: &str| MotesError::Fit {
            folder: folder.display().to_string(),
            reason: reason.to_string(),
        };
        match (self.at, draws.is_maximum) {
            (None | Some(At::Maximum), true) | (Some(At::Mean), false) => {
                Ok(ModelAtFit { model: draws.at_mean(&file)?, draws: None })
            }
            (None | Some(At::Draws), false) => Ok(ModelAtFit { model: file, draws: Some(draws) }),
            (Some(_), true) => Err(refused("it has the maximum of the likelihood alone; take --at maximum")),
            (Some(At::Maximum), false) => {
                Err(refused("it has draws of the posterior; --at maximum needs a fit by --method maximum"))
            }
        }
    }
}

/// The models of some draws, evenly spread over all.
pub(super) fn spread(draws: &FitParameters, model: &Model) -> Result<Vec<Model>, MotesError> {
    draws.spread(model, DRAWS)
}
