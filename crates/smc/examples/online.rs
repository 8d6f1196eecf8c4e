//! Filters a stream of measurements, one at a time, with a model defined here.
//!
//! `seq 1 40 | awk '{print 20*$1*$1/1600 + 3*rand()}' | cargo run --release -p motes-smc --example online`

use motes_models::{Noise, Seed, StateSpaceModel, Step, Stream};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter};

/// A position and its velocity, pushed about at random; the position is measured.
struct Tracker;

impl StateSpaceModel for Tracker {
    fn state_dim(&self) -> usize {
        2
    }

    fn measurement_dim(&self) -> usize {
        1
    }

    fn sample_initial(&self, stream: &mut Stream, state: &mut [f64]) {
        state.fill_with(|| Noise::Gaussian.sample(5.0, stream));
    }

    fn sample_transition(&self, _step: &Step<'_>, previous: &[f64], stream: &mut Stream, state: &mut [f64]) {
        state[0] = previous[0] + previous[1] + Noise::Gaussian.sample(0.1, stream);
        state[1] = previous[1] + Noise::Gaussian.sample(0.3, stream);
    }

    fn log_initial(&self, state: &[f64]) -> f64 {
        Noise::Gaussian.log_density(5.0, state[0]) + Noise::Gaussian.log_density(5.0, state[1])
    }

    fn log_transition(&self, _step: &Step<'_>, previous: &[f64], state: &[f64]) -> f64 {
        Noise::Gaussian.log_density(0.1, state[0] - previous[0] - previous[1])
            + Noise::Gaussian.log_density(0.3, state[1] - previous[1])
    }

    fn log_likelihood(&self, _step: &Step<'_>, state: &[f64], measurement: &[f64]) -> f64 {
        Noise::Gaussian.log_density(1.0, measurement[0] - state[0])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(&Tracker, Bootstrap, FilterSettings::new(2000), stream)?;
    for line in std::io::stdin().lines() {
        filter.step(&[line?.trim().parse()?])?;
        let (mean, ess) = (filter.mean(), filter.effective_sample_size());
        println!("position {:8.3}  velocity {:7.3}  effective particles {ess:6.0}", mean[0], mean[1]);
    }
    eprintln!("log-evidence {:.3}", filter.log_evidence());
    Ok(())
}
