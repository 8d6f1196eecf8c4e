//! Filters a stream of measurements, one at a time, with a model defined here.
//!
//! `seq 1 40 | awk '{print 20*$1*$1/1600 + 3*rand()}' | cargo run --release -p motes-smc --example online`

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter};

/// A position and its velocity, pushed about at random; the position is measured.
struct Tracker;

impl Equations for Tracker {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state.fill_with(|| draws.draw(normal(0.0, 5.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] + x[1], 0.1));
        state[1] = draws.draw(normal(x[1], 0.3));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
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
