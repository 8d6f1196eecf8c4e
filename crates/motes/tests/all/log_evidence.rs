//! The log-evidence alone: that of a filter to the last bit, and −∞ where data are impossible.

use std::ops::ControlFlow;

use motes::{Data, FilterOptions, Model, MotesError, ProposalName, filter, log_evidence, simulate};

const TEXT: &str = "[parameters]\nw = 1.0\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"uniform(x - w, x + w)\"\n";

fn model(w: f64) -> Model {
    Model::parse(TEXT, "model.toml", &[("w".into(), w)]).unwrap()
}

fn go_on(_: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn it_is_that_of_the_filter() {
    let model = model(2.0);
    let text = "series,y\na,0.3\nb,0.1\na,\nb,0.9\na,1.2\n";
    let data = Data::read(text.as_bytes(), "y.csv", &model).unwrap();
    for proposal in [ProposalName::Bootstrap, ProposalName::Linearised] {
        let options = FilterOptions { proposal, forecast: 3, ..FilterOptions::default() };
        let whole = filter(&model, &data, &options, go_on).unwrap();
        let alone = log_evidence(&model, &data, &options, go_on).unwrap();
        assert_eq!((alone.value.to_bits(), alone.impossible), (whole.log_evidence().to_bits(), None));
    }
}

#[test]
fn impossible_data_have_none_and_other_failures_are_errors() {
    let model = model(0.1);
    let read = |text: &str| Data::read(text.as_bytes(), "y.csv", &model).unwrap();
    let options = FilterOptions::default();
    let said = |text: &str| {
        let found = log_evidence(&model, &read(text), &options, go_on).unwrap();
        assert_eq!(found.value, f64::NEG_INFINITY);
        found.impossible.unwrap().to_string()
    };
    let why = "no particle explains the measurement: y is 30, where the particles predict ";
    for (text, place) in
        [("y\n0\n30\n", "y.csv, line 3, t = 1"), ("series,y\na,0\nb,30\n", "series b: y.csv, line 3, t = 0")]
    {
        let said = said(text);
        assert!(
            said.starts_with(&format!("{place}: {why}")) && said.ends_with("; the log-evidence is −∞"),
            "{said}"
        );
    }
    let root = TEXT.replace("normal(x, 1)", "normal(sqrt(x), 1)");
    let root = Model::parse(&root, "model.toml", &[]).unwrap();
    let data = Data::read("y\n0\n0\n".as_bytes(), "y.csv", &root).unwrap();
    let error = log_evidence(&root, &data, &options, go_on).unwrap_err();
    assert!(matches!(error, MotesError::Filter { .. }), "{error}");
    let stopped = log_evidence(&model, &read("y\n0\n0\n"), &options, |_| ControlFlow::Break(()));
    assert!(matches!(stopped, Err(MotesError::Interrupted)));
}

#[test]
fn a_long_simulation_can_be_stopped_within_a_series() {
    let mut asked = 0;
    let stopped = simulate(&model(1.0), 1_000_000, 1, 1, |done| {
        assert_eq!(done, 0);
        asked += 1;
        if asked == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(matches!(stopped, Err(MotesError::Interrupted)));
    assert_eq!(asked, 3);
}
