//! Drawing series from a model.

use std::ops::ControlFlow;
use std::slice::from_mut;

use motes_formulas::Schedule;
use motes_models::batch::{Rows, there_is_memory_for};
use motes_models::{
    Measurements, ModelError, Seed, Sequence, Simulator, StepRecord, Stream, Trajectory, check_model,
};

use crate::data::Data;
use crate::error::MotesError;
use crate::fitting::FitParameters;
use crate::model::{Kind, Model};
use crate::priors;
use crate::simulation_failure::SimulationFailure;
use crate::simulation_plan::{Plan, names, plans_along};
use crate::timeline::{Clock, RowTime, Timeline, TimelineError};

/// Series of states and measurements that a model drew.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Simulated {
    /// The name of each: its number, or that of the series of data that it goes along.
    pub names: Vec<String>,
    /// One after another.
    pub series: Vec<Trajectory>,
    /// Of each series, its rows beside states and measurements.
    pub rows: Vec<Vec<SimulatedRow>>,
    /// For each series, the parameters that were drawn for it; empty where none were.
    pub parameters: Vec<Vec<(String, f64)>>,
}

/// A row of a series that was drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedRow {
    /// The steps that lead to it; all but the last have no measurement.
    pub steps: Vec<StepRecord>,
    /// What its time is called, where data were given with such a column.
    pub label: Option<String>,
    /// What the columns say that inputs come from ([`Model::input_columns`]).
    pub inputs: Vec<Option<f64>>,
}

impl SimulatedRow {
    /// Its time.
    pub fn time(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.step().time)
    }
}

/// Draws `series` series of `steps` rows each. One series is the same whatever others there are. `proceed` is asked now and then, with how many series
/// are done.
///
/// # Errors
/// [`MotesError::Simulation`] where states overflow, with how many series do; [`MotesError::Setting`] if there is no memory for them;
/// [`MotesError::Timeline`] if the model has inputs that it does not simulate; [`MotesError::Interrupted`] if `proceed` said to stop.
pub fn simulate(
    model: &Model,
    steps: usize,
    series: usize,
    seed: u64,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    simulate_all(model, &vec![Plan::Rows(steps); series], seed, &Parameters::Given, &mut proceed)
}

/// Refuses a model whose measurements have densities, but cannot be drawn.
///
/// # Errors
/// [`MotesError::Simulation`] names the line.
pub(crate) fn check_draws(model: &Model) -> Result<(), MotesError> {
    let Some(formulas) = model.formulas() else { return Ok(()) };
    formulas.can_be_simulated().map_err(|error| MotesError::Simulation(error.to_string()))
}

/// Draws series as [`simulate`], or as [`simulate_along`] where there are times and inputs, but that parameters that have a prior, and were not set from outside, are drawn
/// anew for each series.
///
/// # Errors
/// As [`simulate`], and [`MotesError::Setting`] if no parameter has a prior, [`MotesError::Model`] if the file is no model with what was drawn.
pub fn simulate_from_priors(
    model: &Model,
    inputs: Option<&Data>,
    steps: usize,
    series: usize,
    seed: u64,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    if model.priors().is_empty() {
        let reason = "--prior: no parameter of the model has a prior, as in q = \"half_normal(1)\"";
        return Err(MotesError::Setting(reason.to_string()));
    }
    let plans = inputs.map_or_else(|| vec![Plan::Rows(steps); series], |inputs| plans_along(inputs, series));
    simulate_all(model, &plans, seed, &Parameters::Prior, &mut proceed)
}

/// Draws `series` series at the times and with the inputs of each series of `data`, whose measurements play no part.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_along(
    model: &Model,
    data: &Data,
    series: usize,
    seed: u64,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    simulate_all(model, &plans_along(data, series), seed, &Parameters::Given, &mut proceed)
}

/// Draws series as [`simulate_from_priors`], but that parameters are those of draws of a fit, evenly spread over all of them.
///
/// # Errors
/// As [`simulate_from_priors`].
pub fn simulate_from_draws(
    model: &Model,
    draws: &FitParameters,
    inputs: Option<&Data>,
    steps: usize,
    series: usize,
    seed: u64,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    let plans = inputs.map_or_else(|| vec![Plan::Rows(steps); series], |inputs| plans_along(inputs, series));
    simulate_all(model, &plans, seed, &Parameters::Posterior(draws), &mut proceed)
}

/// Where the parameters of a series come from.
enum Parameters<'a> {
    /// They are those of the model.
    Given,
    /// Those that have a prior are drawn from it.
    Prior,
    /// They are draws of a fit.
    Posterior(&'a FitParameters),
}

fn simulate_all(
    model: &Model,
    plans: &[Plan<'_>],
    seed: u64,
    parameters: &Parameters<'_>,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Simulated, MotesError> {
    check_draws(model)?;
    let width = model.states().len() + model.measurements().len() + model.input_columns().len();
    let times = plans.iter().try_fold(0_usize, |sum, plan| sum.checked_add(plan.len()));
    let numbers = times.and_then(|times| times.checked_mul(width));
    let series = plans.len();
    // Each number is text of some twenty letters later on.
    if !numbers.and_then(|numbers| numbers.checked_mul(4)).is_some_and(there_is_memory_for) {
        let steps = plans.first().map_or(0, Plan::len);
        let reason =
            format!("{series} series of {steps} times are more than there is memory for; take fewer");
        return Err(MotesError::Setting(reason));
    }
    let seed = Seed::from_u64(seed).child("simulate");
    let names = names(plans);
    let mut drawn = Simulated::default();
    let (mut first, mut failures) = (None, 0);
    for (number, plan) in plans.iter().enumerate() {
        let mut stream = seed.nth(number as u64).stream();
        let values = match parameters {
            Parameters::Given => None,
            Parameters::Prior => Some(priors::drawn(model, &seed.child("priors").nth(number as u64))),
            Parameters::Posterior(draws) => Some(draws.draw((2 * number + 1) * draws.len() / (2 * series))),
        };
        let own = values.as_ref().map(|values| model.with_parameters(values)).transpose()?;
        drawn.parameters.extend(values);
        let model = own.as_ref().unwrap_or(model);
        match draw_one(model, *plan, &mut stream, &mut || proceed(number)) {
            Ok(Some((trajectory, rows))) => {
                drawn.names.push(names[number].clone());
                drawn.series.push(trajectory);
                drawn.rows.push(rows);
            }
            Ok(None) => return Err(MotesError::Interrupted),
            Err(SimulationFailure::NotFinite { time, reason }) => {
                failures += 1;
                first.get_or_insert((number, time, reason));
            }
            Err(failure) => return Err(failure.into()),
        }
        if proceed(number + 1).is_break() {
            return Err(MotesError::Interrupted);
        }
    }
    match first {
        None => Ok(drawn),
        Some((number, time, reason)) => Err(MotesError::Simulation(format!(
            "{failures} of {series} series run to numbers that are not finite, series {number} at t = {time}: {reason}; take fewer steps, or \
             look at the transition's noise and at formulas that grow"
        ))),
    }
}

/// Draws `series` series of `steps` rows, or with the times and inputs of the series of `data`, one after the other, where the model has such; those that run to numbers that are not finite are left out.
///
/// # Errors
/// [`MotesError::Simulation`] if none is left, and as [`simulate`].
pub(crate) fn simulate_some(
    model: &Model,
    data: Option<&Data>,
    steps: usize,
    series: usize,
    seed: &Seed,
) -> Result<Simulated, MotesError> {
    let data = data.filter(|_| model.timeline().is_some());
    let plan = |number: usize| match data {
        Some(data) => Plan::Like(data, number % data.series.len()),
        None => Plan::Rows(steps),
    };
    let mut drawn = Simulated::default();
    for number in 0..series {
        let mut stream = seed.nth(number as u64).stream();
        match draw_one(model, plan(number), &mut stream, &mut || ControlFlow::Continue(())) {
            Ok(None) | Err(SimulationFailure::Model(_) | SimulationFailure::NotFinite { .. }) => {}
            Ok(Some((trajectory, rows))) => {
                drawn.names.push(number.to_string());
                drawn.series.push(trajectory);
                drawn.rows.push(rows);
            }
            Err(failure) => return Err(failure.into()),
        }
    }
    match drawn.series.is_empty() {
        true => Err(MotesError::Simulation(format!(
            "all of {series} series of {steps} times run to numbers that are not finite; take fewer steps, or look at the transition's noise"
        ))),
        false => Ok(drawn),
    }
}

/// A series, or none where `proceed` said to stop.
fn draw_one(
    model: &Model,
    plan: Plan<'_>,
    stream: &mut Stream,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<(Trajectory, Vec<SimulatedRow>)>, SimulationFailure> {
    match model.kind() {
        Kind::Learnable(learnable) => draw_rows(model, learnable, plan, stream, proceed),
        Kind::LinearGaussian(linear) => draw_rows(model, linear, plan, stream, proceed),
    }
}

/// Rows between two of which it is asked whether to go on.
const ASKS_EVERY: usize = 1024;

fn draw_rows(
    model: &Model,
    simulator: &(impl Simulator + ?Sized),
    plan: Plan<'_>,
    stream: &mut Stream,
    proceed: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<Option<(Trajectory, Vec<SimulatedRow>)>, SimulationFailure> {
    check_model(simulator)?;
    let (n, m, count) = (simulator.state_dim(), simulator.measurement_dim(), plan.len());
    let (mut states, mut measurements) = (Vec::with_capacity(count * n), vec![0.0; count * m]);
    let mut rows = Vec::with_capacity(count);
    let (mut before, mut state) = (vec![0.0; n], vec![0.0; n]);
    let mut course = Course::of(model, plan);
    for (time, measurement) in measurements.chunks_exact_mut(m).enumerate() {
        if time % ASKS_EVERY == ASKS_EVERY - 1 && proceed().is_break() {
            return Ok(None);
        }
        let row = course.next(stream)?;
        for record in &row.steps {
            let step = record.step();
            before.copy_from_slice(&state);
            let previous = (step.index > 0).then(|| Rows::all(&before, n));
            simulator.sample_states(&step, previous, from_mut(stream), &mut state);
        }
        let last = row.steps.last().cloned().unwrap_or_default();
        simulator.sample_measurements(&last.step(), &state, from_mut(stream), measurement);
        if !state.iter().chain(measurement.iter()).all(|value| value.is_finite()) {
            let step = last.step();
            let previous = (step.index > 0).then_some(before.as_slice());
            let explained =
                model.formulas().and_then(|formulas| formulas.explain(&step, previous, Some(&state)));
            let reason = match explained {
                Some(error) => error.to_string(),
                None => format!("the state is {state:?}, the measurement {measurement:?}"),
            };
            return Err(SimulationFailure::NotFinite { time: step.time, reason });
        }
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        model.measured(&mut course.clock, &entries)?;
        states.extend_from_slice(&state);
        rows.push(row);
    }
    if rows.is_empty() {
        let (name, value, expected) = ("horizon T", "0".into(), "at least 1");
        return Err(ModelError::Parameter { name, value, expected }.into());
    }
    let trajectory =
        Trajectory { states: Sequence::new(n, states)?, measurements: Measurements::new(m, measurements)? };
    Ok(Some((trajectory, rows)))
}

/// The steps of a series of so many rows, or those of all series of `data`, with their times and inputs: those of many simulations at once.
///
/// # Errors
/// [`MotesError::Timeline`] as [`simulate`], and [`MotesError::Setting`] if inputs are measurements, which each simulation has its own of.
pub(crate) fn schedule(
    model: &Model,
    data: Option<&Data>,
    rows: usize,
    seed: &Seed,
) -> Result<Option<Schedule>, MotesError> {
    if model.timeline().is_none() {
        return Ok(None);
    }
    if let Some(column) = model.fed_back_measurement() {
        let reason = format!(
            "the measurement {column} is an input of later steps: each simulation has its own, and a proposal cannot be learned from many at once"
        );
        return Err(MotesError::Setting(reason));
    }
    let steps = |plan: Plan<'_>| -> Result<Vec<StepRecord>, MotesError> {
        let (mut course, mut stream) = (Course::of(model, plan), seed.child("inputs").stream());
        let mut steps = Vec::new();
        for _ in 0..plan.len() {
            steps.extend(course.next(&mut stream).map_err(SimulationFailure::Timeline)?.steps);
        }
        Ok(steps)
    };
    match data {
        None => Ok(Schedule::endless(steps(Plan::Rows(rows))?)),
        Some(data) => {
            let sequences = (0..data.series.len()).map(|series| steps(Plan::Like(data, series)));
            Ok(Schedule::of_sequences(sequences.collect::<Result<_, _>>()?))
        }
    }
}

/// The rows of a series, one after another.
struct Course<'a> {
    model: &'a Model,
    clock: Clock,
    /// The rows of the data that it goes along.
    along: Option<Box<dyn Iterator<Item = &'a crate::data::Row> + 'a>>,
    /// Where cells of inputs that are blank have the value of the row before: what that was.
    known: Option<Vec<f64>>,
}

/// The first value of each column of inputs in a series; 0 of one that has none, by which nothing is measured.
fn first_known(data: &Data, series: usize) -> Vec<f64> {
    let columns = data.of_series(series).next().map_or(0, |row| row.inputs.len());
    let first = |column: usize| data.of_series(series).find_map(|row| row.inputs[column]);
    (0..columns).map(|column| first(column).unwrap_or(0.0)).collect()
}

impl<'a> Course<'a> {
    fn of(model: &'a Model, plan: Plan<'a>) -> Self {
        let (name, along): (&str, Option<Box<dyn Iterator<Item = &crate::data::Row>>>) = match plan {
            Plan::Rows(_) => ("", None),
            Plan::Along(data, series) | Plan::Like(data, series) => {
                (&data.series[series], Some(Box::new(data.of_series(series))))
            }
        };
        let known = match plan {
            Plan::Like(data, series) => Some(first_known(data, series)),
            _ => None,
        };
        Course { model, clock: Clock::of_series(name), along, known }
    }

    /// The next row.
    ///
    /// # Errors
    /// [`TimelineError`] if an input is not simulated, or not known at the row's time.
    fn next(&mut self, stream: &mut Stream) -> Result<SimulatedRow, TimelineError> {
        let row = self.along.as_mut().and_then(Iterator::next);
        let Some(timeline) = self.model.timeline() else {
            let nothing = RowTime { label: None, columns: &[] };
            let steps = self.model.next_steps(&mut self.clock, nothing)?;
            return Ok(SimulatedRow { steps, label: row.and_then(|row| row.label.clone()), inputs: vec![] });
        };
        match row {
            Some(row) => {
                let label = row.label.clone();
                let time = row.written_time.as_deref();
                // A row whose measurement is missing needs no input of it, but each simulation has all measurements.
                let filled: Option<Vec<Option<f64>>> = self.known.as_mut().map(|known| {
                    let of = |(known, cell): (&mut f64, &Option<f64>)| {
                        *known = cell.unwrap_or(*known);
                        Some(*known)
                    };
                    known.iter_mut().zip(&row.inputs).map(of).collect()
                });
                let columns = filled.as_ref().unwrap_or(&row.inputs);
                let steps = self.clock.next(timeline, RowTime { label: time, columns })?;
                self.clock.check_measurable()?;
                Ok(SimulatedRow { steps, label, inputs: row.inputs.clone() })
            }
            None => self.simulated(timeline, stream),
        }
    }

    /// The next row, with inputs that are drawn.
    fn simulated(&mut self, timeline: &Timeline, stream: &mut Stream) -> Result<SimulatedRow, TimelineError> {
        /// The time between two rows.
        const GAP: f64 = 1.0;
        let inputs = timeline.simulated_columns(self.clock.time_after(timeline, GAP), stream)?;
        let steps = self.clock.next_after(timeline, GAP, &inputs)?;
        let label = self.clock.label_of_last(timeline).filter(|_| timeline.has_dates());
        Ok(SimulatedRow { steps, label, inputs })
    }
}
