//! Parameters from data: posteriors against sums over grids, what is refused, what goes on after it was stopped.

use std::ops::ControlFlow;
use std::path::Path;

use motes::inference::ParameterSummary;
use motes::models::equations::Scalar;
use motes::{
    Data, FilterOptions, FitFolder, FitOptions, FitRecord, FreeParameters, Model, MotesError, PosteriorFit,
    ProposalName, filter, filter_draws, fit, fit_from, log_evidence,
};

pub(crate) const NILE: &str = r#"
[parameters]
measurement_variance = "log_normal(log(10000), 1.5)"
level_variance = "log_normal(log(1000), 1.5)"
[initial]
level = "normal(1000, 1000)"
[transition]
level = "normal(level, sqrt(level_variance))"
[measurement]
flow = "normal(level, sqrt(measurement_variance))"
"#;

/// The first years of the Nile: enough to say something, few enough to be filtered in no time.
fn nile() -> (Model, Data) {
    let model = Model::parse(NILE, "nile", &[]).unwrap();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/nile.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let rows: Vec<&str> = text.lines().take(31).collect();
    let data = Data::read(rows.join("\n").as_bytes(), "nile.csv", &model).unwrap();
    (model, data)
}

fn never() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn fitted(model: &Model, data: &Data, options: &FitOptions) -> PosteriorFit {
    fit(model, data, options, &never, &mut |_| Ok(())).unwrap()
}

fn exact(model: &Model, data: &Data) -> f64 {
    let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
    log_evidence(model, data, &options, |_| never()).unwrap().value
}

/// Models on a grid over the prior, with the weights of the posterior, and `log p(y)`.
fn grid(model: &Model, data: &Data) -> (Vec<(Model, Vec<f64>, f64)>, f64) {
    let free = FreeParameters::of(model).unwrap();
    let (step, ends) = (0.1, 4.0);
    let side = (2.0 * ends / step) as usize;
    let mut found = Vec::new();
    for i in 0..=side {
        for j in 0..=side {
            let v = [i as f64 * step - ends, j as f64 * step - ends];
            let values = free.at(&v);
            let named: Vec<(String, f64)> = free.names().into_iter().zip(values.iter().copied()).collect();
            let at = model.with_parameters(&named).unwrap();
            let log_prior = -0.5 * (v[0] * v[0] + v[1] * v[1]) - motes::models::LN_2PI;
            let log_weight = exact(&at, data) + log_prior + 2.0 * step.ln();
            found.push((at, values, log_weight));
        }
    }
    let largest = found.iter().map(|(.., log)| *log).fold(f64::NEG_INFINITY, f64::max);
    let sum: f64 = found.iter().map(|(.., log)| (log - largest).exp()).sum();
    let log_marginal = largest + sum.ln();
    found.iter_mut().for_each(|(.., log)| *log = (*log - log_marginal).exp());
    (found, log_marginal)
}

/// Means and standard deviations on the grid.
fn moments(grid: &[(Model, Vec<f64>, f64)], at: usize) -> (f64, f64) {
    let mean: f64 = grid.iter().map(|(_, values, weight)| weight * values[at]).sum();
    let variance: f64 = grid.iter().map(|(_, values, weight)| weight * (values[at] - mean).powi(2)).sum();
    (mean, variance.sqrt())
}

fn agrees(fitted: &PosteriorFit, grid: &[(Model, Vec<f64>, f64)], log_marginal: f64) {
    for (at, summary) in fitted.parameters.iter().enumerate() {
        let (mean, sd) = moments(grid, at);
        // R̂ − 1 of eight half chains is about χ²₇/(2 · 7 · ESS/8) where they agree: of fewer effective draws it is above its gate now and then.
        assert!(summary.ess_bulk >= 1500.0 && summary.rhat < 1.01, "{summary:?}");
        assert!((summary.mean - mean).abs() < 4.0 * summary.mcse, "{summary:?} beside {mean} and {sd}");
        let squares: Vec<Vec<f64>> = fitted
            .of_parameter(at)
            .iter()
            .map(|chain| chain.iter().map(|value| (value - mean).powi(2)).collect())
            .collect();
        let of_squares = ParameterSummary::of(&squares).unwrap();
        let variance = sd * sd;
        assert!(
            (of_squares.mean - variance).abs() < 4.0 * of_squares.mcse,
            "{of_squares:?} beside {variance}"
        );
    }
    let found = fitted.marginal_likelihood.unwrap();
    assert!((found.log - log_marginal).abs() < 4.0 * found.standard_error, "{found:?} beside {log_marginal}");
}

/// Catches an evidence that is drawn anew for where a chain is, a prior that counts twice or not at all, and chains that share their random numbers.
#[test]
fn the_posterior_of_the_nile_is_that_of_a_grid_by_the_kalman_filter_and_by_particles() {
    let (model, data) = nile();
    let (grid, log_marginal) = grid(&model, &data);
    let exactly = fitted(&model, &data, &FitOptions { draws: Some(5000), ..FitOptions::default() });
    assert_eq!(exactly.proposal, "exact");
    agrees(&exactly, &grid, log_marginal);
    let proposal = Some(ProposalName::Bootstrap);
    let by_particles =
        fitted(&model, &data, &FitOptions { proposal, draws: Some(15_000), ..FitOptions::default() });
    assert_eq!(by_particles.proposal, "bootstrap");
    agrees(&by_particles, &grid, log_marginal);
    // Exact whatever the number of particles is.
    let few = FitOptions {
        proposal: Some(ProposalName::Bootstrap),
        particles: Some(by_particles.particles.div_ceil(2)),
        draws: Some(20_000),
        ..FitOptions::default()
    };
    agrees(&fitted(&model, &data, &few), &grid, log_marginal);
}

/// Catches a mixture that forgets how far draws are apart.
#[test]
fn a_filter_over_the_posterior_is_a_mixture_of_filters() {
    let (model, data) = nile();
    let (grid, _) = grid(&model, &data);
    let options = FilterOptions { proposal: ProposalName::Exact, forecast: 5, ..FilterOptions::default() };
    let fitted = fitted(&model, &data, &FitOptions { draws: Some(1000), ..FitOptions::default() });
    let draws: Vec<Model> = (0..200)
        .map(|at| {
            let values = fitted.values(at % 4, 5 * (at / 4));
            let named: Vec<(String, f64)> =
                fitted.names.iter().cloned().zip(values.iter().copied()).collect();
            model.with_parameters(&named).unwrap()
        })
        .collect();
    let mixed = filter_draws(&draws, &data, &options, &|_| never()).unwrap();
    let last = data.rows.len() - 1;
    let ([mut mean, mut square], mut parts) = ([0.0; 2], Vec::new());
    for (at, _, weight) in grid.iter().filter(|(.., weight)| *weight > 1e-7) {
        let found =
            filter(at, &data, &FilterOptions { check: false, ..options.clone() }, |_| never()).unwrap();
        let state = &found.forecasts[0][4].estimate.state[0];
        mean += weight * state.mean;
        square += weight * (state.sd * state.sd + state.mean * state.mean);
        parts.push((weight, state.mean, state.sd));
    }
    let sd = (square - mean * mean).sqrt();
    let state = &mixed.forecasts[0][4].estimate.state[0];
    assert!((state.mean - mean).abs() < 0.1 * sd, "{} beside {mean} ± {sd}", state.mean);
    assert!((state.sd / sd - 1.0).abs() < 0.1, "{} beside {sd}", state.sd);
    for (quantile, probability) in state.quantiles.iter().zip([0.05, 0.5, 0.95]) {
        let below = |(weight, mean, sd): &(&f64, f64, f64)| *weight * ((quantile - mean) / sd).normal_cdf();
        let found: f64 = parts.iter().map(below).sum();
        assert!((found - probability).abs() < 0.02, "{quantile} has {found} below it, not {probability}");
    }
    assert!(mixed.estimates[last].log_evidence.is_none());
}

#[test]
fn a_fit_that_was_stopped_goes_on_to_the_same_bytes() {
    let (model, data) = nile();
    let options = FitOptions { draws: Some(150), ..FitOptions::default() };
    let folder =
        |name: &Path| FitFolder::open(name, FitRecord::of(&model, &data, &options).unwrap()).unwrap();
    let home = tempfile::tempdir().unwrap();
    let (whole, parts) = (home.path().join("whole"), home.path().join("parts"));
    folder(&whole).finish(&fitted(&model, &data, &options)).unwrap();
    let files = |path: &Path| {
        ["draws.csv", "summary.json", "fit.toml"].map(|name| std::fs::read(path.join(name)).unwrap())
    };
    let mut stopped = 0;
    let found = loop {
        let parts = folder(&parts);
        let mut pieces = 0;
        // Each time it is stopped a little later.
        let done = fit_from(&model, &data, &options, parts.progress().unwrap(), &never, &mut |progress| {
            parts.keep(progress.posterior)?;
            pieces += 1;
            if pieces > 1 + stopped % 3 { Err(MotesError::Interrupted) } else { Ok(()) }
        });
        match done {
            Ok(found) => break found,
            Err(error) => assert!(matches!(error, MotesError::Interrupted), "{error}"),
        }
        stopped += 1;
    };
    assert!(stopped > 5, "{stopped}");
    folder(&parts).finish(&found).unwrap();
    assert_eq!(files(&whole), files(&parts));
    assert!(!parts.join("progress.cbor").exists());
}
