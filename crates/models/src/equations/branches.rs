//! All that draws of few values can lead to.

use super::distribution::Distribution;
use super::statement::{Draws, Equations};
use crate::Step;
use crate::batch::with_scratch;
use crate::forward::ForwardError;

/// A draw, with its values and their probabilities.
struct Choice {
    values: Vec<(f64, f64)>,
    chosen: usize,
}

/// Answers draws with values that were chosen, and from there on with the first one of each.
struct Way<'a> {
    choices: &'a mut Vec<Choice>,
    next: usize,
    probability: f64,
    /// The shares that the next draw chooses among, if it does.
    shares: Option<Vec<f64>>,
    is_discrete: bool,
}

impl Draws<f64> for Way<'_> {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        let shares = self.shares.take();
        if self.next == self.choices.len() {
            let values = match shares {
                Some(shares) => of_shares(&shares),
                None => values(distribution),
            };
            self.is_discrete &= values.is_some();
            self.choices.push(Choice { values: values.unwrap_or(vec![(f64::NAN, 1.0)]), chosen: 0 });
        }
        let choice = &self.choices[self.next];
        let (value, probability) = choice.values[choice.chosen];
        self.next += 1;
        self.probability *= probability;
        value
    }

    fn among(&mut self, count: usize, share: impl Fn(usize) -> f64) {
        self.shares = Some((0..count).map(share).collect());
    }
}

/// The most values of one draw.
const MOST: f64 = 1e6;

/// The values of a distribution of finitely many; NaN where its parameters are out of range.
fn values(distribution: Distribution<f64>) -> Option<Vec<(f64, f64)>> {
    let Distribution::Binomial(binomial) = distribution else { return None };
    let (n, p) = (binomial.n, binomial.p);
    if n.fract() != 0.0 || n < 0.0 || !(0.0..=1.0).contains(&p) || n.is_nan() {
        return Some(vec![(f64::NAN, 1.0)]);
    }
    if n == 1.0 {
        return Some(possible([(0.0, 1.0 - p), (1.0, p)].into_iter()));
    }
    if n > MOST {
        return None;
    }
    let counts = (0..=n as usize).map(|count| count as f64);
    Some(possible(counts.map(|count| (count, distribution.log_density(count).exp()))))
}

fn possible(values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    values.filter(|(_, probability)| *probability > 0.0).collect()
}

/// Uniform numbers, one in the middle of each share; NaN where a share is negative or none.
fn of_shares(shares: &[f64]) -> Option<Vec<(f64, f64)>> {
    let all: f64 = shares.iter().sum();
    if !shares.iter().all(|share| *share >= 0.0) || !(all > 0.0 && all.is_finite()) {
        return Some(vec![(f64::NAN, 1.0)]);
    }
    let mut below = 0.0;
    let places = shares.iter().map(|share| {
        let place = (below + share / 2.0) / all;
        below += share;
        (place, share / all)
    });
    Some(possible(places))
}

/// Gives `take` each state (`N`) that the draws of a sub-step can make of `previous` (`N`), or each `x_0` where there is none, with its probability. Each way is one less of
/// `ways`.
///
/// # Errors
/// [`ForwardError::NotDiscrete`] where a draw has other than few values, [`ForwardError::TooManyWays`] where no way is left.
pub fn branches(
    model: &impl Equations,
    part: &Step<'_>,
    previous: Option<&[f64]>,
    ways: &mut usize,
    take: &mut dyn FnMut(&[f64], f64),
) -> Result<(), ForwardError> {
    let [n, _] = model.dimensions();
    with_scratch(n, |state| {
        let mut choices: Vec<Choice> = Vec::new();
        loop {
            *ways = ways.checked_sub(1).ok_or(ForwardError::TooManyWays(0))?;
            let mut way =
                Way { choices: &mut choices, next: 0, probability: 1.0, shares: None, is_discrete: true };
            match previous {
                None => model.initial(part, &mut way, state),
                Some(previous) => model.transition(part, previous, &mut way, state),
            }
            if !way.is_discrete {
                return Err(ForwardError::NotDiscrete);
            }
            take(state, way.probability);
            // The next way: another value of the last draw that has one.
            loop {
                let Some(last) = choices.last_mut() else { return Ok(()) };
                last.chosen += 1;
                if last.chosen < last.values.len() {
                    break;
                }
                choices.pop();
            }
        }
    })
}
