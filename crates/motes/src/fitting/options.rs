//! What can be said of a fit.

use crate::options::ProposalName;

/// What parameters are fitted with. [`FitOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// The estimator of the likelihood; where none is given the exact one if there is one, else that designed proposal which costs the least work for the variance that
    /// is aimed at.
    pub proposal: Option<ProposalName>,
    /// `K`, the number of particles; if none is given it is found.
    pub particles: Option<usize>,
    /// The number of chains.
    pub chains: usize,
    /// The draws of each chain; where none are given it goes on until R̂ is below 1.01 and the effective sample sizes are 400 at least, or 20,000 are drawn.
    pub draws: Option<usize>,
    /// Of the maximum, the parameters whose profiles are sought; all if none are named.
    pub profiles: Vec<String>,
    /// Of the maximum, the passes of iterated filtering through the data. Where none are given it is 100 passes for 8 parameters or more, and for fewer searches on quadratics.
    pub passes: Option<usize>,
    /// Ends sampling after so many seconds; the draws then depend on the machine.
    pub seconds: Option<f64>,
    /// All random numbers come from it.
    pub seed: u64,
}

impl Default for FitOptions {
    fn default() -> Self {
        FitOptions {
            proposal: None,
            particles: None,
            chains: 4,
            draws: None,
            profiles: Vec::new(),
            passes: None,
            seconds: None,
            seed: 1,
        }
    }
}
