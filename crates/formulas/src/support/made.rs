//! Where measurements can lie whose distributions are made of others.

use super::family;
use super::interval::{End, Support};
use crate::program::KnownPart;
use crate::tables::Wrapping;

/// Numbers between two ends, perhaps integers alone; none of the ends where it is not known, or where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Set {
    are_integers: bool,
    low: Option<End>,
    high: Option<End>,
}

/// All numbers.
const ANY: Set = Set { are_integers: false, low: None, high: None };

impl Set {
    /// The numbers that a distribution can give whatever the states are.
    pub(super) fn of(known: &KnownPart) -> Set {
        let (wrapping, ends, parts) = match known {
            KnownPart::Plain(known) => return family::of(known).map_or(ANY, Set::from),
            KnownPart::Made { wrapping, ends, parts } => (wrapping, ends, parts),
        };
        let of_part = |at: usize| parts.get(at).map_or(ANY, Set::of);
        match wrapping {
            // There is no number without density.
            Wrapping::VonMises | Wrapping::LogDensity | Wrapping::Floored => ANY,
            Wrapping::Rounded => {
                let inner = of_part(0);
                // What lies in (y − ½, y + ½] becomes y.
                let nearest = |end: End, is_in: bool| {
                    let down = (end.at - 0.5).ceil();
                    // What lies above an end that is the last of its integer becomes the next one.
                    let is_next = !is_in && down + 0.5 == end.at && !end.is_in;
                    End { at: if is_next { down + 1.0 } else { down }, is_in: true }
                };
                let low = inner.low.map(|end| nearest(end, false));
                Set { are_integers: true, low, high: inner.high.map(|end| nearest(end, true)) }
            }
            Wrapping::Censored | Wrapping::Truncated => {
                let inner = of_part(0);
                let end = |at: Option<f64>| at.filter(|at| at.is_finite()).map(|at| End { at, is_in: true });
                let (low, high) = (end(ends[0]), end(ends[1]));
                // Where an end is not known, what is censored may be moved there.
                let is_moved = *wrapping == Wrapping::Censored;
                let tighter =
                    |own: Option<End>, inner: Option<End>, is_known: bool, sign: f64| match (own, inner) {
                        (Some(own), Some(inner)) if is_moved || own.at * sign >= inner.at * sign => Some(own),
                        (Some(_), Some(inner)) => Some(inner),
                        (own, inner) => own.or(inner.filter(|_| is_known || !is_moved)),
                    };
                let is_integer =
                    |end: Option<f64>| end.is_some_and(|end| end.is_infinite() || end.fract() == 0.0);
                Set {
                    are_integers: inner.are_integers
                        && (!is_moved || (is_integer(ends[0]) && is_integer(ends[1]))),
                    low: tighter(low, inner.low, ends[0].is_some(), 1.0),
                    high: tighter(high, inner.high, ends[1].is_some(), -1.0),
                }
            }
            Wrapping::ZeroInflated => {
                let zero = End { at: 0.0, is_in: true };
                of_part(0).or(Set { are_integers: true, low: Some(zero), high: Some(zero) })
            }
            Wrapping::Mixture => of_part(0).or(of_part(1)),
            Wrapping::Categorical => {
                let end = |at: Option<f64>| at.map(|at| End { at, is_in: true });
                Set { are_integers: true, low: end(ends[0]), high: end(ends[1]) }
            }
        }
    }

    /// What holds both.
    fn or(self, other: Set) -> Set {
        let wider = |one: Option<End>, other: Option<End>, sign: f64| {
            let (one, other) = (one?, other?);
            Some(match one.at == other.at {
                true => End { at: one.at, is_in: one.is_in || other.is_in },
                false if one.at * sign < other.at * sign => one,
                false => other,
            })
        };
        Set {
            are_integers: self.are_integers && other.are_integers,
            low: wider(self.low, other.low, 1.0),
            high: wider(self.high, other.high, -1.0),
        }
    }

    /// The support, if it is not the whole line.
    pub(super) fn support(self) -> Option<Support> {
        let Set { are_integers, low, high } = self;
        match are_integers {
            true if low.is_some_and(|low| low.at == 0.0) => {
                Some(Support::Counts { most: high.map(|high| high.at) })
            }
            true => Some(Support::Integers {
                least: low.map(|low| low.at.ceil()),
                most: high.map(|high| high.at.floor()),
            }),
            false if low.is_none() && high.is_none() => None,
            false => Some(Support::Interval { low, high }),
        }
    }
}

impl From<Support> for Set {
    fn from(support: Support) -> Set {
        let end = |at: f64| End { at, is_in: true };
        match support {
            Support::Counts { most } => Set { are_integers: true, low: Some(end(0.0)), high: most.map(end) },
            Support::Integers { least, most } => {
                Set { are_integers: true, low: least.map(end), high: most.map(end) }
            }
            Support::Interval { low, high } => Set { are_integers: false, low, high },
        }
    }
}
