//! Where measurements can lie whatever the states are: what lies elsewhere has density 0 for every particle.

mod family;
mod interval;
mod made;

pub(crate) use interval::Digits;
pub use interval::{End, Support};

use crate::program::{KnownPart, Program};

/// The support of each coordinate of a program at a time, as far as it holds for all states.
pub(crate) fn supports(program: &Program, time: f64) -> Vec<Option<Support>> {
    program.known(time).iter().map(of_part).collect()
}

fn of_part(known: &KnownPart) -> Option<Support> {
    match known {
        KnownPart::Plain(known) => family::of(known),
        KnownPart::Made { .. } => made::Set::of(known).support(),
    }
}
