//! Evidence is unbiased, under every resampling rule, for every proposal; and a wrong density is caught.

use motes_models::{LinearGaussian, Seed};
use motes_proposals::{Backend, Fcnn, FcnnConfig, Learnable};
use motes_smc::{Bootstrap, Defensive, MinDegeneracy, Proposal};
use motes_tests::{NEVER_HALF_ALWAYS, ScalarGaussian, evidence_scores, reference};

fn assert_unbiased<P: Proposal<LinearGaussian> + Clone>(name: &str, proposal: &P) {
    let reference = reference();
    for when in NEVER_HALF_ALWAYS {
        let scores = evidence_scores(&reference, proposal, when, 20_000);
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
fn a_density_off_by_a_tenth_in_variance_is_caught() {
    let reference = reference();
    for when in NEVER_HALF_ALWAYS {
        let [z, _] = evidence_scores(&reference, &ScalarGaussian::lying(), when, 20_000);
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
    assert_unbiased("defensive trained fcnn", &Defensive::new(proposal, 0.2).unwrap());
}
