//! Filters that go on from a checkpoint, and what is refused as one.

use std::ops::ControlFlow;

use motes::{Estimate, FilterOptions, LearnOptions, Model, ProposalName, Running, learn};

const TEXT: &str = "[parameters]\nq = 0.5\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(0.9*x, q)\"\n[measurement]\ny = \"normal(x, 0.5)\"\n";

const MATRICES: &str = "kind = \"linear-gaussian\"\nstates = [\"x\"]\nmeasurements = [\"y\"]\nA = [[0.9]]\nC = [[1.0]]\nQ = [[1.0]]\nR = [[0.5]]\nm0 = [0.0]\nP0 = [[1.0]]\n";

fn model(text: &str) -> Model {
    Model::parse(text, "model.toml", &[]).unwrap()
}

/// A measurement of each time; some are missing.
fn measured(time: usize) -> [Option<f64>; 1] {
    [(time % 5 != 3).then(|| (time as f64).sin())]
}

fn steps(running: &mut Running<'_>, times: std::ops::Range<usize>) -> Vec<Estimate> {
    times.map(|time| running.step(&measured(time)).unwrap()).collect()
}

fn goes_on(model: &Model, options: &FilterOptions) {
    let mut running = Running::new(model, options, 2).unwrap();
    for at in [0, 1, 12] {
        let mut original = Running::new(model, options, 2).unwrap();
        steps(&mut original, 0..at);
        let bytes = original.checkpoint().unwrap();
        let mut resumed = Running::resume(model, options, &bytes).unwrap();
        assert_eq!(resumed.log_evidence().to_bits(), original.log_evidence().to_bits());
        assert_eq!(resumed.last_increment().to_bits(), original.last_increment().to_bits());
        assert_eq!(resumed.verdict(), original.verdict());
        assert_eq!(steps(&mut resumed, at..20), steps(&mut original, at..20));
        assert_eq!(resumed.predict().unwrap(), original.predict().unwrap());
        assert_eq!(resumed.verdict(), original.verdict());
        assert_eq!(resumed.checkpoint().unwrap(), original.checkpoint().unwrap());
    }
    steps(&mut running, 0..3);
}

#[test]
fn every_filter_goes_on_as_the_original_does() {
    let formulas = model(TEXT);
    let options = LearnOptions { updates: 20, ..LearnOptions::default() };
    let learned = learn(&formulas, None, &options, |_, _| ControlFlow::Continue(())).unwrap().proposal;
    for proposal in [ProposalName::Bootstrap, ProposalName::Linearised, ProposalName::Learned(learned)] {
        let options = FilterOptions { proposal, particles: 300, ..FilterOptions::default() };
        goes_on(&formulas, &options);
        goes_on(&formulas, &FilterOptions { check: false, resample_below: 1.0, ..options });
    }
    for proposal in [ProposalName::Bootstrap, ProposalName::Optimal] {
        goes_on(&model(MATRICES), &FilterOptions { proposal, ..FilterOptions::default() });
    }
}

#[test]
fn a_filter_that_failed_has_failed_when_it_is_resumed() {
    let text = TEXT.replace("\"normal(x, 0.5)\"", "\"uniform(x - 0.1, x + 0.1)\"");
    let (model, options) = (model(&text), FilterOptions::default());
    let mut running = Running::new(&model, &options, 0).unwrap();
    running.step(&[Some(50.0)]).unwrap_err();
    let error = running.step(&[Some(0.0)]).unwrap_err().to_string();
    assert!(error.starts_with("t = 1: the filter failed in an earlier step: "), "{error}");
    let mut resumed = Running::resume(&model, &options, &running.checkpoint().unwrap()).unwrap();
    assert_eq!(resumed.step(&[Some(0.0)]).unwrap_err().to_string(), error);
}

#[test]
fn what_is_no_checkpoint_of_the_filter_is_refused_in_a_line() {
    let (formulas, options) = (model(TEXT), FilterOptions::default());
    let mut running = Running::new(&formulas, &options, 0).unwrap();
    steps(&mut running, 0..3);
    let bytes = running.checkpoint().unwrap();
    let said = |model: &Model, options: &FilterOptions, bytes: &[u8]| {
        let said = Running::resume(model, options, bytes).err().expect("it is refused").to_string();
        assert!(said.starts_with("a checkpoint of a filter: ") && !said.contains('\n'), "{said}");
        said
    };
    let other = Model::parse(TEXT, "model.toml", &[("q".into(), 0.6)]).unwrap();
    assert!(said(&other, &options, &bytes).contains("the filter was one of another model: "));
    let two = TEXT.replace("[transition]", "z = \"normal(0, 1)\"\n[transition]\nz = \"normal(z, 1)\"");
    assert!(said(&model(&two), &options, &bytes).contains("the state dimension N is 1 there and 2"));
    let changed = FilterOptions { particles: 10, ..options.clone() };
    assert!(said(&formulas, &changed, &bytes).contains("the number of particles is 1000 there and 10"));
    let changed = FilterOptions { resample_below: 0.9, ..options.clone() };
    assert!(said(&formulas, &changed, &bytes).contains("how it resamples and mixes"));
    let changed = FilterOptions { proposal: ProposalName::Linearised, ..options.clone() };
    assert!(said(&formulas, &changed, &bytes).contains("the proposal is \"bootstrap\" there"));
    let checked = FilterOptions { proposal: ProposalName::Linearised, ..options.clone() };
    let unchecked = FilterOptions { check: false, ..checked.clone() };
    let of_checked = Running::new(&formulas, &checked, 0).unwrap().checkpoint().unwrap();
    assert!(said(&formulas, &unchecked, &of_checked).contains("whether it is checked"));
    for length in [0, 10, 36, bytes.len() - 1] {
        assert!(said(&formulas, &options, &bytes[..length]).contains("not as they were written"));
    }
    for at in (0..bytes.len()).step_by(97) {
        let mut wrong = bytes.clone();
        wrong[at] ^= 4;
        assert!(said(&formulas, &options, &wrong).contains("not as they were written"));
    }
}
