//! Runs of look-ahead filters, and exact values that they are held against.

use motes_models::batch::LANES;
use motes_models::equations::{Equations, NoiseSpace};
use motes_models::{Seed, Step, StepRecord, simulate};
use motes_smc::{FilterBank, FilterSettings, LookAhead, Proposal, RecordedStep, ResampleWhen, Resampling};

/// Rows a unit of time apart, with one measurement each.
pub fn recorded(measurements: impl Iterator<Item = Option<f64>>) -> Vec<RecordedStep> {
    let row = |(index, measurement): (usize, Option<f64>)| RecordedStep {
        step: StepRecord::of(&Step::of_index(index)),
        measurement: vec![measurement],
    };
    measurements.enumerate().map(row).collect()
}

/// Simulated rows of a model, of which one in five is missing.
pub fn rows(model: &impl Equations, times: usize, seed: u64) -> Vec<RecordedStep> {
    let data = simulate(model, times, &mut Seed::from_u64(seed).stream()).unwrap();
    let measured: Vec<f64> = data.measurements.rows().map(|row| row[0]).collect();
    recorded(measured.into_iter().enumerate().map(|(t, y)| (t % 5 != 3).then_some(y)))
}

/// Settings of all filters here.
pub fn settings(particles: usize, share: Option<f64>) -> FilterSettings {
    FilterSettings {
        particles,
        resampling: Resampling::Systematic,
        resample_when: ResampleWhen::EssBelow(0.5),
        defensive_weight: share,
    }
}

/// The log-evidence of each of some filters with a proposal.
pub fn evidence_by<M: Equations, P: Proposal<M, Memory = ()> + Send>(
    model: &M,
    proposal: P,
    rows: &[RecordedStep],
    settings: FilterSettings,
    runs: usize,
    seed: u64,
) -> Vec<f64> {
    let seed = Seed::from_u64(seed);
    let mut bank = FilterBank::new(model, proposal, settings, runs, &seed).unwrap().keeping_collapsed();
    for RecordedStep { step, measurement } in rows {
        bank.step_at(&step.step(), measurement).unwrap();
    }
    (0..runs).map(|run| bank.log_evidence(run)).collect()
}

/// The same of filters that look ahead.
pub fn evidence_of_runs(
    model: &impl Equations,
    rows: &[RecordedStep],
    particles: usize,
    runs: usize,
    share: Option<f64>,
) -> Vec<f64> {
    let ahead = LookAhead::new(model, rows).unwrap();
    evidence_by(model, ahead, rows, settings(particles, share), runs, 11)
}

/// Mean and variance.
pub fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

/// By how many standard errors the mean of `ẑ/z` is off 1.
pub fn bias(found: &[f64], exact: f64) -> f64 {
    let ratios: Vec<f64> = found.iter().map(|log| (log - exact).exp()).collect();
    let (mean, variance) = moments(&ratios);
    (mean - 1.0) / (variance / found.len() as f64).sqrt()
}

/// The log-evidence of a linear Gaussian model with one measurement, `y = x_0 + w` with noise of the standard deviation that the model says, from the joint Gaussian of all measurements:
/// each is a linear map of all noise, which is read off by unit vectors.
pub fn gaussian_evidence<M: Equations>(model: &M, rows: &[RecordedStep]) -> f64 {
    let draws = |step: &Step<'_>| if step.sub_steps == 0 { 0 } else { model.draws(step).len() };
    let counts: Vec<usize> = rows.iter().map(|row| draws(&row.step.step())).collect();
    let total: usize = counts.iter().sum();
    // The first coordinate at each step where one number of noise is 1.
    let response = |which: Option<usize>| -> Vec<f64> {
        let [n, _] = model.dimensions();
        let (mut before, mut first, mut begin) = (vec![0.0; n * LANES], Vec::new(), 0);
        for (row, count) in rows.iter().zip(&counts) {
            let noise: Vec<f64> = (begin..begin + count)
                .flat_map(|at| [if Some(at) == which { 1.0 } else { 0.0 }; LANES])
                .collect();
            let step = row.step.step();
            let mut now = vec![0.0; n * LANES];
            let previous = (step.index > 0).then_some(before.as_slice());
            model.tile_states(&step, previous, &noise, &mut now);
            first.push(now[0]);
            (before, begin) = (now, begin + count);
        }
        first
    };
    let mean = response(None);
    let columns: Vec<Vec<f64>> = (0..total)
        .map(|which| response(Some(which)).iter().zip(&mean).map(|(x, mean)| x - mean).collect())
        .collect();
    let known: Vec<usize> = (0..rows.len()).filter(|at| rows[*at].measurement[0].is_some()).collect();
    // The variance of the measurement's noise, from its density at its mean.
    let probe = [Some(0.0)];
    let mut density = [0.0];
    let mut state = vec![0.0; model.dimensions()[0]];
    state[0] = 0.0;
    motes_models::StateSpaceModel::log_likelihoods(model, &rows[0].step.step(), &state, &probe, &mut density)
        .unwrap();
    let variance = (-2.0 * density[0]).exp() / std::f64::consts::TAU;
    let count = known.len();
    let covariance = faer::Mat::from_fn(count, count, |i, j| {
        let sum: f64 = columns.iter().map(|column| column[known[i]] * column[known[j]]).sum();
        if i == j { sum + variance } else { sum }
    });
    let lower = covariance.llt(faer::Side::Lower).unwrap().L().to_owned();
    let mut log = -0.5 * count as f64 * std::f64::consts::TAU.ln();
    let mut solved = vec![0.0; count];
    for i in 0..count {
        let rest = rows[known[i]].measurement[0].unwrap() - mean[known[i]];
        let sum: f64 = (0..i).map(|k| lower[(i, k)] * solved[k]).sum();
        solved[i] = (rest - sum) / lower[(i, i)];
        log -= 0.5 * solved[i] * solved[i] + lower[(i, i)].ln();
    }
    log
}
