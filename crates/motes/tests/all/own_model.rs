//! A model of a program's own is filtered and learned as that of a file is.

use std::ops::ControlFlow;

use motes::models::equations::{BatchDistribution, BatchEquations, Batched, Column, Normal};
use motes::prelude::*;
use motes::{
    Data, FilterOptions, LearnOptions, LearnedProposal, Model, MotesError, ProposalName, check, designed,
    filter, learn, simulate, smooth,
};
use motes_models::Step;

const TEXT: &str = "[initial]\nx = \"normal(0, 2)\"\n[transition]\nx = \"normal(0.9*x, 1)\"\n[measurement]\ny = \"normal(x*x/20, 0.2)\"\n";

/// The same as a program states it.
struct Squared;

impl Equations for Squared {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 2.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(before[0] * 0.9, 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] / 20.0, 0.2));
    }
}

/// The same for many particles at a time, without derivatives.
struct InColumns;

fn normals(mean: Vec<f64>, sd: f64) -> Option<Vec<BatchDistribution>> {
    let family = Distribution::Normal(Normal { mean: Column::each(mean), sd: Column::same(sd) });
    Some(vec![BatchDistribution::new(family)])
}

impl BatchEquations for InColumns {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial(&self) -> Option<Vec<BatchDistribution>> {
        normals(vec![0.0], 2.0)
    }

    fn transition(&self, _: &Step<'_>, before: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        normals(before.iter().map(|x| x * 0.9).collect(), 1.0)
    }

    fn measurement(&self, _: &Step<'_>, states: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
        normals(states.iter().map(|x| x * x / 20.0).collect(), 0.2)
    }
}

fn of_file() -> Model {
    Model::parse(TEXT, "squared", &[]).unwrap()
}

fn of_program() -> Model {
    Model::own("squared", &["x"], &["y"], Squared).unwrap()
}

fn in_columns() -> Model {
    Model::own("squared", &["x"], &["y"], Batched::new(InColumns)).unwrap()
}

fn go_on(_: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Thirty times, one of which is missing.
fn data(model: &Model) -> Data {
    let drawn = simulate(model, 30, 1, 7, go_on).unwrap();
    let mut text = String::from("y\n");
    for (time, value) in drawn.series[0].measurements.values().iter().enumerate() {
        text += &if time == 11 { "NA\n".into() } else { format!("{value}\n") };
    }
    Data::read(text.as_bytes(), "y.csv", model).unwrap()
}

fn options(proposal: ProposalName) -> FilterOptions {
    FilterOptions { proposal, particles: 2000, ..FilterOptions::default() }
}

fn learned(model: &Model, updates: usize) -> LearnedProposal {
    let options = LearnOptions { updates, steps: 20, ..LearnOptions::default() };
    let found = learn(model, None, &options, |_, _| ControlFlow::Continue(())).unwrap();
    assert!(found.history.unwrap().best_gain() > 0.0);
    found.proposal
}

#[test]
fn what_a_program_states_is_what_a_file_states_to_the_last_bit() {
    let (file, program) = (of_file(), of_program());
    assert_eq!(data(&file).rows, data(&program).rows);
    let data = data(&file);
    for name in [ProposalName::Bootstrap, ProposalName::Linearised] {
        let [of_file, of_program] =
            [&file, &program].map(|model| filter(model, &data, &options(name.clone()), go_on).unwrap());
        assert_eq!(of_file, of_program, "{name}");
    }
    let [of_file, of_program] = [&file, &program].map(|model| {
        let proposal = ProposalName::Learned(learned(model, 100));
        filter(model, &data, &options(proposal), go_on).unwrap()
    });
    assert_eq!(of_file, of_program);
    let smoothed = [&file, &program]
        .map(|model| smooth(model, &data, &options(ProposalName::Bootstrap), 50, |_| go_on(0)).unwrap());
    assert_eq!(smoothed[0], smoothed[1]);
    assert!(check(&program, Some(&data), 1, || ControlFlow::Continue(())).unwrap().problems.is_empty());
}

#[test]
fn a_model_without_derivatives_is_filtered_and_learned() {
    let (file, model) = (of_file(), in_columns());
    let data = data(&file);
    let [expected, found] =
        [&file, &model].map(|model| filter(model, &data, &options(ProposalName::Bootstrap), go_on).unwrap());
    assert_eq!(expected, found);
    assert_eq!(designed(&model, &FilterOptions::default()), [ProposalName::Bootstrap]);
    let refused = filter(&model, &data, &options(ProposalName::Linearised), go_on).unwrap_err();
    assert!(refused.to_string().contains("no derivatives"), "{refused}");

    let proposal = learned(&model, 400);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("squared");
    proposal.save(&path, &model).unwrap();
    let loaded = LearnedProposal::load(&path, &model).unwrap();
    let [ours, again] = [proposal, loaded]
        .map(|proposal| filter(&model, &data, &options(ProposalName::Learned(proposal)), go_on).unwrap());
    assert_eq!(ours.log_evidence(), again.log_evidence());
    assert!((ours.log_evidence() - expected.log_evidence()).abs() < 1.0);
    let ess = |filtered: &motes::Filtered| {
        filtered.estimates.iter().filter_map(|estimate| estimate.ess).sum::<f64>()
    };
    assert!(ess(&ours) > ess(&expected), "{} is not above {}", ess(&ours), ess(&expected));
    let checked = check(&model, Some(&data), 1, || ControlFlow::Continue(())).unwrap();
    assert!(checked.problems.is_empty(), "{:?}", checked.problems);
}

#[test]
fn names_must_fit() {
    for (states, measurements) in [
        (vec!["x", "z"], vec!["y"]),
        (vec!["x"], vec![]),
        (vec!["x"], vec!["x"]),
        (vec!["t"], vec!["y"]),
        (vec!["x"], vec![" "]),
        (vec!["x"], vec!["y\n"]),
    ] {
        let refused = Model::own("squared", &states, &measurements, Squared).unwrap_err();
        assert!(matches!(refused, MotesError::Setting(_)), "{refused}");
    }
}
