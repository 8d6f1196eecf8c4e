//! Standard errors of log-evidences by small filters, and coordinates that ran out of values.

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, kalman, simulate};
use motes_smc::{Bootstrap, EvidenceCheck, EvidenceWarning, FilterSettings, ParticleFilter};

/// One coordinate with the coefficient `a` and noise of variance `q`, measured with unit variance.
fn walk(a: f64, q: f64) -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    LinearGaussian::new(initial, mat![[a]], mat![[q]], mat![[1.0]], mat![[1.0]]).unwrap()
}

/// A walk and a constant, whose sum is measured.
fn with_constant(noise: f64) -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.0, 0.0], mat![[0.25, 0.0], [0.0, 4.0]]).unwrap();
    let (moves, noise) = (mat![[0.8, 0.0], [0.0, 1.0]], mat![[0.09, 0.0], [0.0, noise]]);
    LinearGaussian::new(initial, moves, noise, mat![[1.0, 1.0]], mat![[0.04]]).unwrap()
}

fn drawn(model: &LinearGaussian, steps: usize) -> Measurements {
    simulate(model, steps, &mut Seed::from_u64(70).stream()).unwrap().measurements
}

/// A filter that took all measurements, with its check.
fn run<'m>(
    model: &'m LinearGaussian,
    measurements: &Measurements,
    particles: usize,
    seed: &Seed,
) -> (ParticleFilter<&'m LinearGaussian, Bootstrap>, EvidenceCheck<&'m LinearGaussian, Bootstrap>) {
    let settings = FilterSettings::new(particles);
    let mut filter = ParticleFilter::new(model, Bootstrap, settings, seed.stream()).unwrap();
    let mut check = EvidenceCheck::new(model, Bootstrap, settings, &seed.child("check")).unwrap();
    for row in measurements.rows() {
        step(&mut filter, &mut check, row);
    }
    (filter, check)
}

fn step<'m>(
    filter: &mut ParticleFilter<&'m LinearGaussian, Bootstrap>,
    check: &mut EvidenceCheck<&'m LinearGaussian, Bootstrap>,
    row: &[f64],
) {
    filter.step(row).unwrap();
    let measurement: Vec<Option<f64>> = row.iter().copied().map(Some).collect();
    check.advance(&filter.bank().last_step(), &measurement);
    check.take_in(filter, &measurement);
}

#[test]
fn the_standard_error_is_the_actual_one() {
    const RUNS: u64 = 100;
    let model = walk(0.9, 1.0);
    let measurements = drawn(&model, 100);
    let exact = kalman::filter(&model, &measurements).unwrap().log_evidence();
    // Small filters of 25, 25 and 75 particles.
    for particles in [100, 300, 1200] {
        let (mut actual, mut estimated, mut within) = (0.0, 0.0, 0);
        for run_number in 0..RUNS {
            let seed = Seed::from_u64(71).nth(particles as u64).nth(run_number);
            let (filter, check) = run(&model, &measurements, particles, &seed);
            let (off, error) = (filter.log_evidence() - exact, check.standard_error().unwrap());
            actual += off * off / RUNS as f64;
            estimated += error * error / RUNS as f64;
            within += u32::from(off.abs() < 2.0 * error);
        }
        // The larger of two estimates of each block, and again of all, is above the actual variance, by up to a factor of 2; 100 runs tell that to four times √(2/100).
        let ratio = estimated / actual;
        assert!((0.6..3.2).contains(&ratio), "{particles}: {ratio}");
        // 95 %, less four standard deviations of 100 runs.
        assert!(within >= 86, "{particles}: {within}");
    }
}

#[test]
fn where_the_level_shifts_and_the_variance_falls_slowly_the_standard_error_is_above_half_of_the_actual_one() {
    const RUNS: u64 = 60;
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model = LinearGaussian::new(initial, mat![[1.0]], mat![[0.04]], mat![[1.0]], mat![[0.09]]).unwrap();
    let shift = |time: usize| match time {
        0..40 => 0.0,
        40..80 => 2.0,
        _ => -0.5,
    };
    let values = drawn(&model, 120).rows().enumerate().map(|(time, row)| row[0] + shift(time)).collect();
    let measurements = Measurements::new(1, values).unwrap();
    let exact = kalman::filter(&model, &measurements).unwrap().log_evidence();
    let (mut actual, mut estimated) = (0.0, vec![]);
    for number in 0..RUNS {
        let (filter, check) = run(&model, &measurements, 1000, &Seed::from_u64(75).nth(number));
        actual += (filter.log_evidence() - exact).powi(2) / RUNS as f64;
        estimated.push(check.standard_error().unwrap());
    }
    estimated.sort_by(f64::total_cmp);
    // By variances that fall as 1/K it would be a third. It is rather too large where four small filters are far apart.
    let ratio = estimated[estimated.len() / 2] / actual.sqrt();
    assert!((0.5..3.0).contains(&ratio), "{ratio}");
}

#[test]
fn a_constant_that_ran_out_of_values_is_named_and_a_coordinate_that_moves_is_not() {
    let named = |model: &LinearGaussian| {
        let (_, check) = run(model, &drawn(model, 100), 500, &Seed::from_u64(72));
        let found = check.warnings().into_iter().filter_map(|warning| match warning {
            EvidenceWarning::FewAncestors { coordinate, .. } => Some(coordinate),
            _ => None,
        });
        found.collect::<Vec<_>>()
    };
    assert_eq!(named(&with_constant(1e-10)), [1]);
    assert_eq!(named(&with_constant(0.09)), [0; 0]);
}

#[test]
fn a_check_that_was_written_down_goes_on_as_it_would_have() {
    let model = walk(0.9, 1.0);
    let measurements = drawn(&model, 60);
    let half = Measurements::new(1, measurements.values()[..30].to_vec()).unwrap();
    let (mut filter, mut check) = run(&model, &half, 400, &Seed::from_u64(73));
    let mut restored = EvidenceCheck::restore(&model, Bootstrap, check.snapshot()).unwrap();
    let mut copy = ParticleFilter::restore(&model, Bootstrap, filter.snapshot()).unwrap();
    for row in measurements.rows().skip(30) {
        step(&mut filter, &mut check, row);
        step(&mut copy, &mut restored, row);
    }
    assert_eq!(restored.standard_error(), check.standard_error());
    assert_eq!(restored.warnings(), check.warnings());
}

#[test]
fn fewer_than_sixteen_particles_have_no_error() {
    let model = walk(0.9, 1.0);
    let measurements = drawn(&model, 5);
    let error = |particles| run(&model, &measurements, particles, &Seed::from_u64(74)).1.standard_error();
    assert_eq!([1, 2, 3, 15].map(error), [None; 4]);
    assert!(error(16).is_some_and(|error| error > 0.0));
}
