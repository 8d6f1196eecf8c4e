//! Rows to learn from: simulated anew for each few steps, shuffled, used once.

use motes_models::{ModelError, OwnModel, OwnSteps, Seed, Stream};
use motes_proposals::{Amortised, Examples, Stage};
use rand::seq::SliceRandom;

use super::settings::LearnConfig;

/// Sequences whose first state alone is wanted, for each whole one.
const BEGINNINGS: usize = 8;

/// Windows that the sequences of a supply are dealt to: few, since the states before each are drawn as well, and others in the next supply.
const WINDOWS: usize = 8;

/// A supply of rows, and what became of the sequences that they come from.
pub(super) struct Supply {
    pub(super) examples: Examples,
    /// Sequences that overflowed before their end.
    pub(super) lost: usize,
    pub(super) sequences: usize,
}

/// Where the sequences come from that learning is judged by.
pub(super) fn for_validation(seed: &Seed) -> Seed {
    seed.child("validation")
}

/// Where those come from that are learned from.
pub(super) fn for_training(seed: &Seed) -> Seed {
    seed.child("training").child("simulations")
}

/// Simulates `config.sequences` whole sequences, and the beginnings of more.
pub(super) fn drawn(
    proposal: &Amortised,
    model: &(impl OwnModel + ?Sized),
    config: &LearnConfig,
    seed: &Seed,
) -> Result<Supply, ModelError> {
    let mut examples = Examples::default();
    let sequences = config.sequences;
    let mut lost = 0;
    for mut whole in whole(model, sequences, config, &seed.child("sequences"))? {
        for _ in 0..config.horizon {
            match whole.advance() {
                Some(step) => proposal.encode(model, &step, &mut examples)?,
                None => break,
            }
        }
        lost += whole.lost();
    }
    for mut beginnings in windows(model, BEGINNINGS * sequences, config, &seed.child("beginnings"), None)? {
        if let Some(step) = beginnings.advance() {
            proposal.encode(model, &step, &mut examples)?;
        }
    }
    Ok(Supply { examples, lost, sequences })
}

/// So many sequences of as many times as the horizon is long: side by side, or where the model has sequences of its own, in some windows of these.
pub(super) fn whole<'m, M: OwnModel + ?Sized>(
    model: &'m M,
    sequences: usize,
    config: &LearnConfig,
    seed: &Seed,
) -> Result<Vec<OwnSteps<'m, M>>, ModelError> {
    windows(model, sequences, config, seed, Some(config.horizon))
}

/// Sequences in windows of so many rows of the model's own sequences, or from the beginning of these on.
fn windows<'m, M: OwnModel + ?Sized>(
    model: &'m M,
    sequences: usize,
    config: &LearnConfig,
    seed: &Seed,
    rows: Option<usize>,
) -> Result<Vec<OwnSteps<'m, M>>, ModelError> {
    let within = config.largest_state.unwrap_or(f64::INFINITY);
    if model.own_sequences().is_empty() {
        return Ok(vec![OwnSteps::new(model, sequences, seed)?.within(within)]);
    }
    let windows = WINDOWS.min(sequences);
    let of_window = |number: usize| {
        // As evenly as they can be dealt.
        let share = (sequences + number) / windows;
        let steps = OwnSteps::new(model, share, &seed.nth(number as u64))?.within(within);
        Ok(match rows {
            Some(rows) => steps.in_window(rows),
            None => steps.at_beginning(),
        })
    };
    (0..windows).map(of_window).collect()
}

/// One stage of a supply, dealt out in batches until it is used up.
#[derive(Default)]
pub(super) struct Deck {
    stage: Stage,
    order: Vec<usize>,
    used: usize,
}

impl Deck {
    pub(super) fn new(stage: Stage, stream: &mut Stream) -> Self {
        let mut order: Vec<usize> = (0..stage.len()).collect();
        order.shuffle(stream);
        Deck { stage, order, used: 0 }
    }

    /// How many rows are left.
    pub(super) fn left(&self) -> usize {
        self.order.len() - self.used
    }

    /// Puts the next `rows` rows into `batch`; `false` if so many are not left.
    pub(super) fn deal(&mut self, rows: usize, batch: &mut Stage) -> bool {
        let Some(picked) = self.order.get(self.used..self.used + rows) else { return false };
        batch.pick(&self.stage, picked);
        self.used += rows;
        true
    }
}

#[cfg(test)]
mod tests {
    use motes_models::ModelShape;
    use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
    use motes_proposals::{AmortisedConfig, Backend, Family};

    use motes_models::Step;

    use super::*;

    struct Walk;

    impl Equations for Walk {
        fn dimensions(&self) -> [usize; 2] {
            [1, 1]
        }

        fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
            state[0] = draws.draw(normal(0.0, 1.0));
        }

        fn transition<S: Scalar>(
            &self,
            _: &Step<'_, S>,
            x: &[S],
            draws: &mut impl Draws<S>,
            state: &mut [S],
        ) {
            state[0] = draws.draw(normal(x[0] * 0.9, 1.0));
        }

        fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
            y.push(normal(x[0], 1.0));
        }
    }

    /// Whether a row that is judged by is among those that are learned from.
    fn leaks(validation: &Seed, training: &Seed) -> bool {
        let shape = ModelShape::of(&Walk);
        let config = AmortisedConfig::gaussian();
        let proposal =
            Amortised::create(&config, &shape, 0, Backend::Native.into(), &Seed::from_u64(1)).unwrap();
        let few = LearnConfig { sequences: 8, horizon: 5, ..LearnConfig::new() };
        let rows = |seed: &Seed| drawn(&proposal, &Walk, &few, seed).unwrap().examples.later;
        let (held_out, mut one, mut other) = (rows(validation), Stage::default(), Stage::default());
        (0..3).any(|supply| {
            let learned = rows(&training.nth(supply));
            (0..held_out.len()).any(|at| {
                one.pick(&held_out, &[at]);
                (0..learned.len()).any(|row| {
                    other.pick(&learned, &[row]);
                    one == other
                })
            })
        })
    }

    #[test]
    fn no_row_that_is_judged_by_is_learned_from() {
        let seed = Seed::from_u64(7);
        assert!(!leaks(&for_validation(&seed), &for_training(&seed)));
    }

    #[test]
    fn validation_sequences_that_were_trained_on_are_caught() {
        let seed = Seed::from_u64(7);
        // The bug: validation takes a supply of training.
        assert!(leaks(&for_training(&seed).nth(1), &for_training(&seed)));
    }
}
