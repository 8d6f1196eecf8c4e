//! Each planted bug is caught by the statistic of the test that is there to catch it, and without a bug nothing is.

use motes_models::{ModelShape, Seed};
use motes_proposals::{Backend, Cell, Compute, Family, Parametric, Precision, Rnn, RnnConfig};
use motes_smc::{FilterSettings, ResampleWhen};
use motes_tests::{
    Bug, Forgetful, NEVER_HALF_ALWAYS, OFFSPRING_WEIGHTS, Offspring, PARTICLES, REFUSED, RUNS,
    ScalarGaussian, evidence_scores, is_unbiased, plain_filter_scores, reference, replay, replayed_system,
    small_rnn, systematic_bounds, systematic_variance, systematic_with_a_fixed_offset,
};

/// A score beyond any doubt.
const CAUGHT: f64 = 20.0;

/// The larger of the two scores of each rule.
fn scores(bug: Bug) -> [f64; 3] {
    let scores = NEVER_HALF_ALWAYS.map(|when| plain_filter_scores(bug, when));
    println!("planted: {bug:?}, resampling never, at ½K, always: z of evidence and mean = {scores:.1?}");
    scores.map(|[evidence, mean]| evidence.abs().max(mean.abs()))
}

#[test]
fn a_plain_filter_without_a_bug_is_unbiased() {
    assert!(scores(Bug::Nothing).iter().all(|z| *z < REFUSED));
}

#[test]
fn evidence_without_the_previous_weights() {
    let [never, half, always] = scores(Bug::EvidenceWithoutPreviousWeights);
    assert!(never > CAUGHT && half > CAUGHT);
    assert!(always < REFUSED, "resampling always, it is no bug");
}

#[test]
fn the_density_of_the_first_state_left_out() {
    assert!(scores(Bug::NoInitialDensity).iter().all(|z| *z > CAUGHT));
}

#[test]
fn weights_that_are_not_reset_by_resampling() {
    let [never, half, always] = scores(Bug::WeightsNotReset);
    assert!(never < REFUSED, "resampling never, it is no bug");
    assert!(half > REFUSED && always > REFUSED);
}

#[test]
fn weights_that_are_kept_by_resampling() {
    let [never, half, always] = scores(Bug::WeightsKept);
    assert!(never < REFUSED, "resampling never, it is no bug");
    assert!(half > CAUGHT && always > CAUGHT);
}

#[test]
fn a_density_off_by_a_tenth_in_variance() {
    for resample_when in NEVER_HALF_ALWAYS {
        let settings = FilterSettings { resample_when, ..FilterSettings::new(PARTICLES) };
        let scores = evidence_scores(&reference(), &ScalarGaussian::lying(), settings, RUNS);
        println!("planted: variance off by 10%, {resample_when:?}: z = {scores:.1?}");
        assert!(!is_unbiased(&scores) && scores[0].abs() > CAUGHT);
    }
}

#[test]
fn systematic_resampling_with_a_fixed_offset() {
    let refused = |count| {
        let offspring = Offspring::of(count, |_, ancestors| {
            systematic_with_a_fixed_offset(&OFFSPRING_WEIGHTS, ancestors);
        });
        offspring.check(systematic_variance, systematic_bounds).unwrap_err()
    };
    let (of_eight, of_ten) = (refused(8), refused(10));
    println!("planted: systematic with a fixed offset: of 8 {of_eight}, of 10 {of_ten}");
}

#[test]
fn memory_that_is_not_resampled() {
    let compute = Compute { backend: Backend::Native, precision: Precision::F64 };
    let rnn = Rnn::create(
        &small_rnn(Cell::Lstm),
        &ModelShape::of(&replayed_system()),
        0,
        compute,
        &Seed::from_u64(111),
    )
    .unwrap();
    let found = replay(&Forgetful(rnn), |memory| &memory.0, &[]);
    println!("planted: memory not resampled: {found:.2?}");
    assert!(!found.holds() && found.memory > 1e-3 && found.weights > 1e-3);

    // The evidence does not see it: any memory gives some proposal, weighed by its own density.
    let config = RnnConfig { hidden: 8, ..RnnConfig::paper() };
    let mut wide =
        Rnn::create(&config, &ModelShape::of(&reference().model), 0, compute, &Seed::from_u64(22)).unwrap();
    let mixing = wide.parameters().names().iter().position(|name| name == "covariance.mixing").unwrap();
    wide.parameters_mut().set_host(mixing, &[1.2]).unwrap();
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(PARTICLES) };
    let scores = evidence_scores(&reference(), &Forgetful(wide), settings, RUNS);
    println!("planted: memory not resampled: evidence z = {scores:.1?}");
    assert!(is_unbiased(&scores));
}
