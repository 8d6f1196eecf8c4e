//! How the learning rate changes in the course of a training.

use serde::{Deserialize, Serialize};

/// The learning rate of a step, as a share of the one that the optimiser is set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// The same in each step.
    #[default]
    Constant,
    /// It falls to 0 along half a cosine: `(1 + cos πp)/2` after the share `p` of all steps.
    Cosine,
}

impl Schedule {
    /// The share of the learning rate after `progress`, from 0 at the start to 1 at the end of the training.
    pub fn share(self, progress: f64) -> f64 {
        match self {
            Schedule::Constant => 1.0,
            Schedule::Cosine => 0.5 * (1.0 + (std::f64::consts::PI * progress).cos()),
        }
    }

    /// Whether it is at its default, at which it is not written.
    pub(crate) fn is_constant(&self) -> bool {
        *self == Schedule::Constant
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;

    #[test]
    fn shares_begin_at_one_and_only_those_of_a_cosine_fall() {
        let of = |schedule: Schedule| [0.0, 0.5, 1.0].map(|progress| schedule.share(progress));
        assert_eq!(of(Schedule::Constant), [1.0; 3]);
        let [first, half, last] = of(Schedule::Cosine);
        assert_eq!([first, last], [1.0, 0.0]);
        assert!((half - 0.5).abs() < 1e-15);
    }
}
