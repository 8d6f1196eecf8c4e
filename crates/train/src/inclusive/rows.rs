//! Rows to learn from: simulated anew for each few steps, shuffled, used once.

use motes_models::{ModelError, OwnModel, OwnSteps, Seed, Stream};
use motes_proposals::{Amortised, Examples, Stage};
use rand::seq::SliceRandom;

use super::settings::LearnConfig;

/// Sequences whose first state alone is wanted, for each whole one.
const BEGINNINGS: usize = 8;

/// A supply of rows, and what became of the sequences that they come from.
pub(super) struct Supply {
    pub(super) examples: Examples,
    /// Sequences that overflowed before their end.
    pub(super) lost: usize,
    pub(super) sequences: usize,
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
    let mut whole = OwnSteps::new(model, sequences, &seed.child("sequences"))?;
    for _ in 0..config.horizon {
        match whole.advance() {
            Some(step) => proposal.encode(model, &step, &mut examples)?,
            None => break,
        }
    }
    let mut beginnings = OwnSteps::new(model, BEGINNINGS * sequences, &seed.child("beginnings"))?;
    if let Some(step) = beginnings.advance() {
        proposal.encode(model, &step, &mut examples)?;
    }
    Ok(Supply { examples, lost: whole.lost(), sequences })
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
