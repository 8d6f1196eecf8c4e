//! Where distributions of the table lie.

use super::interval::{End, Support};
use crate::program::Known;
use crate::tables::{Most, Values};

/// The support of a distribution, if it is the same for all states and not the whole line.
pub(super) fn of(known: &Known) -> Option<Support> {
    match known.family.values {
        Values::Any => None,
        Values::Counts(most) => {
            let most = match most {
                Most::Any => None,
                Most::One => Some(1.0),
                Most::First => known.parameters[0],
            };
            let most = most.filter(|most| *most >= 0.0 && most.fract() == 0.0);
            Some(Support::Counts { most })
        }
        Values::FromZero => beyond(known, true),
        Values::AboveZero => beyond(known, false),
        Values::InsideOne => between(known, [Some(0.0), Some(1.0)], false),
        Values::Between => between(known, [known.parameters[0], known.parameters[1]], true),
    }
}

/// All numbers on one side of the point where a distribution begins, with that point or without it.
fn beyond(known: &Known, is_in: bool) -> Option<Support> {
    let (at, scale) = (finite(known.shift)?, finite(known.scale)?);
    let end = Some(End { at, is_in });
    match scale {
        0.0 => None,
        _ if scale > 0.0 => Some(Support::Interval { low: end, high: None }),
        _ => Some(Support::Interval { low: None, high: end }),
    }
}

/// All numbers between two ends, one of which may depend on states, with these ends or without them.
fn between(known: &Known, ends: [Option<f64>; 2], is_in: bool) -> Option<Support> {
    let (shift, scale) = (finite(known.shift)?, finite(known.scale)?);
    let end = |which: usize| {
        let at = finite(ends[which])? * scale + shift;
        at.is_finite().then_some(End { at, is_in })
    };
    let [low, high] = if scale > 0.0 { [end(0), end(1)] } else { [end(1), end(0)] };
    let is_wrong = matches!((low, high), (Some(low), Some(high)) if low.at >= high.at);
    let is_nothing = scale == 0.0 || (low.is_none() && high.is_none());
    (!is_wrong && !is_nothing).then_some(Support::Interval { low, high })
}

fn finite(value: Option<f64>) -> Option<f64> {
    value.filter(|value| value.is_finite())
}
