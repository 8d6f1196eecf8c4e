//! Posteriors of the models in examples/fit, held against those of examples/fit/references.json, which `python examples/fit/references.py` finds by sums over grids.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use motes::inference::ParameterSummary;
use motes::{Data, FitOptions, Model, fit, on_threads};

/// Means and standard deviations within four Monte Carlo standard errors, at an effective sample size of 4,000 at least.
fn is_exact(name: &str, data: &str, draws: usize) {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let references = std::fs::read_to_string(examples.join("fit/references.json")).unwrap();
    let references: BTreeMap<String, BTreeMap<String, [f64; 2]>> = serde_json::from_str(&references).unwrap();
    let model = Model::read(&examples.join("fit").join(format!("{name}.toml")), &[]).unwrap();
    let data = Data::open(&examples.join(data), &model).unwrap();
    let options = FitOptions { draws: Some(draws), ..FitOptions::default() };
    let go_on = || ControlFlow::Continue(());
    let fitted = on_threads(None, || fit(&model, &data, &options, &go_on, &mut |_| Ok(()))).unwrap().unwrap();
    for (at, (name, summary)) in fitted.names.iter().zip(&fitted.parameters).enumerate() {
        let [mean, sd] = references[model.name()][name];
        assert!(summary.ess_bulk >= 4000.0 && summary.rhat < 1.01, "{name}: {summary:?}");
        let of_mean = (summary.mean - mean) / summary.mcse;
        let square = |value: &f64| (value - mean).powi(2);
        let chains = fitted.of_parameter(at);
        let squares = chains.iter().map(|chain| chain.iter().map(square).collect());
        let squares = ParameterSummary::of(&squares.collect::<Vec<Vec<f64>>>()).unwrap();
        let of_variance = (squares.mean - sd * sd) / squares.mcse;
        println!("{name}: the mean is {of_mean:+.1} standard errors off, the variance {of_variance:+.1}");
        assert!(of_mean.abs() < 4.0 && of_variance.abs() < 4.0, "{name}: {summary:?} beside {mean} ± {sd}");
    }
}

#[test]
#[ignore = "the thorough run has it"]
fn the_nile() {
    is_exact("nile", "nile.csv", 8000);
}

#[test]
#[ignore = "the thorough run has it"]
fn ricker() {
    is_exact("ricker", "fit/ricker.csv", 16_000);
}

#[test]
#[ignore = "the thorough run has it"]
fn influenza() {
    is_exact("influenza", "influenza.csv", 12_000);
}

#[test]
#[ignore = "the thorough run has it"]
fn the_pound() {
    is_exact("pound", "fit/pound.csv", 160_000);
}
