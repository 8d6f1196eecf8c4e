//! Maxima by iterated filtering, held against the exact likelihood.

use std::ops::ControlFlow;

use motes::{
    Data, FilterOptions, FitOptions, MaximumFit, Model, MotesError, ProposalName, log_evidence, maximise,
    simulate,
};

use motes::output::simulated_table;

/// A regression on waves of known lengths with a level that drifts: eight parameters, of which `level` is one of the start alone and `b` are entries of a list.
const WAVES: &str = r#"
[parameters]
b = ["normal(0, 1)", "normal(0, 1)", "normal(0, 1)", "normal(0, 1)", 0.5]
trend = "normal(0, 0.1)"
level = "normal(0, 2)"
drift = "log_normal(log(0.1), 0.5)"
sd = "log_normal(log(0.5), 0.5)"
[definitions]
waves = "b[0]*sin(t/3) + b[1]*cos(t/3) + b[2]*sin(t/7) + b[3]*cos(t/7) + b[4]*sin(t/17)"
[initial]
x = "normal(level, 0.1)"
[transition]
x = "normal(x, drift)"
[measurement]
y = "normal(x + trend*t + waves, sd)"
"#;

fn never() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn data(model: &Model, rows: usize, truth: &[(&str, f64)]) -> Data {
    let truth: Vec<(String, f64)> = truth.iter().map(|(name, value)| (name.to_string(), *value)).collect();
    let at_truth = model.with_parameters(&truth).unwrap();
    let simulated = simulate(&at_truth, rows, 1, 4, |_| never()).unwrap();
    Data::read(simulated_table(&at_truth, &simulated).as_bytes(), "waves.csv", model).unwrap()
}

fn found(model: &Model, data: &Data, options: &FitOptions) -> Result<MaximumFit, MotesError> {
    maximise(model, data, options, None, &never, &mut |_| Ok(()))
}

fn exact(model: &Model, data: &Data, at: &MaximumFit) -> f64 {
    let values = at.names.iter().cloned().zip(at.parameters.iter().map(|parameter| parameter.estimate));
    let model = model.with_parameters(&values.collect::<Vec<(String, f64)>>()).unwrap();
    let options = FilterOptions { proposal: ProposalName::Exact, ..FilterOptions::default() };
    log_evidence(&model, data, &options, |_| never()).unwrap().value
}

#[test]
fn eight_parameters_are_sought_by_swarms_that_end_near_the_exact_maximum() {
    let model = Model::parse(WAVES, "waves", &[]).unwrap();
    let truth = [("b[0]", 0.8), ("b[1]", -0.5), ("b[2]", 1.1), ("level", 1.5), ("trend", 0.03), ("sd", 0.4)];
    let data = data(&model, 80, &truth);
    let quadratics = FitOptions { chains: 1, profiles: vec!["sd".into()], ..FitOptions::default() };
    let best = found(&model, &data, &quadratics).unwrap();
    let options = FitOptions {
        proposal: Some(ProposalName::Bootstrap),
        particles: Some(400),
        passes: Some(60),
        chains: 2,
        profiles: vec!["trend".into()],
        ..FitOptions::default()
    };
    let swarms = found(&model, &data, &options).unwrap();
    let missing = best.log_likelihood - exact(&model, &data, &swarms);
    assert!((0.0..2.5).contains(&missing), "{missing} below the maximum: {swarms:?}");
    let off = (swarms.log_likelihood - exact(&model, &data, &swarms)).abs();
    assert!(off < 4.0 * swarms.log_likelihood_error, "{off} off: {swarms:?}");
    // The profile that was named, and no other.
    let trend = swarms.names.iter().position(|name| name == "trend").unwrap();
    for (at, parameter) in swarms.parameters.iter().enumerate() {
        assert_eq!(parameter.low.is_some(), at == trend, "{parameter:?}");
    }
    assert!(swarms.parameters[trend].low < Some(0.03) && swarms.parameters[trend].high > Some(0.03));
    assert_eq!((swarms.proposal.as_str(), swarms.particles), ("bootstrap", 400));
    // A second time, to the last bit.
    assert_eq!(found(&model, &data, &options).unwrap(), swarms);
}

#[test]
fn passes_are_refused_where_no_filter_has_parameters_of_its_particles() {
    let refused = |text: &str, proposal: Option<ProposalName>| {
        let model = Model::parse(text, "model.toml", &[]).unwrap();
        let data = Data::read("y\n0.3\n0.1\n".as_bytes(), "y.csv", &model).unwrap();
        let options = FitOptions { passes: Some(2), proposal, ..FitOptions::default() };
        found(&model, &data, &options).expect_err("no filter").to_string()
    };
    let line = "--passes: iterated filtering takes the bootstrap filter of a model file whose free parameters stand in formulas alone";
    // Its likelihood is exact.
    assert!(refused(WAVES, None).starts_with(line));
    assert!(
        refused(WAVES, None).ends_with("; the likelihood is estimated by exact; take --proposal bootstrap")
    );
    let lengths = "[parameters]\nk = \"poisson(3)\"\n[initial]\n\"x[k]\" = \"normal(0, 1)\"\n[transition]\n\"x[k]\" = \"normal(x[i], 1)\"\n[measurement]\ny = \"normal(x[0], 1)\"\n";
    assert!(refused(lengths, Some(ProposalName::Bootstrap)).starts_with(line));
    let reason = refused(lengths, Some(ProposalName::Bootstrap));
    assert!(reason.contains("; model.toml") && reason.contains("[initial] x[k]"), "{reason}");
}
