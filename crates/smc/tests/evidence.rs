//! Evidence is unbiased, under every resampling rule, for every proposal; and a wrong density is caught.

mod common;

use common::{NEVER_HALF_ALWAYS, ScalarGaussian, evidence_scores, reference};
use motes_models::LinearGaussian;
use motes_smc::{Bootstrap, Defensive, MinDegeneracy, Proposal};

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
