//! Backward simulation against the exact smoother.

use std::ops::ControlFlow;

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, StateSpaceModel, kalman, simulate};
use motes_smc::{
    Bootstrap, FilterHistory, FilterSettings, ParticleFilter, SmoothedPaths, SmoothingError,
    backward_simulation, backward_simulation_while,
};

const TIMES: usize = 12;

fn problem() -> (LinearGaussian, Measurements) {
    let initial = Gaussian::new("P_0", vec![0.0, 1.0], mat![[1.0, 0.2], [0.2, 0.5]]).unwrap();
    let moves = mat![[0.9, 0.4], [0.0, 0.7]];
    let noise = mat![[0.3, 0.05], [0.05, 0.4]];
    let model = LinearGaussian::new(initial, moves, noise, mat![[1.0, 0.0]], mat![[0.5]]).unwrap();
    let measurements = simulate(&model, TIMES, &mut Seed::from_u64(60).stream()).unwrap().measurements;
    (model, measurements)
}

/// Filters, and draws paths from what the filter was.
fn smoothed(model: &LinearGaussian, measurements: &Measurements, paths: usize, seed: &Seed) -> SmoothedPaths {
    let stream = seed.child("filter").stream();
    let mut filter = ParticleFilter::new(model, Bootstrap, FilterSettings::new(500), stream).unwrap();
    let mut history = FilterHistory::new();
    for row in measurements.rows() {
        filter.step(row).unwrap();
        history.record(&filter).unwrap();
    }
    backward_simulation(model, &history, paths, &seed.child("paths")).unwrap()
}

/// By how many standard errors the mean of some values differs from what is expected.
fn z(values: &[f64], expected: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - expected) / (variance / n).sqrt()
}

/// A walk whose steps are a tenth of what is known of it: few particles lead to a state, and most proposals are refused.
fn precise() -> (LinearGaussian, Measurements) {
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model =
        LinearGaussian::new(initial, mat![[1.0]], mat![[0.03 * 0.03]], mat![[1.0]], mat![[1.0]]).unwrap();
    let measurements = simulate(&model, TIMES, &mut Seed::from_u64(66).stream()).unwrap().measurements;
    (model, measurements)
}

#[test]
fn means_and_variances_are_those_of_the_exact_smoother() {
    hold_against_the_exact_smoother(&problem());
}

#[test]
fn means_and_variances_are_exact_where_the_transition_is_precise() {
    hold_against_the_exact_smoother(&precise());
}

/// Means and variances of many runs have no more than the error of Monte Carlo, and are not those of the filter.
fn hold_against_the_exact_smoother((model, measurements): &(LinearGaussian, Measurements)) {
    let exact = kalman::smooth(&kalman::filter(model, measurements).unwrap()).unwrap().beliefs;
    let runs: Vec<SmoothedPaths> =
        (0..400).map(|run| smoothed(model, measurements, 50, &Seed::from_u64(61).nth(run))).collect();
    let (mut largest, mut filtered_differs) = (0.0_f64, false);
    for (time, belief) in exact.iter().enumerate() {
        for coordinate in 0..model.state_dim() {
            let (mean, variance) = (belief.mean[coordinate], belief.covariance[(coordinate, coordinate)]);
            let means: Vec<f64> = runs.iter().map(|paths| paths.mean(time, coordinate)).collect();
            // Around the exact mean, so that the variance has no bias of its own.
            let variances: Vec<f64> = runs
                .iter()
                .map(|paths| {
                    let off = paths.mean(time, coordinate) - mean;
                    paths.standard_deviation(time, coordinate).powi(2) + off * off
                })
                .collect();
            // 500 particles have a bias of some tenths of a percent, which 20,000 paths see as half a standard error.
            let of_mean = z(&means, mean);
            let of_variance = z(&variances, variance);
            largest = largest.max(of_mean.abs()).max(of_variance.abs());
            assert!(
                of_mean.abs() < 4.5 && of_variance.abs() < 4.5,
                "time {time}: z = {of_mean}, {of_variance}"
            );
            // What leaves out the transition's density, or later measurements, estimates the filter's mean.
            let filtered = kalman::filter(model, measurements).unwrap().steps[time].filtered.mean[coordinate];
            filtered_differs |= z(&means, filtered).abs() > 20.0;
        }
    }
    assert!(filtered_differs, "the test cannot tell a smoother from a filter");
    println!("largest z = {largest:.2}");
}

#[test]
fn any_number_of_threads_draws_the_same_paths() {
    let (model, measurements) = problem();
    let seed = Seed::from_u64(62);
    let on = |threads: usize| {
        let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| smoothed(&model, &measurements, 33, &seed))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
    assert_eq!((one.len(), one.times(), one.path(32).len()), (33, TIMES, 2 * TIMES));
    let quantiles = one.quantiles(3, 1, &[0.0, 0.5, 1.0]);
    let mut values: Vec<f64> = (0..33).map(|path| one.path(path)[3 * 2 + 1]).collect();
    values.sort_by(f64::total_cmp);
    assert_eq!(quantiles, [values[0], values[16], values[32]]);
}

#[test]
fn nothing_to_draw_is_refused() {
    let (model, measurements) = problem();
    let empty = backward_simulation(&model, &FilterHistory::new(), 5, &Seed::from_u64(1));
    assert_eq!(empty.unwrap_err(), SmoothingError::Nothing { name: "the number of times" });
    let mut filter =
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(10), Seed::from_u64(2).stream()).unwrap();
    let mut history = FilterHistory::new();
    filter.step(measurements.row(0)).unwrap();
    history.record(&filter).unwrap();
    let none = backward_simulation(&model, &history, 0, &Seed::from_u64(1));
    assert_eq!(none.unwrap_err(), SmoothingError::Nothing { name: "the number of paths" });
    let many = backward_simulation(&model, &history, usize::MAX / 2, &Seed::from_u64(1));
    assert!(matches!(many.unwrap_err(), SmoothingError::Memory { .. }));
}

#[test]
fn somebody_may_say_to_stop_at_each_time() {
    let (model, measurements) = problem();
    let mut filter =
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(50), Seed::from_u64(3).stream()).unwrap();
    let mut history = FilterHistory::new();
    for row in measurements.rows() {
        filter.step(row).unwrap();
        history.record(&filter).unwrap();
    }
    let until = |paths: usize, last: usize| {
        let mut asked = Vec::new();
        let drawn = backward_simulation_while(&model, &history, paths, &Seed::from_u64(4), |times| {
            asked.push(times);
            if times < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        (drawn, asked)
    };
    let (drawn, asked) = until(40, usize::MAX);
    assert!(drawn.is_ok());
    assert_eq!(asked, (1..=TIMES).collect::<Vec<_>>());
    assert_eq!(until(40, 3), (Err(SmoothingError::Interrupted), vec![1, 2, 3]));
    // So many paths take more than a moment at each time.
    assert_eq!(until(40_000, 1), (Err(SmoothingError::Interrupted), vec![0, 1]));
}

#[test]
fn a_history_with_gaps_or_of_another_model_is_refused() {
    let (model, measurements) = problem();
    let filter =
        || ParticleFilter::new(&model, Bootstrap, FilterSettings::new(10), Seed::from_u64(5).stream());
    let (mut filter, mut history) = (filter().unwrap(), FilterHistory::new());
    let early = history.record(&filter);
    assert_eq!(early, Err(SmoothingError::Skipped { steps: 0, kept: 0 }));
    for row in measurements.rows().take(2) {
        filter.step(row).unwrap();
    }
    assert_eq!(history.record(&filter), Err(SmoothingError::Skipped { steps: 2, kept: 0 }));
    assert!(history.is_empty());

    // Particles of one filter, and then of another.
    let of = |counts: [usize; 2]| {
        let mut history = FilterHistory::new();
        for particles in counts {
            let settings = FilterSettings::new(particles);
            let mut filter =
                ParticleFilter::new(&model, Bootstrap, settings, Seed::from_u64(5).stream()).unwrap();
            for row in measurements.rows().take(history.len() + 1) {
                filter.step(row).unwrap();
            }
            history.record(&filter).unwrap();
        }
        history
    };
    let narrow = LinearGaussian::new(
        Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap(),
        mat![[1.0]],
        mat![[1.0]],
        mat![[1.0]],
        mat![[1.0]],
    )
    .unwrap();
    let draw = |history: FilterHistory| backward_simulation(&model, &history, 5, &Seed::from_u64(1));
    let other = backward_simulation(&narrow, &of([10, 10]), 5, &Seed::from_u64(1));
    assert_eq!(other.unwrap_err(), SmoothingError::OtherFilter { time: 0 });
    assert_eq!(draw(of([5, 100])).unwrap_err(), SmoothingError::OtherFilter { time: 1 });
    assert!(draw(of([100, 5])).is_ok());
}

#[test]
fn paths_say_how_many_particles_they_pass_through() {
    let (model, measurements) = problem();
    let sound = smoothed(&model, &measurements, 300, &Seed::from_u64(63));
    let count = |paths: &SmoothedPaths, time: usize| {
        let states = (0..paths.len()).map(|path| paths.path(path)[2 * time..][..2].to_vec());
        let mut states: Vec<Vec<u64>> =
            states.map(|state| state.into_iter().map(f64::to_bits).collect()).collect();
        states.sort_unstable();
        states.dedup();
        states.len()
    };
    for time in 0..TIMES {
        assert_eq!(sound.distinct_particles(time), count(&sound, time));
        assert!(sound.distinct_particles(time) >= 20 && sound.standard_deviation(time, 0) > 0.1);
    }

    // Only its own ancestor leads to a state.
    let initial = Gaussian::new("P_0", vec![0.0, 1.0], mat![[1.0, 0.2], [0.2, 0.5]]).unwrap();
    let noise = mat![[1e-18, 0.0], [0.0, 1e-18]];
    let moves = mat![[1.0, 0.4], [0.0, 1.0]];
    let model = LinearGaussian::new(initial, moves, noise, mat![[1.0, 0.0]], mat![[1e-5]]).unwrap();
    let measurements = simulate(&model, TIMES, &mut Seed::from_u64(64).stream()).unwrap().measurements;
    let precise = smoothed(&model, &measurements, 300, &Seed::from_u64(65));
    assert_eq!((precise.distinct_particles(0), count(&precise, 0)), (1, 1));
    assert!(precise.mean(0, 0).is_finite() && precise.standard_deviation(0, 0).is_nan());
    assert!(precise.quantiles(0, 1, &[0.0, 0.5]).iter().all(|quantile| quantile.is_nan()));
    // One path has no spread either.
    let one = smoothed(&model, &measurements, 1, &Seed::from_u64(65));
    assert!(one.standard_deviation(TIMES - 1, 0).is_nan());
}
