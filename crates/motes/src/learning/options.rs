//! How a proposal is learned.

use motes_proposals::{Base, HeadConfig};

/// How a proposal is learned. [`LearnOptions::default`] is what the command takes where nothing else is said.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnOptions {
    /// Gradient steps.
    pub updates: usize,
    /// Learning ends after so many seconds; its results then depend on the machine.
    pub seconds: Option<f64>,
    /// The number of times of a simulated sequence.
    pub steps: usize,
    /// The designed proposal that it is built around; chosen if none is given.
    pub base: Option<Base>,
    /// What its networks emit; chosen if none is given.
    pub head: Option<HeadConfig>,
    /// The widths of its networks' hidden layers.
    pub widths: Vec<usize>,
    /// All random numbers come from it.
    pub seed: u64,
}

impl Default for LearnOptions {
    fn default() -> Self {
        LearnOptions {
            updates: 5000,
            seconds: None,
            steps: 100,
            base: None,
            head: None,
            widths: vec![64, 64],
            seed: 1,
        }
    }
}
