//! Which networks of a family serve which times.

use motes_smc::ProposalError;
use serde::{Deserialize, Serialize};

use crate::settings::check_horizon;

/// Which networks serve which times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OverTime {
    /// The paper's: a network for each time, so that the proposal has a horizon.
    #[default]
    EachTime,
    /// One for all times from 1 on, beside one for `t = 0`: `p(x_0 | y_0)` is another function than `p(x_t | x_{t−1}, y_t)`. The proposal has no
    /// horizon, and filters sequences of any length.
    Shared,
}

impl OverTime {
    /// Whether it is the default, which configurations and saved files leave out.
    pub(crate) fn is_each_time(&self) -> bool {
        *self == OverTime::EachTime
    }

    /// The horizon of a family that is made for `horizon` times.
    pub(crate) fn horizon(self, horizon: usize) -> Option<usize> {
        match self {
            OverTime::EachTime => Some(horizon),
            OverTime::Shared => None,
        }
    }

    /// How many networks there are for `horizon` times.
    pub(crate) fn networks(self, horizon: usize) -> usize {
        match self {
            OverTime::EachTime => horizon,
            OverTime::Shared => 2,
        }
    }

    /// How many there are of what is the same at all times in the paper.
    pub(crate) fn of_one(self) -> usize {
        match self {
            OverTime::EachTime => 1,
            OverTime::Shared => 2,
        }
    }

    /// Which of the networks serves `time`.
    pub(crate) fn at(self, time: usize) -> usize {
        match self {
            OverTime::EachTime => time,
            OverTime::Shared => time.min(1),
        }
    }

    /// Refuses to make networks for no time.
    pub(crate) fn check(self, horizon: usize) -> Result<(), ProposalError> {
        match self {
            OverTime::EachTime => check_horizon(horizon),
            OverTime::Shared => Ok(()),
        }
    }

    /// The names of networks that differ from time to time in the paper.
    pub(crate) fn names(self, name: &str, horizon: usize) -> Vec<String> {
        match self {
            OverTime::EachTime => (0..horizon).map(|time| format!("{name}.{time}")).collect(),
            OverTime::Shared => first_and_later(name),
        }
    }

    /// The names of networks that are the same at all times in the paper.
    pub(crate) fn names_of_one(self, name: &str) -> Vec<String> {
        match self {
            OverTime::EachTime => vec![name.into()],
            OverTime::Shared => first_and_later(name),
        }
    }
}

fn first_and_later(name: &str) -> Vec<String> {
    vec![format!("first.{name}"), name.into()]
}

/// The one of `networks`, one or two, that serves `time`: of two, the first serves `t = 0`.
pub(crate) fn one_at<T>(networks: &[T], time: usize) -> &T {
    &networks[time.min(networks.len() - 1)]
}
