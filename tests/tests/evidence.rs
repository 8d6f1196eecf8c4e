//! Evidence is unbiased, under every resampling rule, for every proposal; and a wrong density is caught.

use motes_models::{LinearGaussian, Seed, StateSpaceModel};
use motes_proposals::{Backend, Fcnn, FcnnConfig, Learnable};
use motes_smc::{
    Bootstrap, Defensive, FilterSettings, LogWeights, MinDegeneracy, Proposal, ResampleWhen, Resampling,
};
use motes_tests::{NEVER_HALF_ALWAYS, ScalarGaussian, evidence_scores, reference, score};

fn settings(resample_when: ResampleWhen) -> FilterSettings {
    FilterSettings { resample_when, ..FilterSettings::new(64) }
}

fn assert_unbiased<P: Proposal<LinearGaussian> + Clone>(name: &str, proposal: &P) {
    let reference = reference();
    for when in NEVER_HALF_ALWAYS {
        let scores = evidence_scores(&reference, proposal, settings(when), 20_000);
        println!("{name}, {when:?}: z = {scores:.2?}");
        assert!(scores.iter().all(|z| z.abs() < 4.0), "{name}, {when:?}: z = {scores:?}");
    }
}

#[test]
fn bootstrap() {
    assert_unbiased("bootstrap", &Bootstrap);
}

#[test]
fn minimum_degeneracy() {
    let proposal = MinDegeneracy::new(&reference().model).unwrap();
    assert_unbiased("minimum degeneracy", &proposal);
}

#[test]
fn a_gaussian_wider_than_the_optimum() {
    assert_unbiased("wide Gaussian", &ScalarGaussian::wide());
}

#[test]
fn a_collapsed_gaussian_made_safe_by_a_defensive_mixture() {
    // Alone, a proposal this narrow has weights of infinite variance.
    let narrow = ScalarGaussian { variance: 0.01, claimed_variance: 0.01 };
    assert_unbiased("defensive mixture", &Defensive::new(narrow, 0.2).unwrap());
}

#[test]
fn bootstrap_with_every_resampling_scheme() {
    let reference = reference();
    for resampling in [Resampling::Systematic, Resampling::Stratified, Resampling::Residual] {
        let settings =
            FilterSettings { resampling, resample_when: ResampleWhen::Always, ..FilterSettings::new(64) };
        let scores = evidence_scores(&reference, &Bootstrap, settings, 20_000);
        println!("bootstrap, {resampling:?}: z = {scores:.2?}");
        assert!(scores.iter().all(|z| z.abs() < 4.0), "{resampling:?}: z = {scores:?}");
    }
}

/// The planted bug that libraries of this kind have had: an increment that forgets the weights of the step before.
fn score_of_forgetful_evidence(when: ResampleWhen) -> f64 {
    let (reference, seed) = (reference(), Seed::from_u64(24));
    let (model, k) = (&reference.model, 64);
    let ratios: Vec<f64> = seed
        .streams(20_000)
        .iter_mut()
        .map(|stream| {
            let (mut states, mut log_likelihoods) = (vec![0.0; k], vec![0.0; k]);
            let (mut weights, mut ancestors) = (LogWeights::uniform(k), vec![0; k]);
            let mut log_evidence = 0.0;
            for (time, measurement) in reference.measurements.rows().enumerate() {
                let previous = states.clone();
                for (state, previous) in states.iter_mut().zip(previous) {
                    match time {
                        0 => model.sample_initial(stream, std::slice::from_mut(state)),
                        _ => model.sample_transition(time, &[previous], stream, std::slice::from_mut(state)),
                    }
                }
                model.log_likelihoods(time, &states, measurement, &mut log_likelihoods);
                weights.update(&log_likelihoods).unwrap();
                log_evidence += (log_likelihoods.iter().map(|log| log.exp()).sum::<f64>() / k as f64).ln();
                if when.is_due(weights.effective_sample_size(), k) {
                    Resampling::Multinomial.draw(weights.normalised(), stream, &mut ancestors);
                    states = ancestors.iter().map(|&ancestor| states[ancestor]).collect();
                    weights.reset();
                }
            }
            (log_evidence - reference.log_evidence).exp()
        })
        .collect();
    score(&ratios, 1.0)
}

#[test]
fn evidence_that_forgets_the_previous_weights_is_caught_where_it_is_wrong() {
    let [never, half, always] = NEVER_HALF_ALWAYS.map(score_of_forgetful_evidence);
    println!("planted bug, evidence without previous weights: z = {never:.1}, {half:.1}, {always:.1}");
    assert!(never.abs() > 20.0 && half.abs() > 20.0, "the planted bug scored only {never} and {half}");
    assert!(always.abs() < 4.0, "resampling always, it is no bug, and scored {always}");
}

#[test]
fn a_density_off_by_a_tenth_in_variance_is_caught() {
    let reference = reference();
    for when in NEVER_HALF_ALWAYS {
        let [z, _] = evidence_scores(&reference, &ScalarGaussian::lying(), settings(when), 20_000);
        println!("planted bug, {when:?}: z = {z:.1}");
        assert!(z.abs() > 20.0, "the planted bug scored only {z} with {when:?}");
    }
}

fn fcnn() -> Fcnn {
    let config = FcnnConfig { widths: vec![8, 8], ..FcnnConfig::paper() };
    Fcnn::new(&config, &reference().model, 5, Backend::Flex.into(), &Seed::from_u64(22)).unwrap()
}

#[test]
fn an_fcnn_wider_than_the_optimum() {
    // In one dimension K(z) = 1, so that C = 1.2 gives the variance 1.44, whatever the network says.
    let mut proposal = fcnn();
    let mixing = proposal.parameters().len() - 1;
    proposal.parameters_mut().set_host(mixing, &[1.2]).unwrap();
    assert_unbiased("wide fcnn", &proposal);
}

#[test]
fn an_fcnn_as_initialised_made_safe_by_a_defensive_mixture() {
    assert_unbiased("defensive fcnn", &Defensive::new(fcnn(), 0.2).unwrap());
}

#[test]
fn a_trained_and_collapsed_fcnn_made_safe_by_a_defensive_mixture() {
    use motes_train::{TrainConfig, train};
    let (reference, mut proposal) = (reference(), fcnn());
    let config = TrainConfig { steps: 300, ..TrainConfig::paper(16) };
    let mut stream = Seed::from_u64(23).stream();
    let proceed = |_, _| std::ops::ControlFlow::Continue(());
    train(&mut proposal, &reference.model, &reference.measurements, &config, &mut stream, proceed).unwrap();
    let mixing = proposal.parameters().host(proposal.parameters().len() - 1).unwrap()[0];
    assert!(mixing * mixing < 0.05, "the variance {} has not collapsed", mixing * mixing);
    assert_unbiased("defensive trained fcnn", &Defensive::new(proposal, 0.2).unwrap());
}
