//! The sequences that proposals are learned from and judged on, where they are recorded.

use std::ops::ControlFlow;

use motes::models::{Step, StepRecord};
use motes::output::simulated_table;
use motes::{Data, Model, MotesError, simulate};

use super::plan::BenchmarkPlan;

/// Recorded sequences, cut in two.
pub(super) struct Parts {
    /// What is learned from.
    pub(super) earlier: Data,
    /// What all are judged on.
    pub(super) later: Data,
}

/// Seeds of what is drawn to be learned from and to be judged on: neither is that of other simulations of the run.
const DRAWN: [u64; 2] = [1_000_003, 2_000_003];

/// The recorded sequences of a plan; none where all are judged on the model's own simulations.
pub(super) fn parts(plan: &BenchmarkPlan, model: &Model) -> Result<Option<Parts>, MotesError> {
    let Some(recorded) = &plan.benchmark.recorded else { return Ok(None) };
    if let Some(file) = &recorded.data {
        return Ok(Some(halves(&Data::open(&plan.home.join(file), model)?)));
    }
    let drawn_from = plan.model(&recorded.set)?;
    let draw = |sequences: usize, seed: u64| {
        let seed = plan.seed.wrapping_add(seed);
        let drawn =
            simulate(&drawn_from, plan.profile.times, sequences, seed, |_| ControlFlow::Continue(()))?;
        // States are columns that nobody reads.
        Ok::<Data, MotesError>(Data::read(
            simulated_table(&drawn_from, &drawn).as_bytes(),
            "simulated",
            model,
        )?)
    };
    let [earlier, later] = DRAWN;
    Ok(Some(Parts {
        earlier: draw(recorded.sequences, earlier)?,
        later: draw(plan.profile.sequences, later)?,
    }))
}

/// The first and the second half of each series, each beginning anew.
fn halves(data: &Data) -> Parts {
    let (mut earlier, mut later) =
        (Data { rows: Vec::new(), ..data.clone() }, Data { rows: Vec::new(), ..data.clone() });
    for series in data.by_series() {
        let half = series.len() / 2;
        for (place, at) in series.into_iter().enumerate() {
            let mut row = data.rows[at].clone();
            let part = if place < half { &mut earlier } else { &mut later };
            let index = if place < half { place } else { place - half };
            row.time = index as f64;
            row.steps = vec![StepRecord::of(&Step::of_index(index))];
            part.rows.push(row);
        }
    }
    Parts { earlier, later }
}
