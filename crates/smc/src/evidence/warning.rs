//! Reasons not to trust a log-evidence or a standard deviation.

use std::fmt;

/// What an [`EvidenceCheck`](crate::EvidenceCheck) found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EvidenceWarning {
    /// Measurements lie beyond all particles: the model hardly ever makes one like them, or several in a row, from where they are.
    Surprise {
        /// At how many steps.
        steps: usize,
        /// The worst of them.
        worst: usize,
        /// The largest `log p(y_t | x_t)` of a particle there.
        best: f64,
        /// What is usual: the mean of `log p(y' | x_t)` over `y'` that the model draws from the particles.
        usual: f64,
    },
    /// The standard error of the log-evidence is so large that the estimate's bias is large, too.
    LargeError {
        /// The standard error (nats).
        standard_error: f64,
    },
    /// A coordinate of the state hardly moves, and its particles descend from too few.
    FewAncestors {
        /// The coordinate.
        coordinate: usize,
        /// The step at which it was found.
        step: usize,
        /// The step whose particles the present ones descend from.
        since: usize,
        /// How many of them, effectively.
        ancestors: f64,
    },
}

impl fmt::Display for EvidenceWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EvidenceWarning::Surprise { steps, worst, best, usual } => {
                let at = if *steps > 1 { format!(", at {steps} steps in all") } else { String::new() };
                write!(
                    f,
                    "at step {worst} the measurement lies beyond all particles (its log-density is {best:.1} at most, where {usual:.1} is \
                     usual){at}: the model does not expect it, and the log-evidence is too low"
                )
            }
            EvidenceWarning::LargeError { standard_error } => write!(
                f,
                "the log-evidence has a standard error of {standard_error:.0}: it is too low by an unknown amount"
            ),
            EvidenceWarning::FewAncestors { coordinate, step, since, ancestors } => write!(
                f,
                "coordinate {coordinate} hardly moves, and at step {step} its values descend from {ancestors:.0} particles of step {since}: its \
                 standard deviation is too small from there on"
            ),
        }
    }
}
