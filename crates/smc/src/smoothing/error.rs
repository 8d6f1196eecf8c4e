//! Why trajectories cannot be drawn.

use thiserror::Error;

/// Why trajectories cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SmoothingError {
    /// There is nothing to draw from, or nothing to be drawn.
    #[error("{name} is 0; it must be at least 1")]
    Nothing {
        /// What there is none of.
        name: &'static str,
    },
    /// What the filter was cannot be kept, or the trajectories cannot.
    #[error(
        "{numbers} numbers are to be kept, for which there is no memory; take fewer particles, paths or times"
    )]
    Memory {
        /// How many numbers of 64 bits.
        numbers: usize,
    },
    /// The history of a filter has a gap.
    #[error("the filter has taken {steps} steps, of which {kept} are kept; record it after each step")]
    Skipped {
        /// The steps that it has taken.
        steps: usize,
        /// Those that are kept.
        kept: usize,
    },
    /// What was recorded is not that of one filter of this model.
    #[error(
        "at time {time}, the particles that were recorded have not as many coordinates as the model, or do not descend from those of the time before"
    )]
    OtherFilter {
        /// The time `t` of the particles.
        time: usize,
    },
    /// From no particle the transition leads to the state that was drawn for the next time, or a density is not a number.
    #[error(
        "at time {time}, no particle leads to the state that a path has at the next time: all transition densities are 0 or not numbers"
    )]
    NoAncestor {
        /// The time `t` of the particles.
        time: usize,
    },
    /// Who asked for them said to stop.
    #[error("interrupted before all trajectories were drawn")]
    Interrupted,
}
