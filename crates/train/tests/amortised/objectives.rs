//! Wake and fivo: proposals learned with wrong parameters are tuned on recorded series.

use std::ops::ControlFlow;

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{ModelShape, PartialMeasurements, Seed, Step, simulate};
use motes_proposals::{Amortised, AmortisedConfig, Backend, Base, Family, HeadConfig, Parametric, Sees};
use motes_smc::{FilterSettings, ParticleFilter};
use motes_train::{LearnConfig, LearnObjective, Learned, TrainError, learn};

use crate::conditional::HEADS;

/// A state that is measured through a curve; the standard deviation of its noise is what a model can be wrong about.
struct Curve(f64);

impl Equations for Curve {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.8, self.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + x[0] * x[0] * x[0] * 0.1, 0.3));
    }
}

/// What the model thinks, and what is so.
const THOUGHT: Curve = Curve(0.6);
const TRUE: Curve = Curve(1.5);

fn series(times: usize, number: u64) -> PartialMeasurements {
    let data = simulate(&TRUE, times, &mut Seed::from_u64(41).nth(number).stream()).unwrap().measurements;
    PartialMeasurements::new(1, data.values().iter().copied().map(Some).collect()).unwrap()
}

fn settings(objective: LearnObjective) -> LearnConfig {
    LearnConfig { objective, steps: 150, sequences: 32, rows: 320, validate_every: 30, ..LearnConfig::new() }
}

fn learned_for_the_thought(head: HeadConfig) -> Amortised {
    let config = AmortisedConfig {
        widths: vec![16],
        sees: Sees::All,
        base: Base::Transition,
        head,
        ..AmortisedConfig::gaussian()
    };
    let seed = Seed::from_u64(42);
    let shape = ModelShape::of(&THOUGHT);
    let mut proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let go_on = |_, _| ControlFlow::Continue(());
    learn(&mut proposal, &THOUGHT, &[], &settings(LearnObjective::Inclusive), &seed, go_on).unwrap();
    proposal
}

fn tuned(
    proposal: &Amortised,
    recorded: &[PartialMeasurements],
    settings: &LearnConfig,
) -> Result<(Amortised, Learned), TrainError> {
    let mut tuned = proposal.clone();
    let settings = LearnConfig { continues: true, ..*settings };
    let go_on = |_, _| ControlFlow::Continue(());
    let found = learn(&mut tuned, &THOUGHT, recorded, &settings, &Seed::from_u64(43), go_on)?;
    Ok((tuned, found))
}

/// The log-evidence per time of each of many series that nobody learned from.
fn evidence(proposal: &Amortised) -> Vec<f64> {
    (100..160)
        .map(|number| {
            let settings = FilterSettings { defensive_weight: Some(0.1), ..FilterSettings::new(50) };
            let stream = Seed::from_u64(44).nth(number).stream();
            let mut filter = ParticleFilter::new(&THOUGHT, proposal.clone(), settings, stream).unwrap();
            let (series, steps) = (series(40, number), (0..).map(Step::of_index));
            steps.zip(series.rows()).for_each(|(step, row)| filter.step_at(&step, row).unwrap());
            filter.log_evidence() / 40.0
        })
        .collect()
}

#[test]
fn wake_and_fivo_make_a_proposal_for_a_wrong_model_better_on_series_that_it_never_saw() {
    let recorded: Vec<PartialMeasurements> = (0..8).map(|number| series(40, number)).collect();
    for (objective, head) in [(LearnObjective::Wake, HEADS[1]), (LearnObjective::Fivo, HEADS[0])] {
        let before = learned_for_the_thought(head);
        let (after, found) = tuned(&before, &recorded, &settings(objective)).unwrap();
        assert_eq!(found.objective, objective);
        assert!(found.best_gain() > found.validation[0].1, "{objective}: {:?}", found.validation);
        let ahead: Vec<f64> =
            evidence(&after).iter().zip(evidence(&before)).map(|(after, before)| after - before).collect();
        let n = ahead.len() as f64;
        // Differences have tails as heavy as a poor filter's: how many series are better, in standard errors of a toss of a coin.
        let better = ahead.iter().filter(|value| **value > 0.0).count() as f64;
        let z = (better - 0.5 * n) / (0.5 * n.sqrt());
        let mean = ahead.iter().sum::<f64>() / n;
        assert!(z > 4.0 && mean > 0.0, "{objective}: {better} of {n} are better, by {mean} in the mean");
        // The standards of inputs are those of the proposal that was tuned.
        for at in 0..before.parameters().len() {
            if before.parameters().names()[at].contains("inputs") {
                assert_eq!(before.parameters().host(at), after.parameters().host(at));
            }
        }
    }
}

#[test]
fn tuning_hands_out_nothing_worse_on_validation_and_the_same_seed_gives_the_same_weights() {
    let proposal = learned_for_the_thought(HEADS[0]);
    // One series: its last quarter is held out. Gaps are no danger.
    let mut entries: Vec<Option<f64>> = series(60, 1).rows().map(|row| row[0]).collect();
    (entries[5], entries[50]) = (None, None);
    let one = [PartialMeasurements::new(1, entries).unwrap()];
    for objective in [LearnObjective::Wake, LearnObjective::Fivo] {
        // Steps so large that they ruin any proposal.
        let mut settings = LearnConfig { steps: 40, ..settings(objective) };
        settings.adam.learning_rate = 3.0;
        let (after, found) = tuned(&proposal, &one, &settings).unwrap();
        assert!(found.best_gain() >= found.validation[0].1, "{:?}", found.validation);
        if found.best_step == 0 {
            assert_eq!(after.parameters().values(), proposal.parameters().values(), "{objective}");
        }
        let settings = LearnConfig { steps: 40, dropout: 0.2, weight_penalty: 1e-3, ..settings };
        let [one, same] = [(); 2].map(|()| tuned(&proposal, &one, &settings).unwrap());
        assert_eq!(one.0.parameters().values(), same.0.parameters().values(), "{objective}");
        assert_eq!(one.1.validation, same.1.validation, "{objective}");
    }
}

#[test]
fn what_an_objective_needs_is_asked_for() {
    let seed = Seed::from_u64(45);
    let config = AmortisedConfig { widths: vec![4], ..AmortisedConfig::mixture(2) };
    let shape = ModelShape::of(&THOUGHT);
    let mixture = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let refused = |recorded: &[PartialMeasurements], settings: LearnConfig| {
        tuned(&mixture, recorded, &settings).map(|_| ()).unwrap_err()
    };
    let (wake, fivo) = (settings(LearnObjective::Wake), settings(LearnObjective::Fivo));
    assert_eq!(refused(&[], wake), TrainError::NoRecorded { objective: "wake".into() });
    assert_eq!(refused(&[], fivo), TrainError::NoRecorded { objective: "fivo".into() });
    assert_eq!(refused(&[series(40, 1)], fivo), TrainError::Draws);
    assert!(matches!(refused(&[series(5, 1)], wake), TrainError::Recorded { .. }));
    for (setting, expected) in [
        (LearnConfig { dropout: 1.0, ..wake }, "left out is 1"),
        (LearnConfig { dropout: f64::NAN, ..wake }, "left out is NaN"),
        (LearnConfig { weight_penalty: -1.0, ..wake }, "the weight penalty is -1"),
    ] {
        let error = refused(&[series(40, 1)], setting).to_string();
        assert!(error.contains(expected), "{error}");
    }
}
