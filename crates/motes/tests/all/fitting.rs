//! Parameters from data: posteriors against sums over grids, what is refused, what goes on after it was stopped.

use std::ops::ControlFlow;
use std::path::Path;

use crate::common::{Workplace, stderr};
use motes::inference::ParameterSummary;
use motes::models::equations::Scalar;
use motes::{
    Data, FilterOptions, FitFolder, FitOptions, FitRecord, FreeParameters, Model, MotesError, PosteriorFit,
    ProposalName, filter, filter_draws, fit, fit_from, log_evidence,
};

const NILE: &str = r#"
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
        assert!(summary.rhat < 1.01, "{summary:?}");
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
    let exactly = fitted(&model, &data, &FitOptions { draws: Some(2500), ..FitOptions::default() });
    assert_eq!(exactly.proposal, "exact");
    agrees(&exactly, &grid, log_marginal);
    let proposal = Some(ProposalName::Bootstrap);
    let by_particles =
        fitted(&model, &data, &FitOptions { proposal, draws: Some(2500), ..FitOptions::default() });
    assert_eq!(by_particles.proposal, "bootstrap");
    agrees(&by_particles, &grid, log_marginal);
    // Exact whatever the number of particles is.
    let few = FitOptions {
        proposal: Some(ProposalName::Bootstrap),
        particles: Some(by_particles.particles.div_ceil(2)),
        draws: Some(5000),
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
        let state = found.forecasts[0][4].estimate.state[0];
        mean += weight * state.mean;
        square += weight * (state.sd * state.sd + state.mean * state.mean);
        parts.push((weight, state.mean, state.sd));
    }
    let sd = (square - mean * mean).sqrt();
    let state = mixed.forecasts[0][4].estimate.state[0];
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

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("nile.toml", NILE);
    place.write("nile.csv", "flow\n1120\n1160\n963\n1210\n1160\n1160\n813\n1230\n1370\n1140\n");
    place
}

#[test]
fn a_fit_is_a_table_a_folder_and_parameters_for_other_commands() {
    let place = place();
    let fit = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "200"];
    let table = place.printed(&fit);
    assert!(table.contains("| measurement_variance |") && table.contains("ESS bulk"), "{table}");
    let draws = place.read("fit/draws.csv");
    assert!(
        draws.starts_with("chain,draw,log_evidence,measurement_variance,level_variance\n0,0,"),
        "{draws}"
    );
    assert_eq!(draws.lines().count(), 801);
    let json: serde_json::Value = serde_json::from_str(&place.read("fit/summary.json")).unwrap();
    for key in ["mean", "sd", "q05", "q50", "q95", "rhat", "ess_bulk", "ess_tail", "mcse"] {
        assert!(json["parameters"]["level_variance"][key].is_number(), "{key}: {json}");
    }
    for key in ["log_likelihood", "log_likelihood_error", "log_marginal_likelihood", "acceptance"] {
        assert!(json[key].is_number(), "{key}: {json}");
    }
    // The same seed on another number of threads.
    let threads = place.printed(&[&fit[..4], &["other", "--draws", "200", "--threads", "1"]].concat());
    assert_eq!((threads, place.read("other/draws.csv")), (table, draws));
    let over = ["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--json"];
    let over: serde_json::Value = serde_json::from_str(&place.printed(&over)).unwrap();
    assert!(over["log_evidence"].is_null() && over["draws"] == 100, "{over}");
    let at_mean = ["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--at", "mean", "--json"];
    let at_mean: serde_json::Value = serde_json::from_str(&place.printed(&at_mean)).unwrap();
    assert!(at_mean["log_evidence"].is_number(), "{at_mean}");
    let table = place.printed(&["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--forecast", "3"]);
    assert_eq!(table.lines().count(), 14, "{table}");
    let smoothed = place.printed(&["smooth", "nile.toml", "nile.csv", "--parameters", "fit"]);
    assert_eq!(smoothed.lines().count(), 11, "{smoothed}");
    let simulated =
        place.printed(&["simulate", "nile.toml", "--steps", "2", "--series", "3", "--parameters", "fit"]);
    let header = "series,t,level,flow,measurement_variance,level_variance";
    assert!(simulated.starts_with(header), "{simulated}");
}

#[test]
fn what_cannot_be_fitted_is_refused_in_one_line() {
    let place = place();
    place.write(
        "known.toml",
        NILE.replace("\"log_normal(log(10000), 1.5)\"", "10000")
            .replace("\"log_normal(log(1000), 1.5)\"", "1000"),
    );
    place.write(
        "uniform.toml",
        NILE.replace("normal(level, sqrt(measurement_variance))", "uniform(level, level + 1e-9)"),
    );
    let refused = |arguments: &[&str]| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        stderr(&output)
    };
    assert_eq!(
        refused(&["fit", "known.toml", "nile.csv", "-o", "fit"]),
        "motes: no parameter of known has a prior, so there is nothing to fit; write what is known of one before the data instead of its value, as in \
         measurement_variance = \"log_normal(log(10000), 1)\""
    );
    assert_eq!(
        refused(&["fit", "walk.toml", "d.csv", "-o", "fit", "--set", "noise=2"]),
        "motes: no parameter of walk has a prior, so there is nothing to fit; write what is known of one before the data instead of its value, as in \
         noise = \"log_normal(log(2), 1)\""
    );
    let all = [
        "fit",
        "nile.toml",
        "nile.csv",
        "-o",
        "fit",
        "--set",
        "measurement_variance=1",
        "--set",
        "level_variance=1",
    ];
    assert_eq!(
        refused(&all),
        "motes: every parameter that has a prior was given a value by --set; leave one of them free"
    );
    let impossible = refused(&["fit", "uniform.toml", "nile.csv", "-o", "fit"]);
    assert!(
        impossible.starts_with("motes: the likelihood is 0 at every draw from the prior: the model cannot give these data; the first time: line 2"),
        "{impossible}"
    );
    place.printed(&["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "100"]);
    place.write("other.toml", NILE.replace("1000, 1000", "1000, 900"));
    assert_eq!(
        refused(&["filter", "other.toml", "nile.csv", "--parameters", "fit"]),
        "motes: --parameters fit: it is a fit of nile, or of this model before its file was changed; fit it again"
    );
    let nothing = refused(&["filter", "nile.toml", "nile.csv", "--parameters", "nowhere"]);
    assert_eq!(
        nothing,
        "motes: --parameters nowhere: there is no fit.toml in it; motes fit writes such folders with -o"
    );
    place.write("other-folder", "");
    std::fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/thesis.tex", "");
    let output = place.run(&["fit", "nile.toml", "nile.csv", "-o", "mine"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(stderr(&output).contains("it has files in it, and none of a fit"), "{}", stderr(&output));
    let exactly = refused(&["fit", "uniform.toml", "nile.csv", "-o", "fit", "--proposal", "exact"]);
    assert!(exactly.starts_with("motes: --proposal exact:"), "{exactly}");
}

#[test]
fn what_data_say_nothing_about_and_what_lies_at_an_edge_is_said() {
    let place = place();
    let unknown = NILE.replace("[initial]", "idle = \"normal(0, 1)\"\n[initial]");
    place.write("unknown.toml", unknown);
    let output = place.run(&["fit", "unknown.toml", "nile.csv", "-o", "fit", "--draws", "400", "--strict"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = "motes: warning: the data say nothing about idle: its posterior is its prior normal(0, 1)";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let edge = NILE.replace("log_normal(log(10000), 1.5)", "log_normal(log(300), 0.5)");
    let edge = edge.replace("log_normal(log(1000), 1.5)", "log_normal(log(10), 0.3)");
    place.write("edge.toml", edge);
    let output = place.run(&["fit", "edge.toml", "nile.csv", "-o", "edge", "--draws", "400"]);
    let said = "measurement_variance lies at the upper edge of its prior log_normal(log(300), 0.5): the prior and the data disagree";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let few = place.run(&["fit", "nile.toml", "nile.csv", "-o", "few", "--draws", "20", "--strict"]);
    assert_eq!(few.status.code(), Some(1));
    assert!(stderr(&few).contains("the chains have not converged: "), "{}", stderr(&few));
}
