//! The fixed-lag smoother against the Kalman smoother of the measurements so far.

use faer::mat;
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, kalman, simulate};
use motes_smc::{
    Bootstrap, FilterSettings, FixedLagSmoother, MinDegeneracy, ParticleFilter, Proposal, ResampleWhen,
};

const HORIZON: usize = 12;
const LAG: usize = 4;

fn model() -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.5, -1.0], mat![[1.0, 0.3], [0.3, 2.0]]).unwrap();
    let transition = mat![[0.9, 0.2], [-0.1, 0.8]];
    LinearGaussian::new(initial, transition, mat![[0.5, 0.1], [0.1, 0.4]], mat![[1.0, 0.5]], mat![[0.6]])
        .unwrap()
}

/// The largest difference between a coordinate's estimate and `E[x_{t−ℓ} | y_{0:t}]`, over all times and lags.
fn largest_error(proposal: impl Proposal<LinearGaussian>, when: ResampleWhen) -> f64 {
    let model = model();
    let trajectory = simulate(&model, HORIZON, &mut Seed::from_u64(31).stream()).unwrap();
    let settings = FilterSettings { resample_when: when, ..FilterSettings::new(50_000) };
    let filter = ParticleFilter::new(&model, proposal, settings, Seed::from_u64(32).stream()).unwrap();
    let mut smoother = FixedLagSmoother::new(filter, LAG);
    assert_eq!(smoother.reach(), None);
    let (mut largest, mut mean) = (0.0_f64, [0.0; 2]);
    for (time, measurement) in trajectory.measurements.rows().enumerate() {
        smoother.step(measurement).unwrap();
        assert_eq!(smoother.reach(), Some(time.min(LAG)));
        let so_far: Vec<f64> = trajectory.measurements.rows().take(time + 1).flatten().copied().collect();
        let filtered = kalman::filter(&model, &Measurements::new(1, so_far).unwrap()).unwrap();
        let exact = kalman::smooth(&filtered).unwrap();
        for back in 0..=time.min(LAG) {
            smoother.mean(back, &mut mean).unwrap();
            for (found, expected) in mean.iter().zip(exact.beliefs[time - back].mean.iter()) {
                largest = largest.max((found - expected).abs());
            }
        }
    }
    largest
}

#[test]
fn means_of_paths_are_those_of_the_kalman_smoother() {
    let designed = MinDegeneracy::new(&model()).unwrap();
    for when in [ResampleWhen::PAPER, ResampleWhen::Always] {
        // Some 4 standard errors of a mean over 10,000 independent states of standard deviation 1.
        assert!(largest_error(Bootstrap, when) < 0.04);
        assert!(largest_error(designed.clone(), when) < 0.04);
    }
}

#[test]
fn weights_without_ancestors_would_be_noticed() {
    let model = model();
    let trajectory = simulate(&model, HORIZON, &mut Seed::from_u64(31).stream()).unwrap();
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(50_000) };
    let mut filter = ParticleFilter::new(&model, Bootstrap, settings, Seed::from_u64(32).stream()).unwrap();
    let mut generations = Vec::new();
    for measurement in trajectory.measurements.rows() {
        filter.step(measurement).unwrap();
        generations.push(filter.particles().to_vec());
    }
    let filtered = kalman::filter(&model, &trajectory.measurements).unwrap();
    let exact = &kalman::smooth(&filtered).unwrap().beliefs[HORIZON - 1 - LAG].mean;
    let earlier = generations[HORIZON - 1 - LAG].chunks_exact(2);
    let mut wrong = [0.0; 2];
    for (weight, state) in filter.weights().normalised().iter().zip(earlier) {
        wrong.iter_mut().zip(state).for_each(|(wrong, value)| *wrong += weight * value);
    }
    let error =
        wrong.iter().zip(exact.iter()).map(|(wrong, exact)| (wrong - exact).abs()).fold(0.0, f64::max);
    assert!(error > 0.1, "{error}");
}

#[test]
fn looking_back_too_far_is_refused() {
    let model = model();
    let filter =
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(10), Seed::from_u64(1).stream()).unwrap();
    let mut smoother = FixedLagSmoother::new(filter, 3);
    // Before the first step there is nothing to look at.
    assert!(smoother.mean(0, &mut [0.0; 2]).is_err());
    smoother.step(&[0.1]).unwrap();
    assert!(smoother.mean(0, &mut [0.0; 2]).is_ok());
    let said = smoother.mean(1, &mut [0.0; 2]).unwrap_err().to_string();
    assert!(said.contains("look back is 1"), "{said}");
}
