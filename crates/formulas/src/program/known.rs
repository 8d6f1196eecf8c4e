//! What is known of distributions before there are states.

use motes_models::Step;
use motes_models::equations::with_scalars;

use super::instruction::{MadeTerm, NoiseTerm, PartTerm, PlainStep, Program, Rule, Source};
use super::moment::Moment;
use crate::tables::{Family, Wrapping};

/// The distribution of a coordinate as far as it is the same for all states: a number that depends on them is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Known {
    pub(crate) family: &'static Family,
    /// What the family does not take is some other number of it.
    pub(crate) parameters: [Option<f64>; 3],
    /// What it is multiplied by: 1 where it is not.
    pub(crate) scale: Option<f64>,
    /// What is added then: 0 where nothing is.
    pub(crate) shift: Option<f64>,
}

/// What is known of a distribution, or of those that it is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum KnownPart {
    Plain(Known),
    Made {
        wrapping: Wrapping,
        /// Its ends, if it has such; of a categorical, its first number and its last.
        ends: [Option<f64>; 2],
        parts: Vec<KnownPart>,
    },
}

fn of_made(
    term: &MadeTerm,
    value: &impl Fn(Source) -> Option<f64>,
    of_term: &impl Fn(&NoiseTerm) -> Known,
) -> KnownPart {
    let part = |part: &PartTerm| match part {
        PartTerm::Plain(term) => KnownPart::Plain(of_term(term)),
        PartTerm::Made(term) => of_made(term, value, of_term),
    };
    // The ends alone are asked for.
    let ends = match term.wrapping {
        Wrapping::Censored | Wrapping::Truncated => term.numbers.map(value),
        Wrapping::Categorical => [Some(0.0), Some(term.shares.len() as f64 - 1.0)],
        _ => [None; 2],
    };
    KnownPart::Made { wrapping: term.wrapping, ends, parts: term.parts.iter().map(part).collect() }
}

impl Program {
    /// Whether any number that is the same for all states differs from step to step.
    pub(crate) fn depends_on_step(&self) -> bool {
        self.steps.iter().any(|step| {
            matches!(step, PlainStep::Time | PlainStep::Length | PlainStep::Input(_) | PlainStep::First)
        })
    }

    /// Whether any number is another at another time.
    pub(crate) fn depends_on_time(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, PlainStep::Time))
    }

    /// For each coordinate, whether it depends on a state from this one on.
    pub(crate) fn depend_on_states_from(&self, first: usize) -> Vec<bool> {
        self.depends_on.iter().map(|states| states.iter().any(|state| *state as usize >= first)).collect()
    }

    /// What is known of the distribution of each coordinate that has one in a step.
    pub(crate) fn known(&self, step: &Step<'_>) -> Vec<KnownPart> {
        with_scalars::<f64, _>(self.constants.len() + self.steps.len(), |plain| {
            self.plain(Moment::of(step), plain);
            let value = |source: Source| match source {
                Source::Plain(place) => Some(plain[place as usize]),
                Source::Varied(_) => None,
            };
            let of = |source: Option<Source>, otherwise: f64| source.map_or(Some(otherwise), value);
            let of_term = |term: &NoiseTerm| Known {
                family: term.family,
                parameters: term.parameters.map(value),
                scale: of(term.scale, 1.0),
                shift: of(term.shift, 0.0),
            };
            let known = self.coordinates.iter().filter_map(|output| match &output.rule {
                Rule::Noise(term) => Some(KnownPart::Plain(of_term(term))),
                Rule::Made(term) => Some(of_made(term, &value, &of_term)),
                Rule::Formula(_) | Rule::Computed(_) => None,
            });
            known.collect()
        })
    }
}
