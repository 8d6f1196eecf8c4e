//! Forecasts of models whose measurements are inputs of later steps.

use std::ops::ControlFlow;
use std::sync::Arc;

use motes::{Data, FilterOptions, Model, ProposalName, filter};

const FEEDBACK: &str = r#"
[inputs]
before = { column = "y", rows = 1, first = 0 }
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(0.9*x, 0.3)"
[measurement]
y = "normal(x + 0.5*before, 0.2)"
"#;

/// Mean and variance of `y` in some steps, from those of `x` and from the last `y`: the Kalman recursion of both together.
fn exact(steps: usize, x: [f64; 2], y: f64) -> Vec<[f64; 2]> {
    let ([mut mx, mut my], [mut xx, mut xy, mut yy]) = ([x[0], y], [x[1], 0.0, 0.0]);
    let mut found = Vec::new();
    for _ in 0..steps {
        let next = 0.81 * xx + 0.09;
        // y' = x' + y/2 + N(0, 0.04).
        let cross = 0.45 * xy;
        yy = next + 2.0 * cross + 0.25 * yy + 0.04;
        (xx, xy) = (next, next + cross);
        mx *= 0.9;
        my = mx + 0.5 * my;
        found.push([my, yy]);
    }
    found
}

#[test]
fn forecasts_go_on_with_measurements_of_their_own() {
    let model = Model::parse(FEEDBACK, "feedback", &[]).unwrap();
    let data = Data::read("t,y\n0,0.4\n1,1.3\n2,1.9\n3,2.6\n".as_bytes(), "y.csv", &model).unwrap();
    let options = FilterOptions { particles: 20_000, forecast: 5, ..FilterOptions::default() };
    let run =
        |options: &FilterOptions| filter(&model, &data, options, |_| ControlFlow::Continue(())).unwrap();
    let filtered = run(&options);
    let last = &filtered.estimates.last().expect("four rows").state[0];
    let expected = exact(5, [last.mean, last.sd * last.sd], 2.6);
    let forecasts = &filtered.forecasts[0];
    assert_eq!(forecasts.len(), 5);
    for (forecast, [mean, variance]) in forecasts.iter().zip(expected) {
        let (found, sd) = (&forecast.estimate.predictive[0], variance.sqrt());
        assert!((found.mean - mean).abs() < 4.0 * sd / 1000_f64.sqrt(), "{found:?} for {mean}");
        // The error of a standard deviation of 1000 draws is 2.2 %.
        assert!((found.sd / sd - 1.0).abs() < 0.09, "{found:?} for {sd}");
        let [low, high] = [found.quantiles[0], found.quantiles[found.quantiles.len() - 1]];
        assert!((low - mean + 1.645 * sd).abs() < 0.2 * sd, "{found:?}");
        assert!((high - mean - 1.645 * sd).abs() < 0.2 * sd, "{found:?}");
    }
    assert!(
        filtered.warnings.iter().all(|warning| !warning.text.contains("before")),
        "{:?}",
        filtered.warnings
    );
    assert_eq!(run(&options).forecasts, filtered.forecasts);
}

/// Catches a measurement that is known ahead and then simulated all the same.
#[test]
fn a_measurement_that_is_given_ahead_is_the_input_of_all_continuations() {
    let model = Model::parse(FEEDBACK, "feedback", &[]).unwrap();
    let data = Data::read("t,y\n0,0.4\n1,1.3\n".as_bytes(), "y.csv", &model).unwrap();
    let path = std::env::temp_dir().join(format!("motes-ahead-{}.csv", std::process::id()));
    std::fs::write(&path, "t,y\n2,50\n3,\n").unwrap();
    let ahead = Data::open_inputs(&path, &model);
    std::fs::remove_file(&path).unwrap();
    let ahead = ahead.unwrap();
    let options = FilterOptions { particles: 5000, ahead: Some(Arc::new(ahead)), ..FilterOptions::default() };
    let filtered = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap();
    let means: Vec<f64> =
        filtered.forecasts[0].iter().map(|forecast| forecast.estimate.predictive[0].mean).collect();
    assert!(means[0] < 5.0 && (means[1] - 25.0).abs() < 3.0, "{means:?}");
}

/// An exact filter draws nothing that a forecast could go on from.
#[test]
fn an_exact_filter_says_who_forecasts_with_measurements_of_its_own() {
    let options = FilterOptions { proposal: ProposalName::Exact, forecast: 5, ..FilterOptions::default() };
    let run = |text: &str| {
        let model = Model::parse(text, "feedback", &[]).unwrap();
        let data = Data::read("t,y\n0,0.4\n1,1.3\n".as_bytes(), "y.csv", &model).unwrap();
        filter(&model, &data, &options, |_| ControlFlow::Continue(()))
    };
    // Where measurements alone need it, states are predicted.
    let warnings = run(FEEDBACK).unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|warning| warning.text.ends_with("drawn by --proposal bootstrap, and by no exact filter")),
        "{warnings:?}"
    );
    let moving = FEEDBACK.replace("normal(0.9*x, 0.3)", "normal(0.9*x + 0.1*before, 0.3)");
    assert_eq!(
        run(&moving).unwrap_err().to_string(),
        "--proposal exact: a forecast draws the measurement y, an input of later steps, and an exact filter draws nothing; take --proposal bootstrap"
    );
}
