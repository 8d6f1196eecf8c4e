//! Lorenz-96: ten coordinates that push each other around a circle, half of them measured.
//!
//! `cargo run --release -p motes-smc --example lorenz`

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step, simulate};
use motes_smc::{FilterSettings, Linearised, ParticleFilter};

/// `ẋ_i = (x_{i+1} − x_{i−2}) x_{i−1} − x_i + 8` by steps of Runge and Kutta's method, with noise.
struct Lorenz;

const N: usize = 10;
const STEP: f64 = 0.05;

/// `x + by·ẋ(at)`.
fn moved<S: Scalar>(x: [S; N], at: [S; N], by: f64) -> [S; N] {
    let slope = |i: usize| (at[(i + 1) % N] - at[(i + N - 2) % N]) * at[(i + N - 1) % N] - at[i] + 8.0;
    std::array::from_fn(|i| x[i] + slope(i) * by)
}

impl Equations for Lorenz {
    fn dimensions(&self) -> [usize; 2] {
        [N, N / 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..N).for_each(|i| state[i] = draws.draw(normal(8.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x: [S; N] = std::array::from_fn(|i| x[i]);
        let half = moved(x, x, STEP / 2.0);
        let again = moved(x, half, STEP / 2.0);
        let whole = moved(x, again, STEP);
        let end = moved(x, whole, STEP / 2.0);
        // x + (k₁ + 2k₂ + 2k₃ + k₄)/6·Δ, of which each of the four has a share.
        (0..N).for_each(|i| {
            let mean = (half[i] + again[i] * 2.0 + whole[i] + end[i] - x[i] * 2.0) / 3.0;
            state[i] = draws.draw(normal(mean, 0.5));
        });
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        x.iter().step_by(2).for_each(|x| y.push(normal(*x, 0.5)));
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = Seed::from_u64(1);
    let data = simulate(&Lorenz, 100, &mut seed.child("data").stream())?;
    let stream = seed.child("filter").stream();
    let mut filter =
        ParticleFilter::new(&Lorenz, Linearised::new(&Lorenz)?, FilterSettings::new(1000), stream)?;
    for (time, row) in data.measurements.rows().enumerate() {
        filter.step(row)?;
        if time % 10 == 9 {
            let squares =
                filter.mean().iter().zip(data.states.row(time)).map(|(found, x)| (found - x).powi(2));
            let error = (squares.sum::<f64>() / N as f64).sqrt();
            println!(
                "t = {time:2}: error {error:.2}, {:.0} effective particles",
                filter.effective_sample_size()
            );
        }
    }
    Ok(())
}
