//! Where measurements can lie whatever the states are: what lies elsewhere has density 0 for every particle.

mod family;
mod interval;
mod made;

pub(crate) use interval::Digits;
pub use interval::{End, Support};

use motes_models::Step;

use crate::priors::Prior;
use crate::program::{KnownPart, Program};

/// The support of each coordinate of a program in a step, as far as it holds for all states.
pub(crate) fn supports(program: &Program, step: &Step<'_>) -> Vec<Option<Support>> {
    program.known(step).iter().map(of_part).collect()
}

fn of_part(known: &KnownPart) -> Option<Support> {
    match known {
        KnownPart::Plain(known) => family::of(known),
        KnownPart::Made { .. } => made::Set::of(known).support(),
    }
}

impl Prior {
    /// Where each of its values can lie; none where it can be any number.
    pub fn support(&self) -> Option<Support> {
        let [low, high] = self.law.ends();
        if self.law.is_discrete() {
            return Some(Support::Counts { most: Some(high).filter(|high| high.is_finite()) });
        }
        // An end belongs to it where the density is more than 0 there.
        let is_in = |at: f64| self.law.log_density(&[at]) > f64::NEG_INFINITY;
        let end = |at: f64| at.is_finite().then(|| End { at, is_in: is_in(at) });
        let (low, high) = (end(low), end(high));
        (low.is_some() || high.is_some()).then_some(Support::Interval { low, high })
    }
}
