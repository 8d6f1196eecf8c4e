//! Trajectories of a filter that looks ahead: what its weights know of later measurements is not said twice.

use motes_models::Seed;
use motes_smc::{FilterHistory, LookAhead, ParticleFilter, RecordedStep, backward_simulation};

use crate::common::settings;
use crate::silent::{Level, level_that_jumps};

/// The path about which potentials are made is the smoothed mean of a linear Gaussian model.
#[test]
fn smoothed_means_are_those_of_the_kalman_smoother() {
    const PATHS: usize = 2000;
    let rows = level_that_jumps();
    let ahead = LookAhead::new(&Level, &rows).unwrap();
    let seed = Seed::from_u64(3);
    let stream = seed.child("filter").stream();
    let mut filter = ParticleFilter::new(&Level, ahead.clone(), settings(1000, None), stream).unwrap();
    let mut history = FilterHistory::new();
    for RecordedStep { step, measurement } in &rows {
        filter.step_at(&step.step(), measurement).unwrap();
        history.record(&filter).unwrap();
    }
    let paths = backward_simulation(&Level, &history, PATHS, &seed.child("paths")).unwrap();
    assert!(!paths.follow_ancestors());
    for (time, exact) in ahead.path().enumerate() {
        let (mean, sd) = (paths.mean(time, 0), paths.standard_deviation(time, 0));
        // Half as many paths are independent, at the least.
        let error = sd / (PATHS as f64 / 2.0).sqrt();
        assert!((mean - exact[0]).abs() < 4.5 * error, "t = {time}: {mean} ± {error} and {}", exact[0]);
        assert!((0.1..0.2).contains(&sd), "t = {time}: {sd}");
    }
}
