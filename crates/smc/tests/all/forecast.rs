//! A forecast by a copy of a filter: against the Kalman prediction, with the original none the wiser.

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, PartialMeasurements, Seed, Step, kalman, simulate};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter};

const HORIZON: usize = 10;
const AHEAD: usize = 5;
const PARTICLES: usize = 100_000;

#[test]
fn a_forecast_is_the_kalman_prediction_and_the_filter_goes_on_as_if_there_were_none() {
    let initial = Gaussian::new("P_0", vec![0.0, 1.0], mat![[1.0, 0.0], [0.0, 0.5]]).unwrap();
    let (moves, noise) = (mat![[1.0, 1.0], [0.0, 0.9]], mat![[0.1, 0.0], [0.0, 0.2]]);
    let model = LinearGaussian::new(initial, moves, noise, mat![[1.0, 0.0]], mat![[0.5]]).unwrap();
    let data = simulate(&model, HORIZON + 1, &mut Seed::from_u64(40).stream()).unwrap().measurements;
    let new = || {
        let stream = Seed::from_u64(41).stream();
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(PARTICLES), stream).unwrap()
    };
    let (mut asked, mut never_asked) = (new(), new());
    for measurement in data.rows().take(HORIZON) {
        asked.step(measurement).unwrap();
        never_asked.step(measurement).unwrap();
    }

    let known = data.rows().take(HORIZON).map(|row| Some(row[0]));
    let ahead = known.chain([None; AHEAD]).collect();
    let exact = kalman::filter_partial(&model, &PartialMeasurements::new(1, ahead).unwrap()).unwrap();
    let mut forecast = asked.clone();
    for step in &exact.steps[HORIZON..] {
        forecast.step_at(&Step::of_index(forecast.time()), &[None]).unwrap();
        for coordinate in 0..2 {
            let sd = step.filtered.covariance[(coordinate, coordinate)].sqrt();
            let quantiles = forecast.quantiles(coordinate, &[0.05, 0.5, 0.95]);
            for (found, standard) in quantiles.iter().zip([-1.6449, 0.0, 1.6449]) {
                let expected = step.filtered.mean[coordinate] + standard * sd;
                // A quantile of 5 % has the standard error √(0.05·0.95/n)/0.103 sd: at 10,000 effective particles 0.021 sd, four of which are allowed.
                assert!((found - expected).abs() < 0.085 * sd, "{found} for {expected}, sd {sd}");
            }
        }
    }

    let shown = |filter: &ParticleFilter<&LinearGaussian, Bootstrap>| {
        (
            filter.particles().to_vec(),
            filter.weights().clone(),
            filter.ancestors().to_vec(),
            filter.log_evidence(),
        )
    };
    assert!(shown(&asked) == shown(&never_asked) && asked.time() == HORIZON);
    // Its stream, too: the next step draws what it would have drawn.
    asked.step(data.row(HORIZON)).unwrap();
    never_asked.step(data.row(HORIZON)).unwrap();
    assert!(shown(&asked) == shown(&never_asked));
}
