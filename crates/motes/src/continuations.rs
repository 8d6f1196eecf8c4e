//! Simulated continuations of a series whose measurements are inputs of later steps.

use std::slice::from_mut;

use motes_models::batch::Rows;
use motes_models::{Marginal, Seed, Simulator, Stream};
use motes_smc::{LogWeights, Predictive, Resampling};

use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate, Forecast};
use crate::model::{Kind, Model};
use crate::simulating::check_draws;
use crate::timeline::{Clock, RowTime, TimelineError};

/// How many continuations there are: quantiles of 5 and 95 % are those of fifty.
const COUNT: usize = 1000;

/// Continuations of a series after its last row: each draws measurements of its own, which are its inputs from then on.
pub(crate) struct Continuations {
    paths: Vec<Path>,
}

/// One continuation.
struct Path {
    state: Vec<f64>,
    clock: Clock,
    stream: Stream,
}

impl Continuations {
    /// Those from weighted particles (`K×N` and `K`) after the row where `clock` stands; none of a model whose forecasts do not need them, or whose measurements cannot be drawn.
    pub(crate) fn of(
        model: &Model,
        (states, weights): (&[f64], &[f64]),
        clock: &Clock,
        seed: &Seed,
    ) -> Option<Self> {
        model.fed_back_measurement()?;
        check_draws(model).ok()?;
        let mut ancestors = vec![0; COUNT];
        Resampling::Systematic.draw(weights, &mut seed.child("ancestors").stream(), &mut ancestors);
        let n = model.states().len();
        let path = |(number, ancestor): (usize, &usize)| Path {
            state: states[ancestor * n..][..n].to_vec(),
            clock: clock.clone(),
            stream: seed.nth(number as u64).stream(),
        };
        Some(Continuations { paths: ancestors.iter().enumerate().map(path).collect() })
    }

    /// Goes on to the next row, one with this time and these inputs, or a gap as the last one ahead, and says what is expected there, with quantiles at these probabilities. A measurement that
    /// the row gives is the input of later steps in all of them.
    ///
    /// # Errors
    /// [`MotesError::Ahead`] if an input is not known then, [`MotesError::Simulation`] where a continuation runs to numbers that are not finite.
    pub(crate) fn next(
        &mut self,
        model: &Model,
        row: Option<RowTime<'_>>,
        probabilities: &[f64],
    ) -> Result<Forecast, MotesError> {
        match model.kind() {
            Kind::Learnable(simulator) => self.next_of(model, simulator, row, probabilities),
            Kind::LinearGaussian(simulator) => self.next_of(model, simulator, row, probabilities),
        }
    }

    fn next_of(
        &mut self,
        model: &Model,
        simulator: &(impl Simulator + ?Sized),
        row: Option<RowTime<'_>>,
        probabilities: &[f64],
    ) -> Result<Forecast, MotesError> {
        let ahead = |error| MotesError::Ahead(Box::new(error));
        let (n, m) = (simulator.state_dim(), simulator.measurement_dim());
        let (nothing, mut before) = (vec![None; m], vec![0.0; n]);
        let mut marginals = Vec::with_capacity(self.paths.len() * m);
        let mut time = 0.0;
        for Path { state, clock, stream } in &mut self.paths {
            let steps = model.steps_ahead(clock, row).map_err(ahead)?;
            for record in &steps {
                before.copy_from_slice(state);
                let previous = Some(Rows::all(&before, n));
                simulator.sample_states(&record.step(), previous, from_mut(stream), state);
            }
            let last = steps.last().cloned().unwrap_or_default();
            time = last.step().time;
            if let Some(input) = model.unknown_input(&last.step()) {
                return Err(ahead(TimelineError::Ahead { input }));
            }
            let mut of_path = vec![Marginal::of_draw(f64::NAN, None); m];
            simulator.marginals(&last.step(), state, &nothing, stream, &mut of_path);
            let drawn: Vec<f64> = of_path.iter().map(|marginal| marginal.drawn).collect();
            if !state.iter().chain(&drawn).all(|value| value.is_finite()) {
                let reason =
                    format!("a continuation of the series runs to numbers that are not finite at t = {time}");
                return Err(MotesError::Simulation(reason));
            }
            let given = row.map_or(vec![], |row| model.measurements_of(row));
            let entry = |(entry, drawn): (usize, &f64)| given.get(entry).copied().flatten().or(Some(*drawn));
            let entries: Vec<Option<f64>> = drawn.iter().enumerate().map(entry).collect();
            model.measured(clock, &entries).map_err(ahead)?;
            marginals.extend(of_path);
        }
        let weights = LogWeights::uniform(self.paths.len());
        let expected =
            |marginals: Vec<Marginal>| Predictive::of_marginals(&weights, marginals, None, probabilities);
        let of_coordinate = |at: usize| {
            let values = self.paths.iter().map(|path| Marginal::of_draw(path.state[at], None));
            let Predictive { mean, sd, quantiles, .. } = expected(values.collect());
            Coordinate { mean, sd, quantiles }
        };
        let of_entry = |entry: usize| expected(marginals.iter().skip(entry).step_by(m).copied().collect());
        let estimate = Estimate {
            state: (0..n).map(of_coordinate).collect(),
            ess: None,
            log_evidence: None,
            predictive: (0..m).map(of_entry).collect(),
        };
        // All of them are at the same row.
        let clock = self.paths.first().map(|path| &path.clock);
        Ok(model.forecast(clock, row, time, estimate))
    }
}
