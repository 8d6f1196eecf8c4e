//! The arguments that say which parameters of a fit are taken.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use motes::{FittedDraws, Model, MotesError};

/// Which of the parameters that were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum At {
    /// Draws of the posterior, which results are averaged over
    Draws,
    /// The posterior's mean
    Mean,
}

#[derive(Args)]
pub(super) struct FittedArgs {
    /// Take the parameters that motes fit found, from its folder
    #[arg(long, value_name = "FOLDER")]
    pub(super) parameters: Option<PathBuf>,
    /// Which of them: draws averages over the posterior and has no log-evidence, mean takes its mean
    #[arg(long, value_name = "WHICH", default_value = "draws", requires = "parameters")]
    at: At,
}

/// The draws of the posterior that results are averaged over.
const DRAWS: usize = 100;

/// A model with the parameters that were asked for.
pub(super) enum Parametrised {
    /// Those of the file, or the mean of a fit.
    Model(Model),
    /// Draws of a fit.
    Draws(FittedDraws),
}

impl FittedArgs {
    /// The model with the parameters that are asked for.
    pub(super) fn of(&self, model: &Model) -> Result<Parametrised, MotesError> {
        let Some(folder) = &self.parameters else { return Ok(Parametrised::Model(model.clone())) };
        let draws = FittedDraws::load(folder, model)?;
        match self.at {
            At::Mean => Ok(Parametrised::Model(draws.at_mean(model)?)),
            At::Draws => Ok(Parametrised::Draws(draws)),
        }
    }
}

/// The models of some draws, evenly spread over all.
pub(super) fn spread(draws: &FittedDraws, model: &Model) -> Result<Vec<Model>, MotesError> {
    draws.spread(model, DRAWS.min(draws.len()))
}
