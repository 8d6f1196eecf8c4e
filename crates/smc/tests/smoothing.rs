//! Backward simulation against the exact smoother.

use std::ops::ControlFlow;

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, kalman, simulate};
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

#[test]
fn means_and_variances_are_those_of_the_exact_smoother() {
    let (model, measurements) = problem();
    let exact = kalman::smooth(&model, &kalman::filter(&model, &measurements).unwrap()).unwrap().beliefs;
    let runs: Vec<SmoothedPaths> =
        (0..400).map(|run| smoothed(&model, &measurements, 50, &Seed::from_u64(61).nth(run))).collect();
    let (mut largest, mut filtered_differs) = (0.0_f64, false);
    for (time, belief) in exact.iter().enumerate() {
        for coordinate in 0..2 {
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
            let filtered =
                kalman::filter(&model, &measurements).unwrap().steps[time].filtered.mean[coordinate];
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
fn paths_are_drawn_in_portions_between_which_somebody_may_say_to_stop() {
    let (model, measurements) = problem();
    // 32 paths of two times and so many particles are a portion, or as many as there are threads.
    let settings = FilterSettings::new(1 << 18);
    let mut filter = ParticleFilter::new(&model, Bootstrap, settings, Seed::from_u64(3).stream()).unwrap();
    let mut history = FilterHistory::new();
    for time in 0..2 {
        filter.step(measurements.row(time)).unwrap();
        history.record(&filter).unwrap();
    }
    let on = |threads: usize, most: usize| {
        let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut asked = Vec::new();
        let drawn = pool.install(|| {
            backward_simulation_while(&model, &history, 40, &Seed::from_u64(4), |drawn| {
                asked.push(drawn);
                if drawn < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            })
        });
        (drawn, asked)
    };
    let (portions, asked) = on(1, usize::MAX);
    assert_eq!(asked, [32, 40]);
    let (whole, asked) = on(64, usize::MAX);
    assert_eq!(asked, [40]);
    assert_eq!(portions, whole);
    assert_eq!(on(1, 32), (Err(SmoothingError::Interrupted), vec![32]));
}
