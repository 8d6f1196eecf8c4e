//! Smoothing all series of some data by backward simulation.

use std::ops::ControlFlow;

use motes_models::{Seed, StepRecord};
use motes_smc::{DENSITIES_PER_MOVE, FilterHistory, SmoothedPaths, SmoothingError};

use crate::data::Data;
use crate::error::MotesError;
use crate::estimate::{Coordinate, Estimate};
use crate::exact::smooth_exactly;
use crate::few_ancestors::of_paths;
use crate::filtered::Filtered;
use crate::filtering::{measured, of_proposal};
use crate::known_inputs::all_known;
use crate::long_step::of_step;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};
use crate::priors::of_starts;
use crate::recorded::running_over;
use crate::tally::{SeriesTally, Tally};

/// What smoothers made of data.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// The estimate of each row of the data given all rows of its series, in their order. Where all trajectories of a series pass through one particle,
    /// standard deviations and quantiles are NaN ([`SmoothedPaths::standard_deviation`]).
    pub estimates: Vec<Estimate>,
    /// The trajectories of each series.
    pub paths: Vec<SmoothedPaths>,
    /// What the filters said on the way, without their estimates; and a warning where trajectories pass through a few particles
    /// ([`SmoothedPaths::distinct_particles`]).
    pub filtered: Filtered,
}

/// Filters each series of `data` and draws `paths` trajectories of it backwards ([`motes_smc::backward_simulation`]). `proceed` is asked after each row of
/// either pass, and now and then, with the share of the whole work that is done, from 0 to 1.
///
/// # Errors
/// As [`crate::filter`]; [`MotesError::Setting`] if what filters were cannot be kept.
pub fn smooth(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    paths: usize,
    mut proceed: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<Smoothed, MotesError> {
    smooth_until(model, data, options, paths, true, &mut proceed)
}

/// [`smooth`], compiled once whatever asks. Few paths of one draw of parameters pass through few particles, and are not `judged` alone: all draws have particles of their own.
pub(crate) fn smooth_until(
    model: &Model,
    data: &Data,
    options: &FilterOptions,
    paths: usize,
    are_judged: bool,
    proceed: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Smoothed, MotesError> {
    let mut estimates: Vec<Option<Estimate>> = vec![None; data.rows.len()];
    let mut tally = Tally::new(
        of_starts(model)
            .into_iter()
            .chain(of_proposal(model, options))
            .chain(of_step(model, data))
            .chain(data.warnings())
            .collect(),
    );
    let mut drawn = vec![];
    let nothing = vec![None; model.measurements().len()];
    let mut work = Work::of(data.rows.len(), options.particles, paths);
    for (series, (name, places)) in data.series.iter().zip(data.by_series()).enumerate() {
        let name = data.columns.has_series().then_some(name.as_str());
        let mut running = running_over(model, options, series, data, &places)?;
        let (mut of_this, mut history) = (SeriesTally::new(model, options), FilterHistory::new());
        for &at in &places {
            let row = &data.rows[at];
            for (number, step) in row.steps.iter().enumerate() {
                let is_last = number + 1 == row.steps.len();
                let measurement = if is_last { &row.measurement } else { &nothing };
                let advanced = running.take_step(&step.step(), measurement);
                advanced.map_err(|error| error.at_row(&data.source, name, row.line))?;
                running.record(&mut history)?;
            }
            tally.step(&mut of_this, &row.steps, &row.measurement, running.diagnosis().as_ref());
            work.filtered += 1;
            if proceed(work.share(0)).is_break() {
                return Err(MotesError::Interrupted);
            }
        }
        let before = data.steps_before(series);
        let measured = |step: usize| measured(model, data, places[step.saturating_sub(before)]);
        tally.end_series(name, &of_this, &running, measured);
        let seed = Seed::from_u64(options.seed).child("smooth").nth(series as u64);
        let (of_times, found) = if options.proposal == ProposalName::Exact {
            let rows: Vec<&[Option<f64>]> =
                places.iter().map(|at| data.rows[*at].measurement.as_slice()).collect();
            let known: Vec<Vec<StepRecord>> =
                places.iter().map(|at| all_known(&data.rows[*at].steps)).collect();
            let steps: Vec<&[StepRecord]> = known.iter().map(Vec::as_slice).collect();
            let asked = (paths, &options.quantiles);
            smooth_exactly(model, &steps, &rows, asked, &seed, &mut || proceed(work.share(0)))?
        } else {
            let found = running.backward(&history, paths, &seed, &mut |times| proceed(work.share(times)))?;
            let found = found.without_first(before);
            let label = |time: usize| places.get(time).and_then(|at| data.rows[*at].label.as_deref());
            tally.warn(of_paths(name, &found, options.particles, label).filter(|_| are_judged));
            let (n, probabilities) = (model.states().len(), options.quantiles.probabilities());
            ((0..places.len()).map(|time| estimate(&found, time, n, probabilities)).collect(), found)
        };
        work.drawn += places.len();
        places.into_iter().zip(of_times).for_each(|(at, estimate)| estimates[at] = Some(estimate));
        drawn.push(found);
    }
    let filtered = tally.into_filtered(vec![], vec![]);
    Ok(Smoothed { estimates: estimates.into_iter().flatten().collect(), paths: drawn, filtered })
}

/// How far a smoother is, in units of a particle's step: the proposal of an ancestor takes about as long. Time left is foretold by it.
struct Work {
    rows: usize,
    filtered: usize,
    drawn: usize,
    /// What a row of the data costs in either pass.
    costs: [f64; 2],
}

impl Work {
    fn of(rows: usize, particles: usize, paths: usize) -> Self {
        let costs = [particles as f64, paths as f64 * DENSITIES_PER_MOVE as f64];
        Work { rows, filtered: 0, drawn: 0, costs }
    }

    /// The share of the work that is done when `more` rows are drawn besides those of whole series.
    fn share(&self, more: usize) -> f64 {
        let [filter, draw] = self.costs;
        let done = filter * self.filtered as f64 + draw * (self.drawn + more) as f64;
        done / ((filter + draw) * self.rows as f64)
    }
}

/// What trajectories say of one time.
fn estimate(paths: &SmoothedPaths, time: usize, n: usize, probabilities: &[f64]) -> Estimate {
    let of_coordinate = |coordinate| Coordinate {
        mean: paths.mean(time, coordinate),
        sd: paths.standard_deviation(time, coordinate),
        quantiles: paths.quantiles(time, coordinate, probabilities),
    };
    Estimate::of_state((0..n).map(of_coordinate).collect())
}

impl From<SmoothingError> for MotesError {
    fn from(error: SmoothingError) -> Self {
        match error {
            SmoothingError::Interrupted => MotesError::Interrupted,
            error => MotesError::Setting(error.to_string()),
        }
    }
}
