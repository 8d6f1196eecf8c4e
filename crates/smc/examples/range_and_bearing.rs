//! A target that moves in the plane, seen by its distance and its direction: the linearised proposal beside bootstrap.
//!
//! `cargo run --release -p motes-smc --example range_and_bearing`

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Measurements, Seed, Step, simulate};
use motes_smc::{Bootstrap, FilterSettings, Linearised, ParticleFilter, Proposal};

/// Position and velocity in two dimensions.
struct Target;

impl Equations for Target {
    fn dimensions(&self) -> [usize; 2] {
        [4, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        let starts = [(5.0, 1.0), (5.0, 1.0), (0.2, 0.1), (-0.1, 0.1)];
        for (state, (mean, sd)) in state.iter_mut().zip(starts) {
            *state = draws.draw(normal(mean, sd));
        }
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(x[i] + x[i + 2], 0.05)));
        (2..4).for_each(|i| state[i] = draws.draw(normal(x[i], 0.05)));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal((x[0] * x[0] + x[1] * x[1]).sqrt(), 0.1));
        y.push(normal(x[1].atan2(x[0]), 0.02));
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = Seed::from_u64(1);
    let data = simulate(&Target, 100, &mut seed.child("data").stream())?;
    println!("bootstrap:  {}", filtered(Bootstrap, &data.measurements, &seed)?);
    println!("linearised: {}", filtered(Linearised::new(&Target)?, &data.measurements, &seed)?);
    Ok(())
}

/// Filters with 300 particles and says how that went.
fn filtered(
    proposal: impl Proposal<Target>,
    measurements: &Measurements,
    seed: &Seed,
) -> Result<String, Box<dyn std::error::Error>> {
    let mut filter =
        ParticleFilter::new(&Target, proposal, FilterSettings::new(300), seed.child("filter").stream())?;
    let mut effective = 0.0;
    for row in measurements.rows() {
        filter.step(row)?;
        effective += filter.effective_sample_size() / measurements.len() as f64;
    }
    Ok(format!("{effective:.0} effective particles, log-evidence {:.1}", filter.log_evidence()))
}
