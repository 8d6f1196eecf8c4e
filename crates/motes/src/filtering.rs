//! Filtering all series of some data.

use std::ops::ControlFlow;

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::estimate::Estimate;
use crate::filtered::{Filtered, WeightedParticles};
use crate::learned_steps::of_sub_steps;
use crate::long_step::of_step;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::outside_prior::outside_of_learning;
use crate::priors::of_starts;
use crate::rows_ahead::{check_ahead, rows_ahead};
use crate::sight::of_blind;
use crate::tally::{SeriesTally, Tally, TimeLabel};
use crate::warning::Warning;

/// Filters each series of `data`; `proceed` is asked after each row, and after each time of a forecast, with how many rows are done.
///
/// # Errors
/// [`MotesError`] if an option is out of range, a filter failed, or `proceed` said to stop.
pub fn filter(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    mut proceed: impl FnMut(usize) -> ControlFlow<()>,
) -> Result<Filtered, MotesError> {
    filter_until(model, data, options, &mut proceed)
}

/// [`filter`], compiled once whatever asks.
fn filter_until(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    proceed: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Filtered, MotesError> {
    if options.keep_particles && options.proposal == ProposalName::Exact {
        let reason = "keep_particles: --proposal exact has no particles; leave one of the two out";
        return Err(MotesError::Setting(reason.into()));
    }
    check_ahead(options, data)?;
    let mut estimates: Vec<Option<Estimate>> = vec![None; data.rows.len()];
    let mut particles: Vec<Option<WeightedParticles>> = vec![None; data.rows.len()];
    let mut tally = Tally::new(
        of_starts(model)
            .into_iter()
            .chain(of_proposal(model, options))
            .chain(of_blind(model, Some(data), options))
            .chain(of_sub_steps(model, data, options))
            .chain(of_step(model, data))
            .chain(data.warnings())
            .collect(),
    );
    let (mut forecasts, mut done) = (vec![], 0);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = Running::new(model, options, series)?;
        let mut of_this = SeriesTally::new(model, options);
        for &at in &places {
            let row = &data.rows[at];
            let (estimate, diagnosis) = running
                .step_and_diagnose(&row.steps, &row.measurement)
                .map_err(|error| error.at_row(&data.source, name, row.line))?;
            tally.step(&mut of_this, &row.steps, &row.measurement, diagnosis.as_ref());
            estimates[at] = Some(estimate);
            particles[at] = options.keep_particles.then(|| running.weighted_particles()).flatten();
            done += 1;
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        let before = data.steps_before(series);
        let at = |step: usize| measured(model, data, places[step.saturating_sub(before)]);
        tally.end_series(name, &of_this, &running, at);
        let (mut forecast, mut clock) = (Vec::new(), data.clocks[series].clone());
        for row in rows_ahead(options, name, places.len())? {
            forecast.push(running.predict_by(&mut clock, row).map_err(|error| of_series(name, error))?);
            if proceed(done).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        tally.warn(running.forecast_warning(name));
        forecasts.push(forecast);
    }
    let filtered = tally.into_filtered(estimates.into_iter().flatten().collect(), forecasts);
    Ok(Filtered { particles: particles.into_iter().flatten().collect(), ..filtered })
}

/// What was measured in a row of data.
pub(crate) fn measured(model: &Model, data: &Data, row: usize) -> TimeLabel {
    let row = &data.rows[row];
    let values = model.measurements().iter().zip(&row.measurement);
    let values = values.filter_map(|(name, value)| value.map(|value| (name.clone(), value)));
    TimeLabel { time: Some(row.time), label: row.label.clone(), values: values.collect() }
}

/// What is to be said of the proposal itself, whatever the data are.
pub fn of_proposal(model: &Model, options: &FilterOptions) -> Vec<Warning> {
    let ProposalName::Learned(learned) = &options.proposal else { return vec![] };
    let worse = learned.notes().worse_than.as_ref().map(|designed| {
        let text = format!(
            "--proposal {} did worse than {designed} on sequences of its own model when it was learned; take --proposal {designed}",
            learned.name()
        );
        Warning { series: None, text }
    });
    worse.into_iter().chain(outside_of_learning(model, &options.proposal)).collect()
}

/// Says which series an error is about.
pub(crate) fn of_series(name: Option<&str>, error: MotesError) -> MotesError {
    match (name, error) {
        (Some(name), MotesError::Filter { place, reason }) => {
            MotesError::Filter { place: format!("series {name}, {place}"), reason }
        }
        (_, error) => error,
    }
}
