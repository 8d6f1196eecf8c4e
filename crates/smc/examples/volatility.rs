//! Stochastic volatility: the width of a return hides in its size alone.
//!
//! `cargo run --release -p motes-smc --example volatility`

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step, simulate};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter};

/// The logarithm of a variance, which comes back to its mean.
struct Volatility;

impl Equations for Volatility {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0 / (1.0 - 0.91_f64.powi(2)).sqrt()));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.91, 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] / 2.0).exp() * 0.5));
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = Seed::from_u64(1);
    let data = simulate(&Volatility, 250, &mut seed.child("data").stream())?;
    let stream = seed.child("filter").stream();
    let mut filter = ParticleFilter::new(&Volatility, Bootstrap, FilterSettings::new(1000), stream)?;
    for (time, row) in data.measurements.rows().enumerate() {
        filter.step(row)?;
        if time % 25 == 0 {
            let (truth, found) = (data.states.row(time)[0], filter.mean()[0]);
            println!("t = {time:3}: return {:6.2}, volatility {found:5.2}, in truth {truth:5.2}", row[0]);
        }
    }
    println!("log-evidence {:.1}", filter.log_evidence());
    Ok(())
}
