//! Measurements that are missing, whole or in part: evidence and means against the Kalman filter.

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, PartialMeasurements, Seed, Step, kalman};
use motes_smc::{
    Bootstrap, FilterBank, FilterSettings, FixedLagSmoother, MinDegeneracy, ParticleFilter, Proposal,
    ResampleWhen,
};

/// Two states, two measurements with correlated noise.
fn model() -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.5, -0.2], mat![[1.0, 0.2], [0.2, 0.8]]).unwrap();
    LinearGaussian::new(
        initial,
        mat![[0.9, 0.2], [-0.1, 0.8]],
        mat![[0.5, 0.1], [0.1, 0.4]],
        mat![[1.0, 0.0], [0.3, 1.0]],
        mat![[0.8, 0.5], [0.5, 1.0]],
    )
    .unwrap()
}

/// Whole, half and not at all.
fn measurements() -> PartialMeasurements {
    let values = [
        [Some(0.9), None],
        [Some(0.1), Some(-1.2)],
        [None, None],
        [None, Some(0.8)],
        [Some(1.4), Some(0.6)],
        [None, None],
    ];
    PartialMeasurements::new(2, values.concat()).unwrap()
}

/// Takes each of these measurements.
fn each_step(mut take: impl FnMut(&Step<'_>, &[Option<f64>])) {
    measurements().rows().enumerate().for_each(|(index, row)| take(&Step::of_index(index), row));
}

fn score(values: &[f64], expected: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - expected) / (variance / n).sqrt()
}

/// Scores of the mean of Ẑ/Z and of (Ẑ/Z)·x̂_T over 20,000 filters.
fn scores(proposal: impl Proposal<LinearGaussian>, settings: FilterSettings) -> [f64; 2] {
    let (model, runs) = (model(), 20_000);
    let exact = kalman::filter_partial(&model, &measurements()).unwrap();
    let mut bank = FilterBank::new(&model, proposal, settings, runs, &Seed::from_u64(81)).unwrap();
    each_step(|step, row| bank.step_at(step, row).unwrap());
    let ratio = |run| (bank.log_evidence(run) - exact.log_evidence()).exp();
    let mean = |run| {
        let mut mean = [0.0; 2];
        bank.mean(run, &mut mean);
        ratio(run) * mean[1]
    };
    let (ratios, means): (Vec<f64>, Vec<f64>) = (0..runs).map(|run| (ratio(run), mean(run))).unzip();
    [score(&ratios, 1.0), score(&means, exact.steps[5].filtered.mean[1])]
}

#[test]
fn evidence_and_means_are_those_of_the_kalman_filter() {
    for resample_when in [ResampleWhen::Never, ResampleWhen::EssBelow(0.5), ResampleWhen::Always] {
        for defensive_weight in [None, Some(0.2)] {
            let settings = FilterSettings { resample_when, defensive_weight, ..FilterSettings::new(64) };
            let proposal = MinDegeneracy::new(&model()).unwrap();
            for (name, z) in [
                ("bootstrap", scores(Bootstrap, settings)),
                ("minimum degeneracy", scores(proposal, settings)),
            ] {
                println!("{name}, {resample_when:?}, {defensive_weight:?}: z = {z:.2?}");
                assert!(z.iter().all(|z| z.abs() < 4.0), "{name}, {resample_when:?}: z = {z:?}");
            }
        }
    }
}

/// The entries that are there choose the draws, too: weights are closer to equal than those of the blind transition.
#[test]
fn what_is_there_of_a_measurement_is_used_to_draw() {
    let model = model();
    fn run(proposal: impl Proposal<LinearGaussian>, model: &LinearGaussian) -> f64 {
        let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(20_000) };
        let stream = Seed::from_u64(84).stream();
        let mut filter = ParticleFilter::new(model, proposal, settings, stream).unwrap();
        filter.step(&[0.9, 0.1]).unwrap();
        filter.step_at(&Step::of_index(1), &[None, Some(-1.2)]).unwrap();
        filter.effective_sample_size()
    }
    let designed = run(MinDegeneracy::new(&model).unwrap(), &model);
    let blind = run(Bootstrap, &model);
    assert!(designed > 1.1 * blind, "{designed} of 20,000 beside {blind}");
}

fn filter(model: &LinearGaussian) -> ParticleFilter<&LinearGaussian, MinDegeneracy> {
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(50) };
    let proposal = MinDegeneracy::new(model).unwrap();
    ParticleFilter::new(model, proposal, settings, Seed::from_u64(82).stream()).unwrap()
}

#[test]
fn whole_measurements_and_none_at_all_are_the_two_ends() {
    let model = model();
    let (mut partly, mut plainly) = (filter(&model), filter(&model));
    each_step(|step, measurement| {
        partly.step_at(step, measurement).unwrap();
        match measurement {
            [Some(a), Some(b)] => plainly.step(&[*a, *b]).unwrap(),
            _ => plainly.step_at(step, measurement).unwrap(),
        }
        assert_eq!(partly.particles(), plainly.particles());
        assert_eq!(partly.log_evidence(), plainly.log_evidence());
    });
    assert_eq!(partly.time(), 6);
    // Nothing was measured at the last time: equal weights after resampling, and no evidence.
    assert!((partly.effective_sample_size() - 50.0).abs() < 1e-9);
}

#[test]
fn smoothing_looks_back_over_gaps() {
    let (model, settings) = (model(), FilterSettings::new(20_000));
    let filter = ParticleFilter::new(&model, Bootstrap, settings, Seed::from_u64(83).stream()).unwrap();
    let mut smoother = FixedLagSmoother::new(filter, 3);
    each_step(|step, row| smoother.step_at(step, row).unwrap());
    let filtered = kalman::filter_partial(&model, &measurements()).unwrap();
    let exact = kalman::smooth(&filtered).unwrap();
    let mut mean = [0.0; 2];
    for back in 0..=3 {
        smoother.mean(back, &mut mean).unwrap();
        let belief = &exact.beliefs[5 - back];
        for (i, mean) in mean.into_iter().enumerate() {
            assert!((mean - belief.mean[i]).abs() < 0.05, "{back} back: {mean} for {}", belief.mean[i]);
        }
    }
}

#[test]
fn an_entry_that_is_no_number_is_refused_and_changes_nothing() {
    let model = model();
    let mut filter = filter(&model);
    filter.step(&[0.3, 0.1]).unwrap();
    let before = filter.particles().to_vec();
    let error = filter.step_at(&Step::of_index(1), &[None, Some(f64::NAN)]).unwrap_err().to_string();
    assert_eq!(error, "the measurement at row 1, column 1 is NaN; it must be finite");
    let error = filter.step_at(&Step::of_index(1), &[None]).unwrap_err().to_string();
    assert_eq!(error, "measurements have width 1; this model measures 2 numbers at each time");
    assert_eq!((filter.time(), filter.particles()), (1, before.as_slice()));
    filter.step_at(&Step::of_index(1), &[None, Some(0.2)]).unwrap();
}
