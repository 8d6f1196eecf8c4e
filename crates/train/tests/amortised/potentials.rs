//! Potentials that networks emit for whole sequences: what learning makes of them, and that evidence stays unbiased whatever they are.

use std::ops::ControlFlow;

use motes_models::equations::Equations;
use motes_models::{ModelShape, Seed, Step, StepRecord, simulate};
use motes_proposals::{Backend, Family, LearnedPotentials, LearnedPotentialsConfig, Parametric};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, LookAhead, LookAheadError, Proposal, RecordedStep};
use motes_train::{
    PathRequest, PathSource, PotentialHistory, PotentialLearnConfig, TrainError, learn_potentials,
};
use rand::RngExt;

use crate::models::{Growth, Linear, LogVariance};

fn untrained<M: Equations>(model: &M) -> LearnedPotentials {
    let config = LearnedPotentialsConfig { hidden: 16, components: 2, ..LearnedPotentialsConfig::default() };
    let shape = ModelShape::of(model);
    LearnedPotentials::create(&config, &shape, 0, Backend::Native.into(), &Seed::from_u64(1)).unwrap()
}

fn few(steps: usize) -> PotentialLearnConfig {
    PotentialLearnConfig { steps, horizon: 50, validate_every: 50, ..PotentialLearnConfig::new() }
}

fn learned<M: Equations>(model: &M, steps: usize) -> (LearnedPotentials, PotentialHistory) {
    let mut potentials = untrained(model);
    let seed = Seed::from_u64(2);
    let found = learn_potentials(&mut potentials, PathSource::Model(model), &few(steps), &seed, |_, _| {
        ControlFlow::Continue(())
    });
    (potentials, found.unwrap())
}

/// A held-out sequence, of which one measurement in seven is missing if it has gaps.
fn rows(model: &impl Equations, times: usize, number: u64, has_gaps: bool) -> Vec<RecordedStep> {
    let seed = Seed::from_u64(99).nth(number);
    let data = simulate(model, times, &mut seed.stream()).unwrap().measurements;
    let row = |(index, row): (usize, &[f64])| RecordedStep {
        step: StepRecord::of(&Step::of_index(index)),
        measurement: row.iter().map(|y| (!has_gaps || index % 7 != 5).then_some(*y)).collect(),
    };
    data.rows().enumerate().map(row).collect()
}

fn evidence<M: Equations, P: Proposal<M, Memory = ()> + Send>(
    model: &M,
    proposal: P,
    rows: &[RecordedStep],
    particles: usize,
    runs: usize,
) -> Vec<f64> {
    let settings = FilterSettings::new(particles);
    let mut bank =
        FilterBank::new(model, proposal, settings, runs, &Seed::from_u64(3)).unwrap().keeping_collapsed();
    for RecordedStep { step, measurement } in rows {
        bank.step_at(&step.step(), measurement).unwrap();
    }
    (0..runs).map(|run| bank.log_evidence(run)).collect()
}

fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0))
}

/// The logarithm of the mean of `ẑ`, and its standard error.
fn log_mean(logs: &[f64]) -> (f64, f64) {
    let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (mean, variance) = moments(&logs.iter().map(|log| (log - most).exp()).collect::<Vec<f64>>());
    (most + mean.ln(), (variance / logs.len() as f64).sqrt() / mean)
}

/// Where a smoother sees one mode of two, and bootstrap has a variance of hundreds.
#[test]
fn with_two_modes_they_have_a_hundredth_of_the_variance_of_bootstrap() {
    let (potentials, found) = learned(&Growth, 800);
    assert!(found.best_gains()[0] > found.validation[0].1[0] + 0.5, "{:?}", found.validation);
    // Longer than those that were learned from, with gaps.
    for number in 0..3 {
        let rows = rows(&Growth, 100, number, number == 1);
        let ahead = potentials.look_ahead(&Growth, &rows).unwrap();
        let of_learned = moments(&evidence(&Growth, ahead, &rows, 100, 50));
        let of_bootstrap = moments(&evidence(&Growth, Bootstrap, &rows, 100, 50));
        assert!(of_learned.1 < 0.01 * of_bootstrap.1, "{of_learned:?} beside {of_bootstrap:?}");
        // Both are unbiased: the logarithms of their means agree.
        let ahead = potentials.look_ahead(&Growth, &rows).unwrap();
        let (log, error) = log_mean(&evidence(&Growth, ahead, &rows, 200, 50));
        let (reference, of_reference) = log_mean(&evidence(&Growth, Bootstrap, &rows, 20_000, 16));
        let off = (log - reference) / error.hypot(of_reference);
        assert!(off.abs() < 4.0, "{log} ± {error} beside {reference} ± {of_reference}");
    }
}

/// The evidence of few particles is unbiased with weights as they were drawn, and with weights that were turned round.
#[test]
fn the_evidence_is_unbiased_whatever_the_weights() {
    let model = Linear;
    let rows = rows(&model, 6, 0, true);
    let designed = LookAhead::new(&model, &rows).unwrap();
    let (exact, error) = moments(&evidence(&model, designed, &rows, 32, 8));
    assert!(error < 1e-16, "{error}");
    let drawn = untrained(&model);
    let mut turned = learned(&model, 100).0;
    for index in 0..turned.parameters().len() {
        if turned.parameters().names()[index].starts_with("reader") {
            let values: Vec<f64> = turned.parameters().host(index).iter().map(|weight| -weight).collect();
            turned.parameters_mut().set_host(index, &values).unwrap();
        }
    }
    for potentials in [drawn, turned] {
        let ahead = potentials.look_ahead(&model, &rows).unwrap();
        let found = evidence(&model, ahead, &rows, 10, 4000);
        let ratios: Vec<f64> = found.iter().map(|log| (log - exact).exp()).collect();
        let (mean, variance) = moments(&ratios);
        let off = (mean - 1.0) / (variance / 4000.0).sqrt();
        assert!(off.abs() < 4.0, "{mean}: {off} standard errors");
    }
}

/// Catches units of one model that are taken for those of another, and networks that do not see what parameters do.
#[test]
fn over_a_prior_they_serve_any_parameter() {
    let mut potentials = untrained(&LogVariance(0.2));
    let draw = |seed: &Seed, asked: PathRequest<'_>| {
        asked.of(&LogVariance(seed.stream().random_range(0.05_f64.ln()..0.8_f64.ln()).exp()))
    };
    let (source, seed) = (PathSource::<LogVariance>::Models(&draw), Seed::from_u64(2));
    let go_on = |_, _| ControlFlow::Continue(());
    learn_potentials(&mut potentials, source, &few(600), &seed, go_on).unwrap();
    // The last one is outside the prior.
    for (number, sd) in [0.08, 0.2, 0.6, 2.0].into_iter().enumerate() {
        let model = LogVariance(sd);
        let rows = rows(&model, 100, number as u64, false);
        let ahead = potentials.look_ahead(&model, &rows).unwrap();
        let found = evidence(&model, ahead, &rows, 100, 100);
        let of_bootstrap = evidence(&model, Bootstrap, &rows, 100, 100);
        let (learned, bootstrap) = (moments(&found).1, moments(&of_bootstrap).1);
        assert!(learned < 0.3 * bootstrap || sd > 1.0, "{sd}: {learned} beside {bootstrap}");
        let (log, error) = log_mean(&found);
        let (reference, of_reference) = log_mean(&evidence(&model, Bootstrap, &rows, 20_000, 8));
        let off = (log - reference) / error.hypot(of_reference);
        assert!(off.abs() < 4.0, "{sd}: {log} ± {error} beside {reference} ± {of_reference}");
    }
}

#[test]
fn the_same_seed_learns_the_same_weights() {
    let [one, other] = [0, 1].map(|_| learned(&Growth, 30));
    assert_eq!(one.1.validation, other.1.validation);
    assert_eq!(one.0.parameters().values(), other.0.parameters().values());
}

#[test]
fn bad_settings_and_no_steps_are_refused() {
    let mut potentials = untrained(&Growth);
    let mut refused = |settings: PotentialLearnConfig| {
        learn_potentials(
            &mut potentials,
            PathSource::Model(&Growth),
            &settings,
            &Seed::from_u64(1),
            |_, _| ControlFlow::Continue(()),
        )
        .unwrap_err()
    };
    for settings in [
        PotentialLearnConfig { sequences: 0, ..few(1) },
        PotentialLearnConfig { horizon: 0, ..few(1) },
        PotentialLearnConfig { with_gaps: f64::NAN, ..few(1) },
        PotentialLearnConfig { clip_norm: 0.0, ..few(1) },
        PotentialLearnConfig { seconds: Some(-1.0), ..few(1) },
    ] {
        assert!(matches!(refused(settings), TrainError::Setting { .. }));
    }
    assert_eq!(potentials.look_ahead(&Growth, &[]).unwrap_err(), LookAheadError::Empty);
}
