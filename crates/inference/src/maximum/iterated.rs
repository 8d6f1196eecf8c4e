//! Iterated filtering: swarms of parameters that go uphill while they filter (Ionides, Nguyen, Atchadé, Stoev and King, 2015).

use motes_models::{Seed, fill_standard_normal};
use serde::{Deserialize, Serialize};

use super::settings::IteratedSettings;
use crate::likelihood::{PerturbedLikelihood, RandomWalk};
use crate::parallel::map_on_threads;

/// How far a coordinate goes in the first pass, in standard deviations of the prior.
const SPREAD: f64 = 0.6;

/// How far it goes in the last pass, as a share of that.
const COOLED: f64 = 0.1;

/// Beside a maximum that was found passes are fewer by this factor, and walks shorter.
const SHORTER: usize = 5;

/// Swarms under way, all of which have made as many passes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Swarms {
    /// Positions (`K×D`) of each; nothing before the first pass.
    positions: Vec<Vec<f64>>,
    passes: usize,
}

impl Swarms {
    /// How many passes each has made.
    pub(super) fn passes(&self) -> usize {
        self.passes
    }

    /// Where they are: the mean (`D`) of each.
    pub(super) fn centres(&self, d: usize) -> Vec<Vec<f64>> {
        self.positions.iter().map(|positions| mean(positions, d)).collect()
    }

    /// Takes each of so many swarms through the data once more; the first time each is drawn from the prior.
    pub(super) fn advance<E: Send>(
        &mut self,
        likelihood: &dyn PerturbedLikelihood<Error = E>,
        settings: IteratedSettings,
        [count, d]: [usize; 2],
        seed: &Seed,
    ) -> Result<(), E> {
        if self.positions.is_empty() {
            let of_prior = |number: usize| {
                let mut positions = vec![0.0; settings.particles * d];
                fill_standard_normal(&mut seed.nth(number as u64).child("prior").stream(), &mut positions);
                positions
            };
            self.positions = (0..count).map(of_prior).collect();
        }
        let walk = walk(SPREAD, self.passes, settings.passes, None);
        let moved = map_on_threads(&self.positions, |number, positions| {
            let mut positions = positions.clone();
            let seed = seed.nth(number as u64).child("pass").nth(self.passes as u64);
            likelihood.pass(&mut positions, walk, &seed).map(|()| positions)
        });
        self.positions = moved.into_iter().collect::<Result<Vec<Vec<f64>>, E>>()?;
        self.passes += 1;
        Ok(())
    }
}

/// Where a swarm is after a few short passes that begin at `v` (`D`), with one coordinate that stays as it is.
pub(super) fn with_one_fixed<E: Send>(
    likelihood: &dyn PerturbedLikelihood<Error = E>,
    v: &[f64],
    fixed: usize,
    settings: IteratedSettings,
    seed: &Seed,
) -> Result<Vec<f64>, E> {
    let mut positions = v.repeat(settings.particles);
    let passes = settings.passes.div_ceil(SHORTER);
    for pass in 0..passes {
        let walk = walk(SPREAD / SHORTER as f64, pass, passes, Some(fixed));
        likelihood.pass(&mut positions, walk, &seed.nth(pass as u64))?;
    }
    Ok(mean(&positions, v.len()))
}

/// The walk of a pass of so many, of which the first begins with a spread and the last ends with a share of it.
fn walk(spread: f64, pass: usize, passes: usize, fixed: Option<usize>) -> RandomWalk {
    let cooling = COOLED.powf(1.0 / passes as f64);
    RandomWalk { spread: spread * cooling.powi(pass as i32), cooling, fixed }
}

/// The mean of rows (`K×D`).
fn mean(positions: &[f64], d: usize) -> Vec<f64> {
    let mut mean = vec![0.0; d];
    for position in positions.chunks_exact(d) {
        mean.iter_mut().zip(position).for_each(|(mean, v)| *mean += v);
    }
    let particles = (positions.len() / d) as f64;
    mean.iter().map(|sum| sum / particles).collect()
}
