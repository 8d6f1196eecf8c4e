//! Forecasts from a filter that goes on: after each measurement a copy of it steps ahead without any.
//!
//! `seq 1 40 | awk '{print 20*$1*$1/1600 + 3*rand()}' | cargo run --release -p motes-smc --example forecast`

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter};

/// How many steps to look ahead.
const AHEAD: usize = 3;

/// A level that drifts by a slowly changing slope; the level is measured.
struct Trend;

impl Equations for Trend {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0));
        state[1] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] + x[1], 0.1));
        state[1] = draws.draw(normal(x[1], 0.2));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(&Trend, Bootstrap, FilterSettings::new(2000), stream)?;
    for line in std::io::stdin().lines() {
        filter.step(&[line?.trim().parse()?])?;
        print!("level {:7.3}", filter.mean()[0]);
        // The copy has the particles and weights of now. What it does changes nothing in the filter.
        let mut forecast = filter.clone();
        for ahead in 1..=AHEAD {
            forecast.step_at(&Step::of_index(forecast.time()), &[None])?;
            let quantiles = forecast.quantiles(0, &[0.05, 0.95]);
            print!("   in {ahead}: {:7.3} to {:7.3}", quantiles[0], quantiles[1]);
        }
        println!();
    }
    Ok(())
}
